# SPDX-License-Identifier: Apache-2.0
"""Long sessions in a real browser: whatever is done in whatever order, the page ends with the picture of its scene, and
nothing is left over."""

import os
import random
import shlex
import subprocess
import time

import numpy
import OpenEXR
import psutil
from browsing import BALL, PATIENCE, chromium, needs_chromium, page_of  # noqa: F401
from conftest import PROGRAM

pytestmark = needs_chromium

EVENTS, CUTS = 1000, 20
SEED = int(os.environ.get("SCRIM_SEED", "32"))  # of the random events
BUTTONS = (
    "#undo",
    "#redo",
    "#frame-all",
    "#scene-camera",
    "#keep-view",
    "#snapshot",
    "#compare",
    "#layers",
    "#count",
    "#lights",
    "#fold",
    "#focus",
    "#verify",
    "#error-next",
    "#error-regions",
)
KEYS = (
    "ArrowLeft",
    "ArrowRight",
    "ArrowUp",
    "ArrowDown",
    "+",
    "-",
    "f",
    "Home",
    "s",
    "w",
    "e",
    "E",
    "g",
    "G",
    "l",
    "h",
)


def drag(page, chance):
    box = page.locator("#picture").bounding_box()
    x, y = (box[a] + chance.random() * box[b] for a, b in (("x", "width"), ("y", "height")))
    page.mouse.move(x, y)
    page.mouse.down(button=chance.choice(("left", "middle", "right")))
    for _ in range(chance.randint(0, 4)):
        page.mouse.move(x + chance.uniform(-60, 60), y + chance.uniform(-60, 60))
    for button in ("left", "middle", "right"):
        page.mouse.up(button=button)


def slide(page, chance):
    sliders = page.locator("#panel input[type=range]")
    count = chance.randrange(sliders.count())  # one may go while it is looked for
    page.evaluate("n => document.querySelectorAll('#panel input[type=range]')[n]?.focus()", count)
    for _ in range(chance.randint(1, 4)):
        page.keyboard.press(chance.choice(("ArrowLeft", "ArrowRight", "PageUp", "PageDown")))


def press(page, chance):
    page.locator("#picture").focus()
    page.keyboard.press(chance.choice(KEYS))


def click(page, chance):
    layers = page.locator("#panel button[data-layer]")
    if chance.random() < 0.4:  # likewise
        number = chance.randrange(layers.count())
        page.evaluate("n => document.querySelectorAll('#panel button[data-layer]')[n]?.click()", number)
    else:  # one that is disabled does nothing
        page.eval_on_selector(chance.choice(BUTTONS), "button => button.click()")


def point(page, chance):
    """Moves a handle by its keys, or clicks with Shift."""
    if chance.random() < 0.5:  # a handle may go while it is looked for
        page.evaluate("n => [...document.querySelectorAll('#handles button')].at(n)?.focus()", chance.randrange(2))
        page.keyboard.press(chance.choice(KEYS[:4]))
        return
    box = page.locator("#picture").bounding_box()
    page.keyboard.down("Shift")
    page.mouse.click(box["x"] + chance.random() * box["width"], box["y"] + chance.random() * box["height"])
    page.keyboard.up("Shift")


def look(page, chance):
    page.select_option("#look", chance.choice(("picture", "depth", "transmittance")))
    page.select_option("#aspect", chance.choice(("", "1", "2.39")))


def come_and_go(page, chance):
    """Adds a light, or removes one."""
    count = page.locator("#panel button[aria-label^=Remove]").count()
    if count > 3 or (count > 1 and chance.random() < 0.5):
        number = chance.randrange(count)
        page.evaluate("n => document.querySelectorAll('#panel button[aria-label^=Remove]')[n]?.click()", number)
    else:
        page.select_option("#add-light", chance.choice(("distant", "point", "sphere", "rectangle", "dome")))


def write(page, chance):
    """Applies an expression, which may be wrong."""
    apply(page, chance.choice(("", "f@density *= $gain;", "f@density *= 0.5;\nf@density += 0 * $more;", "oops;")))


def apply(page, code):
    field = page.locator(".code textarea").first
    page.evaluate("document.querySelector('[data-title$=code] .fold[aria-expanded=false]')?.click()")
    field.fill(code)
    field.press("Control+Enter")


