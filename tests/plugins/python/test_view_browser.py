# SPDX-License-Identifier: Apache-2.0
"""The viewer's page in a real browser: what it shows after clicks and drags, looked at pixel by pixel.

Needs Debian's chromium and PyPI's playwright; without them these tests are skipped.
"""

import math
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
pytestmark = pytest.mark.skipif(not CHROMIUM, reason="no chromium; SCRIM_CHROMIUM names another one")
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
        self.problems, self._folder = [], folder
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
        path = str(self._folder / "shown.png")
        self.page.mouse.move(2, 2)
        self.page.locator("#picture").screenshot(path=path)
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
def opened(chromium, tmp_path, python_path):
    path = tmp_path / "ball.toml"
    path.write_text(BALL)
    viewer = Viewer(path, python_path)
    page = Page(chromium, viewer, tmp_path)
    yield page
    assert not page.problems
    page.page.close()
    viewer.close()


def middle(pixels):
    """The middle of what is not black, across and down, 0 to 1."""
    rows, columns = numpy.nonzero(pixels.max(axis=2) > 24)
    return (columns.min() + columns.max()) / 2 / pixels.shape[1], (rows.min() + rows.max()) / 2 / pixels.shape[0]


def test_muting_a_light_darkens_what_it_lit_and_nothing_else(opened):
    before = opened.pixels()
    opened.page.click("button[aria-label='Mute red']")
    opened.page.wait_for_function("scrim.state.muted.length === 1")
    opened.settle()
    after = opened.pixels()
    ball = before.max(axis=2) > 24
    columns = numpy.nonzero(ball)[1]
    right = ball & (numpy.arange(ball.shape[1])[None, :] > columns.mean())
    assert before[..., 0][right].mean() > 100 and after[..., 0][right].mean() < 0.6 * before[..., 0][right].mean()
    assert (after[..., 0] <= before[..., 0] + 2).all()
    opened.page.click("button[aria-label='Mute red']")
    opened.page.wait_for_function("scrim.state.muted.length === 0")
    opened.settle()
    assert numpy.abs(opened.pixels() - before).max() <= 2


def test_a_slider_of_a_light_is_the_light_of_the_scene(opened):
    before = opened.pixels()
    opened.slide("blue (distant) intensity, number", 0.5)
    opened.page.wait_for_function("scrim.state.changed")
    opened.settle()
    after = opened.pixels()
    ball = before.max(axis=2) > 24
    assert after[..., 2][ball].mean() < 0.7 * before[..., 2][ball].mean()
    assert opened.page.locator("#title").inner_text() == "ball.toml •"
    opened.page.keyboard.press("Escape")
    opened.page.click("#undo")
    opened.page.wait_for_function("!scrim.state.changed")
    opened.settle()
    assert numpy.abs(opened.pixels() - before).max() <= 2


def test_an_orbit_turns_the_ball_to_where_the_camera_says(opened):
    def across(turn):
        """Where the ball's middle is, after a turn of the scene about y that brings the front to the right."""
        x, depth = PLACE * math.cos(turn), 5 + PLACE * math.sin(turn)
        return 0.5 + 0.5 * x / depth / math.tan(math.radians(18))

    # The silhouette of a ball beside the axis is stretched outwards, by less than its size times its slope.
    tolerance = 0.012
    assert middle(opened.pixels()) == pytest.approx((across(0), 0.5), abs=tolerance)
    for drag in (0.2, 0.25):
        opened.drag(drag, 0)
        opened.page.wait_for_function("scrim.state.free")
        opened.settle()
    assert middle(opened.pixels()) == pytest.approx((across(0.45 * math.pi), 0.5), abs=tolerance)
    opened.page.click("#scene-camera")
    opened.page.wait_for_function("!scrim.state.free")
    opened.settle()
    assert middle(opened.pixels()) == pytest.approx((across(0), 0.5), abs=tolerance)


def test_a_pan_moves_the_picture_with_the_pointer(opened):
    before = middle(opened.pixels())
    opened.drag(-0.2, 0.1, button="middle")
    opened.settle()
    after = middle(opened.pixels())
    # A fifth of the height is 0.15 of the width at 4:3.
    assert (after[0] - before[0], after[1] - before[1]) == pytest.approx((-0.15, 0.1), abs=0.012)


def test_a_saved_scene_shows_what_the_page_showed(opened, tmp_path, program):
    opened.slide("red (distant) intensity, number", 5)
    opened.drag(0.15, 0.1)
    opened.page.wait_for_function("scrim.state.free")
    opened.page.click("#keep-view")
    opened.page.wait_for_function("!scrim.state.free")
    opened.page.click("#save")
    opened.page.wait_for_function("!scrim.state.changed")
    opened.settle()
    assert "# the eye" in (tmp_path / "ball.toml").read_text()
    done = program("render", tmp_path / "ball.toml", "-q", "-o", tmp_path / "p.exr", "--preview", tmp_path / "p.png")
    assert done.returncode == 0, done.stderr
    preview = OpenImageIO.ImageBuf(str(tmp_path / "p.png")).get_pixels(OpenImageIO.UINT8)[..., :3].astype(float)
    shown = opened.page.evaluate("scrim.readPixels()")
    shown = numpy.array(shown, float).reshape(*preview.shape[:2], 4)[::-1, :, :3]
    # The table is off by a step, half floats by a half, dithering by one, and rounding by a half. Where a channel of a
    # light so pure leaves what the display can show, the table is off by ten.
    off = numpy.abs(shown - preview)
    assert off.max() <= 12 and (off > 3).mean() < 0.01


def test_exposure_brightens_and_the_wipe_shows_the_snapshot(opened):
    before = opened.pixels()
    opened.page.click("#snapshot")
    opened.page.click("button[aria-label='Mute red']")
    opened.page.wait_for_function("scrim.state.muted.length === 1")
    opened.page.click("#compare")
    opened.settle()
    wiped = opened.pixels()
    half = wiped.shape[1] // 2
    assert numpy.abs(wiped - before)[:, : half - 8].max() <= 2  # the snapshot on the left
    assert wiped[:, half + 8 :, 0].sum() < 0.8 * before[:, half + 8 :, 0].sum()
    opened.page.click("#compare")
    opened.page.locator("#exposure").fill("2")
    opened.page.locator("#exposure").press("Enter")
    opened.settle()
    assert opened.pixels()[..., 2].sum() > 1.3 * before[..., 2].sum()


def test_a_lost_connection_comes_back_with_the_newest_picture(opened):
    opened.page.evaluate("scrim.cut()")
    opened.page.wait_for_function("scrim.isConnected", timeout=PATIENCE)
    opened.slide("red (distant) intensity, number", 0)
    opened.page.wait_for_function("scrim.state.changed")
    opened.settle()
    assert opened.pixels()[..., 0].max() < 160
