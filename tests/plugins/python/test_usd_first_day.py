# SPDX-License-Identifier: Apache-2.0
"""Stages that leave things unsaid: without a camera, without named settings; and what a shot of a stage can do."""

import sys

import numpy
import pytest

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, UsdGeom, UsdRender  # noqa: E402
from usd_stages import EDGE, Stage, fog_stage, lit_fog_stage, write_fog  # noqa: E402

import scrim  # noqa: E402
import scrim.usd  # noqa: E402


def bare_stage(folder, up="Y"):
    """The slab without a camera."""
    write_fog(folder)
    stage = Stage(folder, up)
    stage.volume()
    stage.light("DistantLight", intensity=1.0, angle=0.0)
    return stage


def camera_of(stage, **keywords):
    return stage.open(resolution=(64, 48), **keywords).scene(1)["camera"]


def pixels_of(camera, points):
    """Where a camera of a scene shows points of the world: x and y from the middle, 1 at the picture's sides."""
    seen = numpy.linalg.inv(camera["matrix"]) @ numpy.c_[points, numpy.ones(len(points))].T
    across = numpy.tan(numpy.radians(camera["fov"] / 2))
    width, height = camera["resolution"]
    return seen[0] / -seen[2] / across, seen[1] / -seen[2] / across * width / height


@pytest.mark.parametrize("up, axis", [("Y", (0, 1, 0)), ("Z", (0, 0, 1))])
def test_a_stage_without_a_camera_is_framed_as_its_asset(tmp_path, up, axis):
    stage = bare_stage(tmp_path, up)
    shot = stage.open(resolution=(64, 48))
    made = shot.scene(1)["camera"]
    asset = scrim.open(tmp_path / "slab.vdb", up=axis, resolution=(64, 48)).resolved(1)["camera"]
    assert numpy.array(made["matrix"]) == pytest.approx(numpy.array(asset["matrix"]))
    assert made["fov"] == asset["fov"] and made["resolution"] == [64, 48]
    eye = ", ".join(f"{row[3]:.4g}" for row in made["matrix"][:3])
    (said,) = [w for w in shot.warnings if "camera" in w]
    assert said.startswith(f"/: the stage has no camera: one stands at ({eye}), looks along (")
    image = shot.render().image
    assert image[20:28, 28:36, 3].min() > 0.3 and image[0].max() == 0  # the slab is in the middle, and not all there is


def test_the_program_frames_it_too(tmp_path, program, python_path):
    stage = bare_stage(tmp_path)
    stage.stage.Save()
    environment = {**python_path, "SCRIM_PYTHON": sys.executable}
    done = program("render", stage.path, "--res", "32x24", "-o", tmp_path / "bare.exr", env=environment)
    assert done.returncode == 0 and "the stage has no camera: one stands at (" in done.stderr, done.stderr
    assert (tmp_path / "bare.exr").exists()


def test_the_framing_goes_with_the_transform_of_the_volume(tmp_path):
    stage = bare_stage(tmp_path)
    before = numpy.array(camera_of(stage)["matrix"])
    move = Gf.Matrix4d(1).SetScale(3.0) * Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(100, 20, -7))
    UsdGeom.Xformable.Get(stage.stage, "/fog").AddTransformOp().Set(move)
    after = numpy.array(camera_of(stage)["matrix"])
    assert after[:3, :3] == pytest.approx(before[:3, :3])
    assert after[:3, 3] == pytest.approx(3 * before[:3, 3] + (100, 20, -7))


def test_several_volumes_and_those_that_move_are_all_in_the_picture(tmp_path):
    stage = bare_stage(tmp_path)
    UsdGeom.Xformable(stage.volume("/second")).AddTranslateOp().Set(Gf.Vec3d(90, 0, 0))
    lift = UsdGeom.Xformable.Get(stage.stage, "/fog").AddTranslateOp()
    stage.stage.SetStartTimeCode(1)
    stage.stage.SetEndTimeCode(9)
    lift.Set(Gf.Vec3d(0, 0, 0), 1)
    lift.Set(Gf.Vec3d(0, 60, 0), 9)
    shot = stage.open(resolution=(64, 48))
    cameras = [shot.scene(frame)["camera"] for frame in (1, 4, 9)]
    assert cameras[0] == cameras[1] == cameras[2]
    half = EDGE / 2
    corners = numpy.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    places = numpy.vstack([corners + move for move in ((0, 0, 0), (90, 0, 0), (0, 60, 0))])
    x, y = pixels_of(cameras[0], places)
    assert max(abs(x).max(), abs(y).max()) == pytest.approx(1 / 1.05, abs=0.03)  # as near as that may be


def test_nothing_to_frame_is_said(tmp_path):
    stage = Stage(tmp_path)
    with pytest.raises(scrim.InputError, match="shows no volume at frame 1$"):
        stage.open().scene(1)


