# SPDX-License-Identifier: Apache-2.0
"""The viewer on stages of OpenUSD: their cameras, and what they leave behind when they are saved as scenes."""

import numpy
import pytest

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")
pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, UsdGeom, UsdRender  # noqa: E402
from usd_stages import lit_fog_stage  # noqa: E402
from viewing import Viewer  # noqa: E402

import scrim  # noqa: E402


@pytest.fixture
def stage(tmp_path):
    """The slab with a card that hides half of it, and a second camera from the side."""
    made = lit_fog_stage(tmp_path)
    made.camera("/World/side", place=(50, 0, 0), turn=(0, 90, 0))
    card = UsdGeom.Plane.Define(made.stage, "/card")
    card.GetAxisAttr().Set("Z")
    card.GetWidthAttr().Set(12.0)
    card.GetLengthAttr().Set(30.0)
    UsdGeom.Xformable(card).AddTranslateOp().Set((6, 0, 20))
    made.stage.SetMetadata("renderSettingsPrimPath", "/Render/rs")
    settings = UsdRender.Settings.Define(made.stage, "/Render/rs")
    settings.GetResolutionAttr().Set(Gf.Vec2i(32, 32))
    settings.GetCameraRel().SetTargets(["/cam"])
    made.stage.Save()
    return made.path


@pytest.fixture
def browser(stage, python_path):
    viewer = Viewer(stage, python_path)
    browser = viewer.browser()
    yield browser
    browser.close()
    viewer.close()


def test_a_stage_is_seen_through_its_other_cameras(browser):
    front = browser.until_exact()
    assert browser.state["cameras"] == ["/cam", "/World/side"]
    assert front[16, 26, 3] == 0 and front[16, 6, 3] > 0.1  # the card hides the right half
    browser.send(type="camera", name="/World/side", done=True)
    side = browser.until_exact()
    assert side[16, 16, 3] > 0.1 and numpy.abs(side - front).max() > 0.1
    browser.send(type="undo")
    assert numpy.array_equal(browser.until_exact(), front)
    browser.send(type="camera", name="/key")
    assert "no camera '/key'" in browser.until(lambda m: m["type"] == "error")["text"]


def test_a_saved_stage_keeps_its_solids(browser, stage):
    shown = browser.until_exact()
    browser.send(type="save", name="kept.toml")
    browser.until(lambda m: m["type"] == "state" and m["file"] == "kept.toml")
    folder = stage.parent
    (solid,) = (folder / "kept.files").iterdir()
    assert f'file = "kept.files/{solid.name}"' in (folder / "kept.toml").read_text()
    picture = scrim.open(folder / "kept.toml").render().image
    assert numpy.array_equal(picture.astype(numpy.float16), shown)
    assert numpy.array_equal(browser.until_exact(), shown)
