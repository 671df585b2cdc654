# SPDX-License-Identifier: Apache-2.0
"""The page shows the picture over the backplate of the scene's preview, and focuses the lens where it is clicked."""

import numpy
import OpenImageIO
import pytest
from browsing import BALL, chromium, needs_chromium, page_of  # noqa: F401

import scrim

pytestmark = needs_chromium


@pytest.fixture
def plated(tmp_path):
    """A scene over a plate of another size."""
    down, across = numpy.mgrid[0:60, 0:80]
    plate = numpy.stack([across / 80, 0.5 + 0 * across, down / 60], axis=2).astype(numpy.float32)
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(80, 60, 3, OpenImageIO.UINT8))
    image.set_pixels(OpenImageIO.ROI(), plate)
    assert image.write(str(tmp_path / "plate.png"))
    return BALL + '[output]\npreview = { file = "p.png", backplate = "plate.png" }\n'


def test_a_frame_holds_its_backplate_and_one_without_has_none(plated, tmp_path):
    (tmp_path / "a.toml").write_text(plated)
    plate = scrim.open(tmp_path / "a.toml").render().backplate
    assert plate.shape == (192, 256, 4) and (plate[..., 3] == 1).all()
    assert (numpy.diff(plate[100, :, 0]) >= -1e-6).all() and plate[100, 250, 0] > 5 * plate[100, 5, 0]
    (tmp_path / "a.toml").write_text(BALL)
    assert scrim.open(tmp_path / "a.toml").render().backplate is None


def shown(page):
    """The canvas, rows from top to bottom."""
    pixels = numpy.array(page.page.evaluate("scrim.readPixels()"), float)
    return pixels.reshape(192, 256, 4)[::-1, :, :3]


def test_the_page_shows_what_the_preview_shows_also_with_other_weights(page_of, plated, tmp_path):  # noqa: F811
    page = page_of(plated)
    for intensity in (12, 3):
        if intensity != 12:
            page.slide("red (distant) intensity, number", intensity)
            page.page.wait_for_function("scrim.state.changed && scrim.picture.weights")
            page.page.wait_for_timeout(300)
        frame = scrim.open(tmp_path / "ball.toml", {"light.red.intensity": intensity}).render()
        frame.preview(tmp_path / "p.png")
        preview = OpenImageIO.ImageBuf(str(tmp_path / "p.png")).get_pixels(OpenImageIO.UINT8)[..., :3].astype(float)
        off = numpy.abs(shown(page) - preview)
        assert off.max() <= 14 and (off > 4).mean() < 0.02, intensity  # the table of the view is that far off


def test_the_plate_stays_while_the_view_turns(page_of, plated):  # noqa: F811
    page = page_of(plated)
    before = shown(page)
    picture = page.page.locator("#picture").bounding_box()
    x, y = picture["x"] + picture["width"] / 2, picture["y"] + picture["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x - 10, y)
    page.page.wait_for_function("scrim.picture.sharp.camera")
    moving = shown(page)
    assert numpy.abs(moving[:, :100] - before[:, :100]).max() <= 2  # the ball is to the right
    assert numpy.abs(moving[:, 100:] - before[:, 100:]).max() > 40
    page.page.mouse.up()
    page.settle()


def test_a_click_after_focus_makes_that_place_sharp_and_moves_no_camera(page_of):  # noqa: F811
    page = page_of(BALL)
    picture = page.page.locator("#picture").bounding_box()
    page.page.keyboard.press("d")
    assert page.page.locator("#focus").get_attribute("aria-pressed") == "true"
    # There also is the handle of a light, which does not get the click.
    page.page.mouse.click(picture["x"] + 0.746 * picture["width"], picture["y"] + picture["height"] / 2)
    page.page.wait_for_function("scrim.state.changed")
    page.settle()
    distance = float(page.page.get_by_label("Camera focus distance, number", exact=True).input_value())
    assert 4.6 < distance < 4.8  # the front of the ball: 5 - 0.35, and what is seen a little behind
    assert page.page.locator("#focus").get_attribute("aria-pressed") == "false"
    assert not page.page.evaluate("scrim.state.free")
    assert page.page.get_by_label("Camera f-stop, number", exact=True).input_value() == "2.8"
    page.page.click("#focus")
    page.page.click("#focus")  # waits no more
    page.drag(0.1, 0)
    page.page.wait_for_function("scrim.state.free")
    page.settle()
