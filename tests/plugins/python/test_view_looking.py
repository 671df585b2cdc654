# SPDX-License-Identifier: Apache-2.0
"""Other ways to look at a picture, and lights and curves that are changed in it, in a real browser."""

import numpy
import pytest
from browsing import BALL, PATIENCE, chromium, needs_chromium, opened, page_of  # noqa: F401

pytestmark = needs_chromium

# The ball in the middle.
CENTRED = BALL.replace("translate = [0.8, 0, 0]", "translate = [0, 0, 0]").replace("scale = 0.35", "scale = 0.9")


def centre(pixels, channel):
    """The centre of mass of a channel's light, across and down, 0 to 1. Smoke is brightest not where it faces the light
    but towards the rim, so that no single pixel says where light comes from."""
    values = numpy.where(pixels[..., channel] > 24, pixels[..., channel], 0)
    height, width = values.shape
    across, down = (numpy.arange(size) + 0.5 for size in (width, height))
    return (values.sum(axis=0) @ across) / values.sum() / width, (values.sum(axis=1) @ down) / values.sum() / height


def test_depth_and_transmittance_are_shown_in_false_colours(page_of):
    page = page_of(CENTRED)
    page.page.select_option("#look", "depth")
    page.page.wait_for_function("document.getElementById('legend').textContent !== ''")
    page.settle()
    seen = page.pixels()
    height, width = seen.shape[:2]
    red, _, blue = seen[height // 2, width // 2]
    assert blue > 120 and red < 40  # the front is nearest
    row = seen[height // 2]
    ball = numpy.nonzero(row.max(axis=1) > 60)[0]
    assert row[ball[3], 0] > row[ball[3], 2]  # the rim is farther
    assert seen[5, 5].max() == 0
    near, far = (float(v) for v in page.page.locator("#legend").inner_text().split(" to "))
    assert 4.0 < near < 4.3 and near < far < 5.1  # the ball has a radius of 0.9, 5 from the eye
    page.page.select_option("#look", "transmittance")
    page.settle()
    seen = page.pixels()
    assert seen[5, 5, 0] > 120 and seen[5, 5, 2] < 40  # all light comes through beside the ball, and none in its middle
    assert seen[height // 2, width // 2, 2] > 100


def test_the_histogram_counts_what_the_picture_holds(opened):
    def count():
        """How many pixels of the histogram are red, green, blue, from two stops below 1 on."""
        return opened.page.evaluate(
            """() => {
                const canvas = document.getElementById("histogram");
                const half = canvas.width / 2;
                const { data } = canvas.getContext("2d").getImageData(half, 0, half - 1, canvas.height);
                const sums = [0, 0, 0];
                for (let i = 0; i < data.length; i += 4) for (let c = 0; c < 3; ++c) sums[c] += data[i + c] > 100;
                return sums;
            }"""
        )

    opened.page.click("#count")
    opened.settle()
    red, _, blue = count()
    assert red > 100 and blue > 100
    opened.page.click("button[aria-label='Mute red']")
    opened.page.wait_for_function("scrim.state.muted.length === 1")
    opened.settle()
    dimmed = count()
    assert dimmed[0] < 0.8 * red and dimmed[2] > 0.8 * blue


def test_layers_stand_side_by_side_and_a_click_shows_one_alone(opened):
    opened.page.click("#layers")
    opened.page.wait_for_function("document.querySelectorAll('#sheet button').length === 4")
    opened.settle()
    names = opened.page.locator("#sheet button").all_inner_texts()
    assert names[0] == "beauty" and sorted(names[1:]) == ["ambient", "light.blue", "light.red"]
    seen = opened.pixels()
    height, width = seen.shape[0] // 2, seen.shape[1] // 2
    at = names.index("light.red")
    cell = seen[(at // 2) * height : (at // 2 + 1) * height, (at % 2) * width : (at % 2 + 1) * width]
    # The view shows pure red with some green and blue.
    assert cell[..., 0].max() > 150 and cell[30:, :, 0].sum() > 2 * cell[30:, :, 2].sum()
    opened.page.locator("#sheet button", has_text="light.red").click()
    opened.page.wait_for_function("scrim.state.muted.length === 2")
    opened.settle()
    alone = opened.pixels()
    assert alone[..., 0].sum() > 2 * alone[..., 2].sum()


def test_a_light_is_dragged_in_the_picture(page_of):
    page = page_of(CENTRED)
    before = centre(page.pixels(), 0)
    assert before[0] > 0.53  # red comes from the right
    handle = page.page.get_by_label("Place light red")
    box, picture = handle.bounding_box(), page.page.locator("#picture").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    # On the ball around the pivot that is to the right, at its outline.
    assert x == pytest.approx(picture["x"] + picture["width"] / 2 + 0.35 * picture["height"], abs=2)
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    for part in (0.5, 1.0):
        page.page.mouse.move(x - part * 0.35 * picture["height"], y - part * 0.2 * picture["height"])
    page.page.mouse.up()
    page.page.wait_for_function("scrim.state.changed")
    page.settle()
    after = centre(page.pixels(), 0)
    assert after[0] == pytest.approx(0.5, abs=0.01) and after[1] < 0.49  # from the front, above
    page.page.click("#undo")
    page.page.wait_for_function("!scrim.state.changed")
    page.settle()
    assert centre(page.pixels(), 0) == pytest.approx(before, abs=0.005)


def test_a_shift_click_makes_the_light_shine_there(page_of):
    page = page_of(CENTRED)
    page.page.get_by_label("Place light red").focus()
    picture = page.page.locator("#picture").bounding_box()
    across, down = 0.42, 0.62
    page.page.keyboard.down("Shift")
    page.page.mouse.click(picture["x"] + across * picture["width"], picture["y"] + down * picture["height"])
    page.page.keyboard.up("Shift")
    page.page.wait_for_function("scrim.state.changed")
    page.settle()
    assert not page.page.evaluate("scrim.state.free")  # the view did not move
    after = centre(page.pixels(), 0)
    assert after[0] < 0.5 and after[1] > 0.5  # before, it came from the right
    # From straight in front of the ball there: its normal is (-0.24, -0.27), by its radius of 0.9, at 5 from the eye.
    handle = page.page.get_by_label("Place light red").bounding_box()
    x = (handle["x"] + handle["width"] / 2 - picture["x"]) / picture["width"] - 0.5
    y = (handle["y"] + handle["height"] / 2 - picture["y"]) / picture["height"] - 0.5
    assert (x, y) == pytest.approx((-0.24 * 0.35 * 3 / 4, 0.27 * 0.35), rel=0.25)


def test_a_point_of_a_curve_is_dragged_and_the_smoke_thins(page_of):
    page = page_of(CENTRED.replace("scale = 20", "scale = 20, ramp = [[0, 0], [1, 1]]").replace("0.9 }", "0.9 }"))
    before = page.pixels()
    dots = page.page.locator(".curve circle")
    assert dots.count() == 2
    dots.nth(1).scroll_into_view_if_needed()
    box = dots.nth(1).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x, y + 20)
    page.page.mouse.move(x, y + 90)  # below the bottom
    page.page.mouse.up()
    page.page.wait_for_function("scrim.state.changed")
    page.settle()
    assert page.pixels().sum() < 0.1 * before.sum()
    page.page.click("#undo")  # the whole drag
    page.page.wait_for_function("!scrim.state.changed")
    page.settle()
    assert numpy.abs(page.pixels() - before).max() <= 2


def test_a_region_is_drawn_and_taken_away(opened):
    before = opened.page.evaluate("scrim.state.command")
    opened.page.click("#region")
    opened.drag(0.2, 0.2)
    opened.page.wait_for_function("document.body.dataset.stage === 'region'", timeout=PATIENCE)
    box, picture = (opened.page.locator(name).bounding_box() for name in ("#box", "#picture"))
    assert box["x"] == pytest.approx(picture["x"] + picture["width"] / 2, abs=3)
    assert box["height"] == pytest.approx(0.2 * picture["height"], abs=6)
    assert opened.page.evaluate("scrim.state.command") == before  # the drag moved no camera
    opened.page.click("#region")
    opened.settle()
    assert opened.page.locator("#box").is_hidden()


def test_an_error_stays_until_something_goes_well(opened):
    opened.slide("blue (distant) intensity, number", -3)
    opened.page.wait_for_function("!document.getElementById('error').hidden")
    opened.page.wait_for_timeout(600)  # pictures and states go on meanwhile
    assert "'intensity' is -3" in opened.page.locator("#error").inner_text()
    opened.slide("blue (distant) intensity, number", 3)
    opened.page.wait_for_function("document.getElementById('error').hidden", timeout=PATIENCE)


def test_the_page_can_be_used_by_everybody(opened):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="pip install axe-playwright-python")
    opened.page.click("#count")
    opened.page.get_by_text("Add curve").first.click()
    opened.page.wait_for_function("scrim.state.changed")
    opened.settle()
    for fold in ("ball: shading", "ball: code"):
        opened.page.get_by_text(fold).click()
    opened.page.click("#verify")
    opened.page.wait_for_function("!document.getElementById('verified').hidden", timeout=PATIENCE)
    for sheet in (False, True):
        if sheet:
            opened.page.click("#layers")
            opened.page.wait_for_timeout(500)
        found = axe.Axe().run(opened.page)
        assert not found.response["violations"], found.generate_report()


def test_frames_are_played_from_pictures_that_are_kept(page_of, program, tmp_path):
    for frame, size in ((1, 12), (2, 20), (3, 28)):
        shapes = f"sphere radius={size / 28}"
        done = program(
            "make", "primitives", f"shapes={shapes}", "resolution=28", "-q", "-o", tmp_path / f"b.{frame}.vdb"
        )
        assert done.returncode == 0, done.stderr
    files = CENTRED.replace('source = "primitives"', 'file = "b.#.vdb"')
    page = page_of("\n".join(line for line in files.splitlines() if not line.startswith("parameters")))
    page.page.click("#play")
    shown = "document.getElementById('frame-number').value"
    page.page.wait_for_function(f"(window.seen ??= new Set()).add({shown}).size === 3", timeout=PATIENCE)
    page.page.click("#play")
    page.page.wait_for_function("!scrim.state.playing")
    widths = []
    for frame in (1, 3):
        page.page.evaluate(f"document.getElementById('frame').value = {frame}")
        page.page.dispatch_event("#frame", "input")
        page.page.dispatch_event("#frame", "change")
        page.page.wait_for_function(f"scrim.state.frame === {frame}")
        page.settle()
        widths.append((page.pixels().max(axis=(0, 2)) > 24).sum())
    assert widths[1] > 1.5 * widths[0]


def test_an_expression_is_typed_and_applied_and_a_mistake_is_at_its_line(page_of):
    page = page_of(CENTRED)
    before = page.pixels()
    page.page.get_by_text("ball: code").click()
    field = page.page.get_by_label("ball: code code: Ctrl+Enter applies it")
    field.fill("float n = $gain;\nf@density *= nn;")
    field.press("Control+Enter")
    page.page.wait_for_function("document.querySelector('.code .wrong')?.textContent.trim() === '2'", timeout=PATIENCE)
    assert page.page.locator(".code .mistake").inner_text().startswith("Line 2, column ")
    assert page.page.locator("#status").inner_text().startswith("the code has a mistake")
    assert field.evaluate("field => field === document.activeElement")  # though its slider came meanwhile
    assert field.get_attribute("aria-invalid") == "true"
    field.fill("float n = 0.002 * $gain;\nf@density *= n;")
    page.page.get_by_label("Apply ball: code code").click()
    page.page.wait_for_function("!document.querySelector('.code .wrong')", timeout=PATIENCE)
    page.settle()
    thin = page.pixels()
    assert thin.sum() < 0.6 * before.sum()
    page.slide("ball: code $gain, number", 500)  # which the expression brought, and which makes it what it was
    page.settle()
    assert numpy.abs(page.pixels() - before).max() <= 2
    field.fill("// not yet")
    page.page.get_by_label("Add a light").select_option("dome")  # which makes the panel anew
    page.page.get_by_label("Remove dome").click()
    page.page.wait_for_function("scrim.state.groups.filter(({ kind }) => kind === 'light').length === 2")
    assert field.input_value() == "// not yet"
    for _ in range(5):  # the light, the slider and both expressions
        page.page.click("#undo")
    page.page.wait_for_function("!scrim.state.changed")
    page.settle()
    assert field.input_value() == "" and page.page.get_by_label("ball: code $gain, number").count() == 0
    assert numpy.abs(page.pixels() - before).max() <= 2


def test_a_light_is_added_at_its_handle_and_removed_again(page_of):
    page = page_of(CENTRED)
    before = page.pixels()
    page.page.get_by_label("Add a light").select_option("point")
    page.page.wait_for_function("scrim.state.handles.some(({ light }) => light === 'point')")
    page.settle()
    lit = page.pixels()
    assert lit[..., 1].sum() > 1.5 * before[..., 1].sum()  # the other lights are red and blue
    assert centre(lit, 1)[0] > 0.5 and centre(lit, 1)[1] < 0.5  # from above, on the right
    handle = page.page.get_by_label("Place light point")
    assert handle.get_attribute("aria-pressed") == "true" and handle.bounding_box()
    page.page.get_by_label("Remove point").click()
    page.page.wait_for_function("scrim.state.handles.length === 2")
    page.settle()
    assert numpy.abs(page.pixels() - before).max() <= 2 and not page.page.evaluate("scrim.state.changed")