ACTIONS = 3 * (drag, drag, slide, slide, press, press, click, point, look) + (come_and_go, write)


def plain(page):
    """Brings the ways to look back to where they begin."""
    page.evaluate(
        """() => {
            scrim.picture.wipe = 0; scrim.picture.exposure = 0; scrim.picture.gamma = 1;
            scrim.picture.look = "picture"; scrim.picture.sheet = null;
        }"""
    )


def pixels(page):
    plain(page)
    return numpy.array(page.evaluate("scrim.readPixels()"))


def rgba(path):
    with OpenEXR.File(str(path)) as file:
        return file.channels()["RGBA"].pixels


def leftovers(viewer):
    process = psutil.Process(viewer.process.pid)
    return process.num_threads(), len(process.children(recursive=True)), process.num_fds()


def check(page, viewer, tmp_path, chromium):  # noqa: F811
    """The page shows what a new page shows, and what the command renders. An expression that is wrong goes first."""
    apply(page.page, f"f@density *= {time.monotonic() % 1 + 0.5:.6g};")
    page.settle()
    assert page.page.evaluate("scrim.pending") == 0
    page.page.evaluate("new Promise((then) => setTimeout(then, 300))")
    seen = pixels(page.page)
    fresh = chromium.new_page(bypass_csp=True, viewport={"width": 1100, "height": 700})
    fresh.goto(viewer.url)
    done = "scrim.isSettled && document.body.dataset.layers && document.body.dataset.table === 'fine'"
    fresh.wait_for_function(done, timeout=PATIENCE)
    fresh.wait_for_timeout(300)
    assert numpy.abs(seen - pixels(fresh)).max() <= 1
    fresh.close()
    # Textures of layers that are shown, and no others.
    names = page.page.evaluate("Object.keys(scrim.picture.slots).length")
    assert page.page.evaluate("scrim.picture.textures.size") <= names
    muted = page.page.evaluate("scrim.state.muted")
    if not muted:  # with layers left out it is not the file's picture that can be had
        if page.page.evaluate("scrim.state.command").startswith("#"):  # no command adds or removes a light
            page.page.click("#save")
            page.page.wait_for_function("!scrim.state.changed", timeout=PATIENCE)
        (tmp_path / "served.exr").write_bytes(viewer.get("/picture.exr")[1])
        words = shlex.split(page.page.evaluate("scrim.state.command"))
        subprocess.run([PROGRAM, *words[1:-1], tmp_path / "picture.exr", "-q"], check=True, cwd=tmp_path)
        assert numpy.array_equal(rgba(tmp_path / "served.exr"), rgba(tmp_path / "picture.exr"))


def test_a_thousand_random_events_leave_the_picture_of_the_scene_and_nothing_else(page_of, chromium, tmp_path):  # noqa: F811
    page = page_of(BALL.replace("[256, 192]", "[128, 96]"))
    viewer, chance = page.viewer, random.Random(SEED)
    page.page.on("dialog", lambda dialog: dialog.dismiss())
    before, memory = None, None
    for number in range(EVENTS):
        chance.choice(ACTIONS)(page.page, chance)
        if number % 200 == 199:
            check(page, viewer, tmp_path, chromium)
            process = psutil.Process(viewer.process.pid)
            if before is None:  # once everything has been used
                before, memory = leftovers(viewer), process.memory_info().rss
    after = leftovers(viewer)
    assert all(now <= then + 2 for now, then in zip(after, before)), (before, after)
    assert psutil.Process(viewer.process.pid).memory_info().rss < memory + (64 << 20)


def test_a_connection_that_is_cut_again_and_again_comes_back_with_the_newest_picture(page_of, chromium, tmp_path):  # noqa: F811
    page = page_of(BALL.replace("[256, 192]", "[128, 96]"))
    chance = random.Random(20)
    before = leftovers(page.viewer)
    for _ in range(CUTS):
        chance.choice((drag, slide, press))(page.page, chance)
        page.page.evaluate("scrim.cut()")
        chance.choice((drag, slide, press))(page.page, chance)  # while nobody hears it
        page.page.wait_for_function("scrim.isConnected", timeout=PATIENCE)
    check(page, page.viewer, tmp_path, chromium)
    after = leftovers(page.viewer)
    assert all(now <= then + 2 for now, then in zip(after, before)), (before, after)
