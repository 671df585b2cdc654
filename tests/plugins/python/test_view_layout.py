# SPDX-License-Identifier: Apache-2.0
"""The page around the picture: what comes and goes leaves the picture where it is, and nothing hides what it says."""

import numpy
import pytest
from browsing import BALL, PATIENCE, SIZE, chromium, needs_chromium, opened, page_of  # noqa: F401

pytestmark = needs_chromium

LONG = "finished: the file's picture (12.34 s, error 0.53 % of 400 pixels), and then some words more"


def box(page, selector):
    return page.page.locator(selector).bounding_box()


def hover(page):
    at = box(page, "#picture")
    page.page.mouse.move(at["x"] + 0.7 * at["width"], at["y"] + 0.5 * at["height"])
    page.page.wait_for_function("document.getElementById('pixel').textContent")


@pytest.mark.parametrize("width", [1000, 1280, 1450, 1600, 1920])
def test_the_picture_keeps_its_place_whatever_the_bar_says(opened, width):  # noqa: F811
    opened.page.set_viewport_size({"width": width, "height": 720})
    opened.page.wait_for_timeout(200)
    before = box(opened, "#picture")
    hover(opened)
    assert box(opened, "#picture") == before
    opened.page.evaluate("text => (document.getElementById('status').textContent = text)", LONG)
    opened.page.select_option("#look", "depth")
    opened.page.wait_for_function("document.getElementById('legend').textContent")
    assert box(opened, "#picture") == before


def test_an_error_lies_over_no_words(opened):  # noqa: F811
    for width in (1280, 1920):
        opened.page.set_viewport_size({"width": width, "height": 720})
        opened.slide("blue (distant) intensity, number", -3)
        opened.page.wait_for_function("!document.getElementById('error').hidden")
        error, footer, header = (box(opened, name) for name in ("#error", "footer", "header"))
        assert error["y"] + error["height"] <= footer["y"] and error["y"] >= header["y"] + header["height"]
        opened.slide("blue (distant) intensity, number", 3)
        opened.page.wait_for_function("document.getElementById('error').hidden", timeout=PATIENCE)


def test_no_handle_lies_over_the_layers_and_a_muted_one_is_marked(opened):  # noqa: F811
    assert opened.page.get_by_label("Place light red").is_visible()
    opened.page.click("#layers")
    opened.page.wait_for_function("document.querySelectorAll('#sheet button').length === 4")
    assert not opened.page.get_by_label("Place light red").is_visible()
    opened.page.click("button[aria-label='Mute red']")
    opened.page.wait_for_function("document.querySelector('#sheet .muted')")
    opened.settle()
    tile = opened.page.locator("#sheet .muted")
    assert tile.count() == 1 and tile.inner_text() == "light.red"
    told = tile.locator("button").evaluate("button => getComputedStyle(button, '::after').content")
    assert told == '" (muted)"'
    at, whole = tile.bounding_box(), box(opened, "#picture")
    x, y = (int(at[axis] - whole[axis]) for axis in "xy")
    seen = opened.shown()[y + 40 : y + int(at["height"]) - 8, x : x + int(at["width"]) - 8]
    assert 30 < seen[..., 0].max() < 200  # it is seen, and darker than it would be
    opened.page.click("#layers")
    assert "muted" in opened.page.get_by_label("Place light red").get_attribute("class")


def test_panels_fold_each_and_those_of_lights_together(opened):  # noqa: F811
    intensity = opened.page.get_by_label("red (distant) intensity, number", exact=True)
    heading = opened.page.get_by_role("button", name="red (distant)", exact=True)
    heading.click()
    assert not intensity.is_visible() and heading.get_attribute("aria-expanded") == "false"
    assert opened.page.get_by_label("blue (distant) intensity, number", exact=True).is_visible()
    opened.page.click("button[aria-label='Mute red']")  # its buttons stay, and it stays folded
    opened.page.wait_for_function("scrim.state.muted.length === 1")
    assert not intensity.is_visible()
    opened.page.click("#fold")
    assert opened.page.locator("[data-kind=light] .row:visible").count() == 0
    assert opened.page.get_by_label("ball density, number", exact=True).is_visible()
    opened.page.click("#fold")
    assert intensity.is_visible()


def test_sliders_go_by_factors_down_to_nothing_and_say_their_units(opened):  # noqa: F811
    slider = opened.page.get_by_label("red (distant) angle", exact=True)
    ends = []
    for key in ("End", "Home"):
        slider.press(key)
        opened.page.wait_for_timeout(100)
        ends.append(float(opened.page.get_by_label("red (distant) angle, number", exact=True).input_value()))
    assert ends == [90, 0]
    values = []
    for place in (250, 500, 750):
        slider.evaluate("(it, place) => { it.value = place; it.dispatchEvent(new Event('input')); }", place)
        values.append(float(opened.page.get_by_label("red (distant) angle, number", exact=True).input_value()))
    assert values[1] / values[0] == pytest.approx(values[2] / values[1], rel=1e-3) and values[1] > 2 * values[0]
    units = opened.page.locator(".row").evaluate_all(
        "rows => rows.map((row) => row.querySelector('span')?.textContent.trim())"
    )
    assert {"intensity irradiance", "angle °", "temperature K", "density per unit", "field of view °"} <= set(units)


def test_a_frame_of_another_aspect_darkens_what_it_leaves_out(page_of):  # noqa: F811
    page = page_of(BALL.replace(f"scale = {SIZE}", "scale = 3"))
    before = page.pixels()
    page.page.select_option("#aspect", "2.39")
    gate, picture = box(page, "#gate > div"), box(page, "#picture")
    assert gate["width"] / gate["height"] == pytest.approx(2.39, rel=0.005)
    assert gate["width"] == pytest.approx(picture["width"], abs=1)
    assert gate["y"] + gate["height"] / 2 == pytest.approx(picture["y"] + picture["height"] / 2, abs=1)
    after = page.pixels()
    top, bottom = int(gate["y"] - picture["y"]) - 3, int(gate["y"] + gate["height"] - picture["y"]) - 3
    assert numpy.abs(after[top + 4 : bottom - 4] - before[top + 4 : bottom - 4]).max() <= 2
    assert before[: top - 4].mean() > 20 and after[: top - 4].mean() < 0.5 * before[: top - 4].mean()
    page.page.select_option("#aspect", "1")
    gate = box(page, "#gate > div")
    assert gate["width"] == pytest.approx(gate["height"], abs=1)
    assert gate["height"] == pytest.approx(picture["height"], abs=1)
    page.page.select_option("#aspect", "")
    assert page.page.locator("#gate").is_hidden() and numpy.abs(page.pixels() - before).max() <= 2