@pytest.fixture
def foggy(tmp_path):
    return lit_fog_stage(tmp_path)


def test_the_only_settings_and_product_need_no_name(foggy):
    made = UsdRender.Settings.Define(foggy.stage, "/Render/rs")
    made.GetResolutionAttr().Set(Gf.Vec2i(40, 20))
    product = UsdRender.Product.Define(foggy.stage, "/Render/main")
    product.GetProductNameAttr().Set("main.exr")
    shot = foggy.open(resolution=None)
    scene = shot.scene(1)
    assert scene["camera"]["resolution"] == [40, 20] and scene["output"]["file"] == "main.exr" and shot.warnings == []
    foggy.stage.RemovePrim("/Render/rs")
    product.GetResolutionAttr().Set(Gf.Vec2i(30, 20))
    product.GetProductNameAttr().Set("alone.exr")
    scene = foggy.open(resolution=None).scene(1)
    assert scene["camera"]["resolution"] == [30, 20] and scene["output"]["file"] == "alone.exr"


def test_several_settings_or_products_are_listed_and_none_is_read(foggy):
    for name in ("a", "b"):
        UsdRender.Settings.Define(foggy.stage, f"/Render/{name}").GetResolutionAttr().Set(Gf.Vec2i(40, 20))
    shot = foggy.open(resolution=None)
    assert shot.scene(1)["camera"]["resolution"] == [960, 960] and "file" not in shot.scene(1)["output"]
    assert shot.warnings == ["RenderSettings: the stage has 2 and names none: /Render/a, /Render/b; none is read"]
    foggy.stage.RemovePrim("/Render/b")
    for name in ("x", "y"):
        UsdRender.Product.Define(foggy.stage, f"/Render/{name}").GetProductNameAttr().Set(f"{name}.exr")
    shot = foggy.open(resolution=None)
    assert shot.scene(1)["camera"]["resolution"] == [40, 20] and "file" not in shot.scene(1)["output"]
    assert shot.warnings == ["RenderProduct: the stage has 2 and names none: /Render/x, /Render/y; none is read"]


def test_cameras_are_listed_and_looked_through(foggy):
    foggy.camera("/World/side", place=(50, 0, 0), turn=(0, 90, 0))
    foggy.stage.Save()
    assert scrim.usd.cameras(foggy.path) == ["/cam", "/World/side"]
    shot = foggy.open(camera="/cam")
    other = shot.through("side")
    assert shot.cameras == ["/cam", "/World/side"]
    assert [row[3] for row in other.scene(1)["camera"]["matrix"]][:3] == pytest.approx([50, 0, 0])
    assert [row[3] for row in shot.scene(1)["camera"]["matrix"]][:3] == pytest.approx([0, 0, 50])
    with pytest.raises(scrim.InputError, match="'none' is not a camera of the stage; expected /cam, /World/side"):
        shot.through("none")


def test_a_shot_of_a_stage_takes_grids_made_in_code_in_all_frames(tmp_path):
    stage = fog_stage(tmp_path)
    stage.light("DistantLight", intensity=1.0, angle=0.0).GetIntensityAttr().Set(2.0, 2)
    shot = stage.open()
    whole = shot.render(1).image[8, 8, 3]
    shot.set_volume("fog", scrim.Field(numpy.full((16, 16, 4), 1.0, numpy.float32), origin=(-7.5, -7.5, -1.5)))
    thin = [shot.render(frame).image[8, 8, 3] for frame in (1, 2)]
    expected = 1 - (1 - whole) ** (4 / 16)
    assert thin == pytest.approx([expected] * 2, rel=0.01)
    with pytest.raises(scrim.UsageError, match="there is no volume 'smoke'; there is 'fog'"):
        shot.set_volume("smoke", scrim.Field(numpy.ones((2, 2, 2), numpy.float32)))


def test_a_shot_of_a_stage_is_studied(foggy, tmp_path):
    found = foggy.open({"render.quality": "draft"}).study(1, tmp_path / "study", budget=1.0)
    assert found and (tmp_path / "study" / "study.csv").exists()


def test_a_product_asks_for_a_window_of_a_framed_stage(tmp_path):
    stage = bare_stage(tmp_path)
    product = UsdRender.Product.Define(stage.stage, "/main")
    product.GetDataWindowNDCAttr().Set(Gf.Vec4f(0.25, 0.25, 0.75, 0.75))
    product.GetResolutionAttr().Set(Gf.Vec2i(32, 32))
    stage.say(product, "render:quality", Sdf.ValueTypeNames.String, "draft")
    shot = stage.open(resolution=None)
    assert shot.crop(1) == (8, 8, 24, 24) and shot.render().image.shape == (16, 16, 4)
