# SPDX-License-Identifier: Apache-2.0
"""What a stage holds that is wrong or cannot be mapped is named, prim by prim."""

import zipfile

import pytest

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, UsdGeom, UsdRender, UsdVol  # noqa: E402
from usd_stages import Stage, fog_stage, write_fog  # noqa: E402

import scrim  # noqa: E402
import scrim.usd  # noqa: E402


@pytest.fixture
def foggy(tmp_path):
    return fog_stage(tmp_path)


def warnings_of(stage, **keywords):
    shot = stage.open(**keywords)
    shot.scene(1)
    return shot.warnings


def test_colours(foggy):
    light = foggy.light("DistantLight", color=Gf.Vec3f(1, -0.5, 0.25), intensity=-2.0)
    light.GetColorAttr().SetColorSpace("mine")
    found = warnings_of(foggy)
    assert "/key: inputs:color is [1.0, -0.5, 0.25]; what is below 0 is taken as 0" in found
    assert "/key: inputs:color: colour space 'mine' is not known, and taken as lin_rec709_scene" in found
    assert "/key: its intensity is below 0, and taken as 0" in found
    light.GetColorAttr().SetColorSpace("raw")
    light.GetColorAttr().Set(Gf.Vec3f(1, 0.5, 0.25))
    assert foggy.open().scene(1)["light"][0]["color"] == [1, 0.5, 0.25]


def test_shapes_of_lights(foggy):
    disk = foggy.light("DiskLight", "/disk")
    disk.AddScaleOp().Set(Gf.Vec3f(1, 4, 1))
    rectangle = foggy.light("RectLight", "/flat")
    sheared = Gf.Matrix4d(1)
    sheared.SetRow3(1, Gf.Vec3d(0.5, 1, 0))
    rectangle.AddTransformOp().Set(sheared)
    nothing = foggy.light("SphereLight", "/nothing", radius=0.0)
    foggy.light("DistantLight", "/wide", angle=200.0)
    found = warnings_of(foggy)
    assert "/disk: its scale differs along axes: an ellipse is rendered as a disk of the same area" in found
    assert "/flat: it is sheared, but rendered with right angles" in found
    assert "/nothing: a sphere without a size gives no light unless it is normalized" in found
    assert "/wide: its angle of 200 degrees is rendered as 180" in found
    tables = {light["name"]: light for light in foggy.open().scene(1)["light"]}
    assert tables["disk"]["radius"] == pytest.approx(1.0) and tables["nothing"]["type"] == "point"
    assert nothing.GetPrim().IsValid()


def test_cameras(foggy):
    foggy.light("DistantLight", intensity=1.0, angle=0.0)
    camera = UsdGeom.Camera.Get(foggy.stage, "/cam")
    camera.GetShutterOpenAttr().Set(0.5)
    camera.GetShutterCloseAttr().Set(0.25)
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(-1, 1e7))
    camera.GetClippingPlanesAttr().Set([Gf.Vec4f(0, 0, 1, 0)])
    assert warnings_of(foggy) == [
        "/cam: its shutter closes at 0.25, before it opens at 0.5, and is taken as none",
        "/cam: its clipping planes are not rendered",
        "/cam: its near clipping plane at -1 is taken as 0: nothing behind the camera is seen",
    ]


def test_solids(foggy):
    foggy.light("DistantLight", intensity=1.0, angle=0.0)
    mesh = UsdGeom.Mesh.Define(foggy.stage, "/odd")
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 2, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([5])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 9])
    assert "/odd: its faces do not fit its points, and it is left out" in warnings_of(foggy)
    mesh.GetFaceVertexIndicesAttr().Set([0, 1, 2, 3, 4])
    for time, top in ((1, 2), (2, 3)):
        mesh.GetPointsAttr().Set([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, top, 0), (0, 1, 0)], time)
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.5)
    shot = foggy.open()
    (made,) = shot.scene(1)["mesh"]
    assert shot.warnings == [
        "/odd: faces of more than four corners are cut into fans, which is right where they are convex",
        "/odd: its points move: while the shutter is open those of the frame are taken",
    ]
    with open(made["file"], "rb") as file:
        assert b"element face 3\n" in file.read()


