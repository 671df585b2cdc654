# SPDX-License-Identifier: Apache-2.0
"""The viewer's page in a real browser: what it shows after clicks and drags, looked at pixel by pixel."""

import math

import numpy
import OpenImageIO
import pytest
from browsing import PATIENCE, PLACE, chromium, middle, needs_chromium, opened, page_of  # noqa: F401

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
