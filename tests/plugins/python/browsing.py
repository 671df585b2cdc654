# SPDX-License-Identifier: Apache-2.0
"""The viewer's page in Chromium, for tests that look at its pixels.

Needs Debian's chromium and PyPI's playwright; without them these tests are skipped.
"""

import os
import shutil

import numpy
import OpenImageIO
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright drives the browser: pip install playwright")

from viewing import Viewer  # noqa: E402

CHROMIUM = os.environ.get("SCRIM_CHROMIUM") or shutil.which("chromium")
needs_chromium = pytest.mark.skipif(not CHROMIUM, reason="no chromium; SCRIM_CHROMIUM names another one")
# Without a graphics unit, and as root, as continuous integration has it.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
PATIENCE = 60_000  # milliseconds

PLACE, SIZE = 0.8, 0.35  # of the ball, to the right of the middle

# A ball, lit in red from the right and in blue from the left.
BALL = f"""\
[camera]
position = [0, 0, 5]   # the eye
target = [0, 0, 0]
fov = 36
resolution = [256, 192]

[[volume]]
name = "ball"
source = "primitives"
parameters = {{ shapes = "sphere radius=1", resolution = 24 }}
transform = {{ translate = [{PLACE}, 0, 0], scale = {SIZE} }}
density = {{ scale = 20 }}

[[light]]
name = "red"
type = "distant"
direction = [-1, 0, 0]
color = [1, 0, 0]
intensity = 12

[[light]]
name = "blue"
type = "distant"
direction = [1, 0, 0]
color = [0, 0, 1]
intensity = 12

[ambient]
color = [0.1, 0.1, 0.1]
"""


@pytest.fixture(scope="module")
def chromium():
    with playwright.sync_playwright() as kit:
        browser = kit.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


class Page:
    def __init__(self, chromium, viewer, folder):
        self.problems, self.folder, self.viewer = [], folder, viewer
        # The page forbids code from text, which is how this test asks it.
        self.page = chromium.new_page(bypass_csp=True, viewport={"width": 1100, "height": 700})
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.goto(viewer.url)
        self.settle()

    def settle(self):
        """Waits until the picture is the program's, its layers are there, and it is drawn with all digits."""
        done = "scrim.isSettled && document.body.dataset.stage === 'exact' && document.body.dataset.layers"
        done += " && document.body.dataset.table === 'fine'"
        self.page.wait_for_function(done, timeout=PATIENCE)
        self.page.evaluate("new Promise((drawn) => setTimeout(() => requestAnimationFrame(drawn), 300))")

    def pixels(self):
        """What the screen shows of the picture, without its frame: (height, width, 3), 0 to 255."""
        self.page.mouse.move(2, 2)
        return self.shown()

    def shown(self):
        """Likewise, while the mouse stays where it is."""
        path = str(self.folder / "shown.png")
        self.page.locator("#picture").screenshot(path=path, style="#handles, #histogram { display: none }")
        return OpenImageIO.ImageBuf(path).get_pixels(OpenImageIO.UINT8)[3:-3, 3:-3, :3].astype(float)

    def drag(self, dx, dy, button="left"):
        """Drags over a part of the picture's height."""
        box = self.page.locator("#picture").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down(button=button)
        for part in (0.3, 0.6, 1.0):
            mouse.move(x + part * dx * box["height"], y + part * dy * box["height"])
        mouse.up(button=button)

    def slide(self, label, value):
        """Types a number into the field of a control."""
        field = self.page.get_by_label(label, exact=True)
        field.fill(str(value))
        field.press("Enter")


@pytest.fixture
def page_of(chromium, tmp_path, python_path):
    """Opens a scene's text, or a path, in a page; a page that had an error of its own fails the test."""
    pages = []

    def show(scene):
        path = tmp_path / "ball.toml" if isinstance(scene, str) else scene
        if isinstance(scene, str):
            path.write_text(scene)
        viewer = Viewer(path, python_path)
        pages.append((viewer, Page(chromium, viewer, tmp_path)))
        return pages[-1][1]

    yield show
    for viewer, page in pages:
        assert not page.problems
        page.page.close()
        viewer.close()


@pytest.fixture
def opened(page_of):
    return page_of(BALL)


def middle(pixels):
    """The middle of what is not black, across and down, 0 to 1."""
    rows, columns = numpy.nonzero(pixels.max(axis=2) > 24)
    return (columns.min() + columns.max()) / 2 / pixels.shape[1], (rows.min() + rows.max()) / 2 / pixels.shape[0]