def test_motion_with_shear(foggy):
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.5)
    volume = UsdGeom.Xformable.Get(foggy.stage, "/fog")
    sheared = Gf.Matrix4d(1)
    sheared.SetRow3(1, Gf.Vec3d(0.5, 1, 0))
    move = volume.AddTransformOp()
    move.Set(sheared, 1)
    move.Set(sheared * Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(3, 0, 0)), 2)
    shot = foggy.open()
    assert list(shot.scene(1)["volume"][0]["transform"]) == ["matrix"]
    assert "/fog: it is sheared, so its motion is not blurred" in shot.warnings


def test_instances(foggy):
    instancer = UsdGeom.PointInstancer.Define(foggy.stage, "/many")
    foggy.volume("/many/proto")
    instancer.CreatePrototypesRel().AddTarget("/many/proto")
    instancer.CreateProtoIndicesAttr([0, 1])
    instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0)])
    assert "/many: its instances have no place or no prototype, and are left out" in warnings_of(foggy)
    instancer.GetProtoIndicesAttr().Set([0, 0])
    instancer.GetPositionsAttr().Set([(0, 0, 0)])
    assert "/many: its instances have no place or no prototype, and are left out" in warnings_of(foggy)


def test_volumes(foggy):
    UsdVol.Volume.Define(foggy.stage, "/empty")
    flat = foggy.volume("/flat")
    flat.AddScaleOp().Set(Gf.Vec3f(1, 0, 1))
    foggy.volume("/nowhere", files=[""])
    foggy.stage.GetPrimAtPath("/fog").CreateRelationship("scrim:lights")
    found = warnings_of(foggy)
    assert "/empty: it has no field that can be read, and is not rendered" in found
    assert "/flat: its transform makes it flat, and it is not rendered" in found
    assert "/nowhere/density: it has no file at frame 1, and is not read" in found
    assert "/fog: scrim:lights is not an attribute, and is not read" in found


def test_products(foggy):
    settings = UsdRender.Settings.Define(foggy.stage, "/rs")
    settings.GetProductsRel().SetTargets(["/fog", "/main"])
    made = UsdRender.Product.Define(foggy.stage, "/main")
    made.GetOrderedVarsRel().SetTargets(["/nowhere"])
    found = warnings_of(foggy, settings="/rs")
    assert "/rs: product /fog is not a RenderProduct, and is not read" in found
    assert "/main: render var /nowhere is not a RenderVar, and is not read" in found


def test_archives_and_side_cars_that_are_bad(foggy):
    with zipfile.ZipFile(foggy.folder / "bad.usdz", "w") as file:
        file.writestr("other.txt", "nothing")
    asset = UsdVol.OpenVDBAsset.Get(foggy.stage, "/fog/density").GetFilePathAttr()
    asset.Set(Sdf.AssetPath("bad.usdz[slab.vdb]"))
    with pytest.raises(scrim.InputError, match=r"bad.usdz\[slab.vdb\]: "):
        foggy.open().scene(1)
    (foggy.folder / "side.toml").write_text("= 3")
    with pytest.raises(scrim.InputError, match="side.toml: Invalid statement"):
        foggy.open(sidecar=foggy.folder / "side.toml")


def test_a_shot_does_one_thing_at_a_time(foggy):
    shot = foggy.open({"render.antialias": 8}, resolution=(256, 256))
    job = shot.start(1)
    if not job.done:
        with pytest.raises(
            scrim.UsageError, match="shot.usda: the shot is at work; wait for it, or open the stage once"
        ):
            shot.render(2)
    assert job.result().image.shape == (256, 256, 4)
    assert "sheets" in str(shot.plan(1)) and "[[volume]]" in shot.toml(1)
    assert repr(shot).startswith("<scrim.usd.Shot '")
    assert scrim.usd.Shot is type(shot)
    with pytest.raises(AttributeError, match="module 'scrim.usd' has no attribute 'shoot'"):
        scrim.usd.shoot  # noqa: B018


def test_a_stage_in_the_dark_says_so(tmp_path):
    write_fog(tmp_path)
    dark = Stage(tmp_path, "Y")
    dark.volume()
    assert "/: it has no light, and nothing that glows: the volumes are black" in warnings_of(dark)
    dark.light("DistantLight", intensity=1.0, angle=0.0)
    assert not [warning for warning in warnings_of(dark) if "no light" in warning]
