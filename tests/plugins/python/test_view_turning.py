# SPDX-License-Identifier: Apache-2.0
"""The page while the view turns: the last sharp picture follows at once, until a better one is ready."""

import math

import numpy
import pytest
from browsing import BALL, PATIENCE, PLACE, chromium, middle, needs_chromium, opened, page_of  # noqa: F401
from conftest import SMOKE

pytestmark = needs_chromium

# Lets pictures of some stages wait while `stages` is set: those come as if the renderer had much else to do.
HOLD = """(stages) => {
    const receive = scrim.socket.onmessage;
    scrim.socket.onmessage = (message) => {
        if (typeof message.data === "string") return receive(message);
        const size = new DataView(message.data).getUint32(0, true);
        const head = JSON.parse(new TextDecoder().decode(new Uint8Array(message.data, 4, size)));
        if (!globalThis.held || !stages.includes(head.stage)) receive(message);
        else {
            held.push(() => receive(message));
            scrim.socket.send(JSON.stringify({ type: "have" })); // so that others come
        }
    };
    globalThis.held = [];
}"""
RELEASE = "() => { const all = held; globalThis.held = null; all.forEach((call) => call()); }"
DRAWN = "new Promise((drawn) => setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(drawn)), 200))"

# Enough detail that a draft of it is a blur.
DETAIL = SMOKE.replace("[64, 48]", "[512, 384]").replace("resolution = 32", "resolution = 96")


def dragged(page, dx, dy=0.0):
    """The pixels while the mouse is held after a drag over parts of the picture's height."""
    box = page.page.locator("#picture").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    for part in (0.5, 1.0):
        page.page.mouse.move(x + part * dx * box["height"], y + part * dy * box["height"])
    page.page.evaluate(DRAWN)
    return page.shown()


def sharpness(pixels):
    grey = pixels.mean(axis=2)
    return numpy.abs(numpy.diff(grey, axis=1)).mean() + numpy.abs(numpy.diff(grey, axis=0)).mean()


def test_the_sharp_picture_turns_before_any_other_is_there(opened):  # noqa: F811
    opened.page.evaluate(HOLD, ["motion", "final"])
    angle = 0.1 * math.pi
    moving = dragged(opened, 0.1)
    x, depth = PLACE * math.cos(angle), 5 + PLACE * math.sin(angle)
    # The ball is seen where it is then, to two pixels: its own front half has turned, too.
    wanted = 0.5 + 0.5 * x / depth / math.tan(math.radians(18))
    assert middle(moving)[0] == pytest.approx(wanted, abs=0.015)
    opened.page.mouse.up()
    opened.page.evaluate(RELEASE)
    opened.settle()
    assert middle(opened.pixels())[0] == pytest.approx(wanted, abs=0.012)


@pytest.mark.parametrize("height", [0, 3], ids=["perspective", "orthographic"])
def test_a_warped_picture_stays_sharp_while_drafts_come(page_of, height):  # noqa: F811
    lens = f'type = "orthographic"\nheight = {height}\n' if height else "fov = 36\n"
    page = page_of(DETAIL.replace("fov = 36\n", lens))
    page.page.evaluate(HOLD, ["final"])
    moving = dragged(page, 0.04)
    assert page.page.evaluate("document.body.dataset.stage") == "motion"
    page.page.mouse.up()
    page.page.evaluate(RELEASE)
    page.settle()
    exact = page.pixels()
    assert sharpness(moving) > 0.93 * sharpness(exact)
    assert numpy.abs(moving - exact).mean() < 0.25 * exact.mean()


def test_another_scene_is_not_hidden_by_the_sharp_picture_of_the_one_before(page_of):  # noqa: F811
    page = page_of(DETAIL)
    page.page.evaluate(HOLD, ["final"])
    before = dragged(page, 0.04)
    slider = page.page.get_by_label("smoke density, number", exact=True)
    slider.evaluate("field => { field.value = 0.01; field.dispatchEvent(new Event('change')); }")  # the mouse is held
    page.page.wait_for_function("scrim.state.changed && scrim.isSettled", timeout=PATIENCE)
    page.page.evaluate(DRAWN)
    assert page.shown().mean() < 0.2 * before.mean()


def test_a_view_from_another_side_waits_for_its_picture(opened):  # noqa: F811
    opened.drag(0.5, 0)
    opened.page.wait_for_function("scrim.state.free")
    opened.settle()
    before = opened.pixels()
    opened.page.evaluate(HOLD, ["motion", "final"])
    opened.page.click("#scene-camera")  # 90 degrees away: what was seen there is a thin edge from here
    opened.page.wait_for_function("!scrim.state.free")
    opened.page.evaluate(DRAWN)
    assert numpy.abs(opened.pixels() - before).max() <= 2
    opened.page.evaluate(RELEASE)
    opened.settle()
