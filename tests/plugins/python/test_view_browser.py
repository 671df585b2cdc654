# SPDX-License-Identifier: Apache-2.0
"""The viewer's page in a real browser: what it shows after clicks and drags, looked at pixel by pixel."""

import math

import numpy
import OpenImageIO
import pytest
from browsing import BALL, PATIENCE, PLACE, chromium, middle, needs_chromium, opened, page_of  # noqa: F401

import scrim

pytestmark = needs_chromium


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


def test_verified_pixels_lie_on_the_picture_in_the_colours_of_their_errors(page_of, tmp_path):
    page = page_of(BALL + '[render]\nquality = "draft"\n')
    before = page.pixels()
    page.page.click("#verify")
    page.page.wait_for_function("!document.getElementById('verified').hidden", timeout=PATIENCE)
    shown = page.page.locator("#picture")
    path = str(tmp_path / "errors.png")
    shown.screenshot(path=path, style="#handles, #verified { display: none }")
    errors = OpenImageIO.ImageBuf(path).get_pixels(OpenImageIO.UINT8)[..., :3].astype(float)
    frame = scrim.open(tmp_path / "ball.toml").render(verify=400)
    place, off = frame.examined["place"], frame.examined["picture"] - frame.examined["truth"]
    error = numpy.sqrt((off[:, :3] ** 2).mean(axis=1)) / frame.stats["verification"]["mean"]
    times = error / 0.03  # what a draft of a medium promises
    assert times.min() < 0.25 and times.max() > 1
    # Marks that no worse one covers have their colours: those of the scale, evenly by factors from 1/4 to 4.
    scale = numpy.array([[106, 155, 255], [80, 216, 232], [96, 216, 96], [240, 208, 64], [255, 106, 80]], float)
    height, width = errors.shape[:2]
    checked = 0
    for index, (x, y) in enumerate(place):
        at = numpy.array([(x + 0.5) / 256 * width, (y + 0.5) / 192 * height])
        others = (place + 0.5) / (256, 192) * (width, height) - at
        if ((numpy.abs(others).max(axis=1) < 10) & (error >= error[index])).sum() > 1:  # itself is one
            continue
        position = numpy.clip(2 + numpy.log2(max(times[index], 1e-9)), 0, 4)
        wanted = [numpy.interp(position, range(5), scale[:, channel]) for channel in range(3)]
        assert numpy.abs(errors[int(at[1]), int(at[0])] - wanted).max() <= 3, (x, y, times[index])
        checked += 1
    assert checked > 20
    # The worst pixel, by its key, has its values.
    page.page.keyboard.press("n")
    worst = int(numpy.argmax(error))
    text = page.page.locator("#error-value").inner_text()
    assert text.startswith(f"{place[worst][0]}, {place[worst][1]}: error ")
    assert float(text.split("error ")[1].split(" %")[0]) == pytest.approx(100 * error[worst], rel=0.006)
    truth = [float(word) for word in text.splitlines()[2].split()[1:]]
    assert truth == pytest.approx(list(frame.examined["truth"][worst][:3]), rel=0.006, abs=1e-6)
    # So does the one under the pointer.
    box = shown.bounding_box()
    x, y = place[3]
    page.page.mouse.move(box["x"] + (x + 0.5) / 256 * box["width"], box["y"] + (y + 0.5) / 192 * box["height"])
    page.page.wait_for_function(f"document.getElementById('error-value').textContent.startsWith('{x}, {y}:')")
    # Whatever changes the picture takes them away.
    page.slide("blue (distant) intensity, number", 5)
    page.page.wait_for_function("document.getElementById('errors').hidden")
    page.settle()
    assert page.page.locator("#errors").is_hidden()
    page.page.click("#undo")
    page.page.wait_for_function("!scrim.state.changed")
    page.settle()
    assert page.page.locator("#errors").is_hidden() and numpy.abs(page.pixels() - before).max() <= 2


def test_regions_have_the_mean_of_their_errors(page_of, tmp_path):
    page = page_of(BALL + '[render]\nquality = "draft"\n')
    page.page.click("#verify")
    page.page.wait_for_function("!document.getElementById('verified').hidden", timeout=PATIENCE)
    page.page.check("#error-regions")
    regions = page.page.evaluate("scrim.verified.regions()")
    frame = scrim.open(tmp_path / "ball.toml").render(verify=400)
    place, off = frame.examined["place"], frame.examined["picture"] - frame.examined["truth"]
    error = (off[:, :3] ** 2).mean(axis=1) / frame.stats["verification"]["mean"] ** 2
    found = {(region["x"], region["y"]): region["error"] for region in regions}
    side = 256 // 8
    for column, row in {tuple(p // side) for p in place}:
        inside = (place // side == (column, row)).all(axis=1)
        assert found.pop((column * side, row * side)) == pytest.approx(numpy.sqrt(error[inside].mean()), rel=1e-3)
    assert not found
