# SPDX-License-Identifier: Apache-2.0
"""Volumes, fields, instances, cameras, solids and media of OpenUSD stages."""

import math
import os
import zipfile
from pathlib import Path

import numpy
import pytest
from conftest import ROOT

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, Usd, UsdGeom, UsdVol  # noqa: E402
from usd_stages import EDGE, EXTINCTION, TAU, Stage, front, lit_fog_stage, write_fog  # noqa: E402

import scrim  # noqa: E402
import scrim.usd  # noqa: E402

DATA = Path(os.environ.get("SCRIM_DATA", ROOT / ".." / "shared" / "data"))
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no {DATA}; SCRIM_DATA names the test volumes")


@pytest.fixture
def foggy(tmp_path):
    return lit_fog_stage(tmp_path)


def alpha(frame):
    return frame.image[:, :, 3]


def covered(frame):
    """First and last column and row that the volume covers by more than half of its depth."""
    rows, columns = numpy.nonzero(alpha(frame) > 0.3)
    return columns.min(), columns.max(), rows.min(), rows.max()


def test_a_slab_is_where_and_what_the_stage_says(foggy):
    shot = foggy.open()
    frame = shot.render()
    assert shot.frames == [1] and shot.volumes == ["fog"]
    assert frame.image[7:9, 7:9, :3] == pytest.approx(front(1.0), rel=0.004)
    assert alpha(frame)[7:9, 7:9] == pytest.approx(1 - math.exp(-TAU), rel=0.004)
    assert not shot.warnings, shot.warnings


def test_fields_of_several_files_are_one_volume(tmp_path):
    """A slab whose glow is in another file: emission / extinction * (1 - exp(-tau)) comes on top."""
    write_fog(tmp_path)
    write_fog(tmp_path, "glow.vdb", value=2)
    stage = Stage(tmp_path)
    stage.camera()
    slab = stage.volume("/fog", ["slab.vdb", "glow.vdb"], ["density", "heat"])
    UsdVol.OpenVDBAsset.Get(stage.stage, "/fog/heat").GetFieldNameAttr().Set("density")
    stage.say(slab, "emission:grid", Sdf.ValueTypeNames.String, "heat")
    stage.say(slab, "emission:scale", Sdf.ValueTypeNames.Float, 0.005)
    shot = stage.open()
    volume = shot.scene(1)["volume"][0]
    assert "file" not in volume and volume["density"]["grid"] == "density"
    assert volume["medium"]["emission"]["grid"] == "heat"
    assert {name: text.rpartition("/")[2] for name, text in volume["grids"].items()} == {
        "density": "slab.vdb:density",
        "heat": "glow.vdb:density",
    }
    glow = 2 * 0.005 / EXTINCTION * (1 - math.exp(-TAU))
    assert shot.render().image[7:9, 7:9, :3] == pytest.approx(glow, rel=0.004)
    assert not shot.warnings, shot.warnings


def test_up_and_units_are_the_stages(tmp_path):
    """A stage with z up in centimetres: its numbers are world units as they are."""
    write_fog(tmp_path)
    stage = Stage(tmp_path, "Z", 0.01)
    stage.camera(place=(0, -50, 0), turn=(90, 0, 0))
    stage.volume().AddTranslateOp().Set(Gf.Vec3d(0, 0, 6))
    stage.light("DistantLight", intensity=1.0, angle=0.0).AddRotateXOp().Set(90.0)
    frame = stage.open(resolution=(24, 24)).render()
    x0, x1, y0, y1 = covered(frame)
    assert (x0, x1) == (4, 19) and y0 == 0 and y1 == 13  # up in the world is up in the picture
    assert frame.image[8, 12, :3] == pytest.approx(front(1.0), rel=0.01)


def test_the_fields_transform_places_the_grid(foggy):
    volume = UsdVol.Volume.Get(foggy.stage, "/fog")
    volume.AddTranslateOp().Set(Gf.Vec3d(2, 0, 0))
    field = UsdVol.OpenVDBAsset.Get(foggy.stage, "/fog/density")
    field.AddTranslateOp().Set(Gf.Vec3d(0, 4, 0))
    field.AddScaleOp().Set(Gf.Vec3f(0.5))
    x0, x1, y0, y1 = covered(foggy.open(resolution=(24, 24)).render())
    assert (x0, x1) == (10, 17) and (y0, y1) == (4, 11)


def test_a_field_elsewhere_goes_with_each_volume(foggy):
    UsdVol.OpenVDBAsset.Define(foggy.stage, "/shared/field").CreateFilePathAttr(Sdf.AssetPath("slab.vdb"))
    for name, x in (("left", -6.0), ("right", 6.0)):
        volume = foggy.volume("/" + name, [], [])
        volume.CreateFieldRelationship("density", "/shared/field")
        volume.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
    foggy.stage.GetPrimAtPath("/fog").SetActive(False)
    assert covered(foggy.open({"camera.height": 32}, resolution=(32, 32)).render())[:2] == (2, 29)


def test_the_index_of_a_field_picks_among_equal_names(tmp_path):
    if not DATA.is_dir():
        pytest.skip(f"no {DATA}; SCRIM_DATA names the test volumes")
    stage = Stage(tmp_path)
    stage.camera(ortho=10.0)
    volume = stage.volume(files=[str((DATA / "edge/arnold_three_grids_same_name.vdb").resolve())])
    index = UsdVol.OpenVDBAsset.Get(stage.stage, "/fog/density").CreateFieldIndexAttr()
    stage.say(volume, "density:scale", Sdf.ValueTypeNames.Float, 5.0)
    for number, x in enumerate((4.0, 2.0, 0.0)):
        index.Set(number)
        shot = stage.open(resolution=(40, 40))
        assert shot.scene(1)["volume"][0]["density"]["grid"] == f"density[{number}]"
        columns = (numpy.arange(40) + 0.5) / 4 - 5
        weights = alpha(shot.render()).sum(axis=0)
        assert (columns * weights).sum() / weights.sum() == pytest.approx(x, abs=0.1)


def test_frames_are_time_codes(foggy):
    """Frame N is not frame 1: files, places, lights and visibility change."""
    write_fog(foggy.folder, "thin.vdb", edge=EDGE, value=2)
    path = UsdVol.OpenVDBAsset.Get(foggy.stage, "/fog/density").GetFilePathAttr()
    path.Set(Sdf.AssetPath("slab.vdb"), 1)
    path.Set(Sdf.AssetPath("thin.vdb"), 3)
    foggy.stage.GetPrimAtPath("/key").GetAttribute("inputs:intensity").Set(1.0, 1)
    foggy.stage.GetPrimAtPath("/key").GetAttribute("inputs:intensity").Set(5.0, 5)
    place = UsdGeom.Xformable.Get(foggy.stage, "/fog").AddTranslateOp()
    place.Set(Gf.Vec3d(0, 0, 0), 4)
    place.Set(Gf.Vec3d(4, 0, 0), 5)
    foggy.stage.SetStartTimeCode(1)
    foggy.stage.SetEndTimeCode(5)
    foggy.stage.SetTimeCodesPerSecond(25)
    shot = foggy.open(resolution=(24, 24))
    assert shot.frames == [1, 2, 3, 4, 5] and shot.scene(1)["output"]["fps"] == 25
    frames = {n: shot.render(n) for n in shot.frames}
    assert frames[1].image[12, 12, 0] == pytest.approx(front(1.0), rel=0.01)
    assert frames[2].image[12, 12, 0] == pytest.approx(front(2.0), rel=0.01)
    assert alpha(frames[2])[12, 12] == pytest.approx(1 - math.exp(-TAU), rel=0.01)
    assert alpha(frames[3])[12, 12] == pytest.approx(1 - math.exp(-2 * TAU), rel=0.01)
    assert covered(frames[5])[0] == covered(frames[4])[0] + 4
    UsdGeom.Imageable.Get(foggy.stage, "/fog").GetVisibilityAttr().Set("invisible", 2)
    with pytest.raises(scrim.InputError, match="^the stage shows no volume at frame 2$"):
        foggy.open().render(2)


def test_value_clips_name_the_files(foggy):
    """The asset of each frame stands in a clip of its own."""
    write_fog(foggy.folder, "dense.vdb", value=2)
    for number, file in ((1, "slab.vdb"), (2, "dense.vdb")):
        clip = Usd.Stage.CreateNew(str(foggy.folder / f"clip.{number}.usda"))
        clip.OverridePrim("/fog/density").CreateAttribute("filePath", Sdf.ValueTypeNames.Asset).Set(
            Sdf.AssetPath(file), number
        )
        clip.Save()
    manifest = Usd.Stage.CreateNew(str(foggy.folder / "manifest.usda"))
    manifest.OverridePrim("/fog/density").CreateAttribute("filePath", Sdf.ValueTypeNames.Asset)
    manifest.Save()
    prim = foggy.stage.GetPrimAtPath("/fog")
    prim.GetChild("density").GetAttribute("filePath").Clear()
    clips = Usd.ClipsAPI(prim)
    clips.SetClipPrimPath("/fog")
    clips.SetClipAssetPaths([Sdf.AssetPath("./clip.1.usda"), Sdf.AssetPath("./clip.2.usda")])
    clips.SetClipManifestAssetPath(Sdf.AssetPath("./manifest.usda"))
    clips.SetClipActive([(1, 0), (2, 1)])
    clips.SetClipTimes([(1, 1), (2, 2)])
    shot = foggy.open()
    depths = [-math.log(1 - alpha(shot.render(n))[8, 8]) for n in (1, 2)]
    assert depths == pytest.approx([TAU, 2 * TAU], rel=0.01)


def test_an_expression_is_set_for_all_frames_of_a_stage(foggy):
    UsdGeom.Xformable(foggy.stage.GetPrimAtPath("/fog")).AddTranslateOp(opSuffix="a").GetAttr().Set((0, 0, 1), 2)
    shot = foggy.open()
    assert shot.volumes["fog"].grids == {}
    shot.volumes["fog"].ax = "f@density *= $gain;"
    shot.volumes["fog"].parameters = {"gain": 2.0}
    depths = [-math.log(1 - alpha(shot.render(n))[8, 8]) for n in (1, 2)]
    assert depths == pytest.approx([2 * TAU, 2 * TAU], rel=0.01)
    shot.volumes["fog"].parameters["gain"] = 0.5
    assert -math.log(1 - alpha(shot.render(2))[8, 8]) == pytest.approx(0.5 * TAU, rel=0.01)
    with pytest.raises(scrim.InputError, match="^--set camera.nothing: "):
        shot.set({"camera.nothing": 1})
    assert -math.log(1 - alpha(shot.render(1))[8, 8]) == pytest.approx(0.5 * TAU, rel=0.01)


def test_instances_are_where_they_are(foggy):
    stage = foggy.stage
    instancer = UsdGeom.PointInstancer.Define(stage, "/many")
    instancer.AddTranslateOp().Set(Gf.Vec3d(0, 2, 0))
    foggy.volume("/many/proto").AddScaleOp().Set(Gf.Vec3f(0.25))
    instancer.CreatePrototypesRel().AddTarget("/many/proto")
    instancer.CreateProtoIndicesAttr([0, 0, 0])
    instancer.CreatePositionsAttr([(-8, 0, 0), (0, 0, 0), (8, 0, 0)])
    instancer.CreateScalesAttr([(1, 1, 1), (1, 1, 1), (1, 2, 1)])
    instancer.CreateInvisibleIdsAttr([1])
    reference = stage.DefinePrim("/copy", "Xform")
    reference.GetReferences().AddInternalReference("/library")
    reference.SetInstanceable(True)
    UsdGeom.Xformable(reference).AddTranslateOp().Set(Gf.Vec3d(0, -8, 0))
    stage.CreateClassPrim("/library")
    foggy.volume("/library/smoke").AddScaleOp().Set(Gf.Vec3f(0.25))
    stage.GetPrimAtPath("/fog").SetActive(False)
    shot = foggy.open(resolution=(24, 24))
    assert shot.volumes == ["proto_0", "proto_2", "smoke"]
    seen = alpha(shot.render()) > 0.05
    rows, columns = numpy.nonzero(seen)
    assert sorted(set(columns)) == [2, 3, 4, 5, 10, 11, 12, 13, 18, 19, 20, 21]
    assert seen[8:12, 2:6].all() and seen[6:14, 18:22].all() and seen[18:22, 10:14].all()
    assert seen.sum() == 16 + 32 + 16


def test_what_is_not_shown_is_not_rendered(foggy):
    foggy.stage.GetPrimAtPath("/fog").GetAttribute("purpose").Set("proxy")
    with pytest.raises(scrim.InputError, match="shows no volume"):
        foggy.open().render()
    foggy.stage.GetPrimAtPath("/key").GetAttribute("purpose").Set("proxy")
    assert alpha(foggy.open(purpose="proxy").render()).max() > 0.5
    with pytest.raises(scrim.UsageError, match="^purpose='all': expected default, render, proxy or guide$"):
        foggy.open(purpose="all")


def projected(camera, point, width, height):
    """OpenUSD's own projection, as pixels from the top left."""
    frustum = camera.GetCamera(Usd.TimeCode(1)).frustum
    x, y, _ = (frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()).Transform(Gf.Vec3d(*point))
    return (x + 1) / 2 * width, (1 - y) / 2 * height


@pytest.mark.parametrize("ortho", [None, 12.0])
def test_a_camera_projects_as_usds_own(tmp_path, ortho):
    stage = Stage(tmp_path)
    camera = stage.camera(place=(3, 2, 20), ortho=ortho, turn=(-5, 10, 3))
    if not ortho:
        camera.GetFocalLengthAttr().Set(35.0)
        camera.GetHorizontalApertureAttr().Set(24.0)
    camera.GetVerticalApertureAttr().Set(0.75 * camera.GetHorizontalApertureAttr().Get())
    camera.GetHorizontalApertureOffsetAttr().Set(0.1 * camera.GetHorizontalApertureAttr().Get())
    camera.GetVerticalApertureOffsetAttr().Set(-0.05 * camera.GetHorizontalApertureAttr().Get())
    point = (1.5, 1.0, -2.0)
    stage.dust(place=point)
    stage.say(UsdVol.Volume.Get(stage.stage, "/dust"), "density:scale", Sdf.ValueTypeNames.Float, 5.0)
    seen = alpha(stage.open(resolution=(256, 192)).render()).astype(float)
    rows, columns = numpy.indices(seen.shape) + 0.5
    found = (columns * seen).sum() / seen.sum(), (rows * seen).sum() / seen.sum()
    assert found == pytest.approx(projected(camera, point, 256, 192), abs=0.1)


def test_near_and_what_a_camera_does_not_do(foggy):
    camera = UsdGeom.Camera.Get(foggy.stage, "/cam")
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(50, 70))
    shot = foggy.open()
    assert alpha(shot.render())[8, 8] == pytest.approx(1 - math.exp(-TAU / 2), rel=0.02)
    assert "/cam: its far clipping plane at 70 is not rendered" in shot.warnings


def test_a_lens_blurs_what_is_not_at_its_distance(foggy):
    camera = UsdGeom.Camera.Get(foggy.stage, "/cam")
    camera.GetProjectionAttr().Set(UsdGeom.Tokens.perspective)
    camera.GetFocalLengthAttr().Set(50.0)
    camera.GetFStopAttr().Set(2.0)
    camera.GetFocusDistanceAttr().Set(40.0)
    scene = foggy.open().scene(1)
    assert scene["camera"]["lens_radius"] == pytest.approx(0.1 * 50 / 4)
    assert scene["camera"]["focus_distance"] == 40
    camera.GetFStopAttr().Set(0.0)
    assert "lens_radius" not in foggy.open().scene(1)["camera"]


def test_the_shutter_blurs_what_moves(foggy):
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterOpenAttr().Set(-0.25)
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.25)
    still = foggy.open(resolution=(24, 24)).render()
    place = UsdGeom.Xformable.Get(foggy.stage, "/fog").AddTranslateOp()
    place.Set(Gf.Vec3d(-8, 0, 0), 0)
    place.Set(Gf.Vec3d(8, 0, 0), 2)
    shot = foggy.open(resolution=(24, 24))
    assert shot.scene(1)["camera"]["shutter"] == [-0.25, 0.25]
    keys = shot.scene(1)["volume"][0]["transform"]["translate"]["keys"]
    assert keys[0] == [0.75, [-2.0, 0.0, 0.0]] and keys[-1] == [1.25, [2.0, 0.0, 0.0]]
    moved = shot.render()
    # The edge passes over columns 2 to 5: at each it is there for a part of the time.
    parts = (alpha(moved)[12, 1:7] / alpha(still)[12, 12]).tolist()
    assert parts == pytest.approx([0, 0.125, 0.375, 0.625, 0.875, 1], abs=0.06)


def test_instances_move_and_velocities_blur(foggy):
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.5)
    instancer = UsdGeom.PointInstancer.Define(foggy.stage, "/many")
    foggy.volume("/many/proto", ["slab.vdb", "slab.vdb"], ["density", "vel"])
    instancer.CreatePrototypesRel().AddTarget("/many/proto")
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr().Set([(0, 0, 0)], 1)
    instancer.GetPositionsAttr().Set([(8, 0, 0)], 2)
    shot = foggy.open()
    moving = shot.scene(1)["volume"][1]
    keys = moving["transform"]["translate"]["keys"]
    assert keys[0] == [1.0, [0, 0, 0]] and keys[-1] == [1.5, [4, 0, 0]]
    assert moving["velocity"] == {"grid": "vel", "unit": "second"} and not shot.warnings
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.0)
    assert "velocity" not in foggy.open().scene(1)["volume"][1]


def test_a_turning_volume_turns_with_usd(foggy):
    UsdGeom.Camera.Get(foggy.stage, "/cam").GetShutterCloseAttr().Set(0.5)
    volume = UsdGeom.Xformable.Get(foggy.stage, "/fog")
    volume.AddRotateXYZOp().Set(Gf.Vec3f(10, 80, 30), 1)
    volume.GetOrderedXformOps()[0].Set(Gf.Vec3f(40, 110, -20), 2)
    volume.AddScaleOp().Set(Gf.Vec3f(1, -2, 3))
    shot = foggy.open()
    transform = shot.scene(1)["volume"][0]["transform"]
    for i, (time, _) in enumerate(transform["rotate"]["keys"]):
        x, y, z = (Gf.Rotation(Gf.Vec3d(*axis), a) for axis, a in zip(numpy.eye(3), transform["rotate"]["keys"][i][1]))
        scale = Gf.Matrix4d(1).SetScale(Gf.Vec3d(*transform["scale"]["keys"][i][1]))
        made = scale * Gf.Matrix4d(1).SetRotate(x * y * z)
        assert Gf.IsClose(made, volume.ComputeLocalToWorldTransform(Usd.TimeCode(time)), 1e-6), time


def test_solids_hide_and_shadow(foggy):
    half = UsdGeom.Mesh.Define(foggy.stage, "/wall")
    half.CreatePointsAttr([(0, -20, 12), (20, -20, 12), (20, 20, 12), (0, 20, 12)])
    half.CreateFaceVertexCountsAttr([4])
    half.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    half.CreateSubdivisionSchemeAttr("none")
    shot = foggy.open()
    hidden = shot.render().image
    assert hidden[8, 12].max() == 0 and hidden[8, 3, :3] == pytest.approx(front(1.0), rel=0.02)
    assert not shot.warnings
    shadowed = foggy.open(meshes="shadows").render().image
    assert shadowed[8, 12, 3] == pytest.approx(1 - math.exp(-TAU), rel=0.02) and shadowed[8, 12, 0] < 1e-4
    assert foggy.open(meshes="none").render().image[8, 12, 0] == pytest.approx(front(1.0), rel=0.02)
    half.GetSubdivisionSchemeAttr().Set("catmullClark")
    UsdGeom.Sphere.Define(foggy.stage, "/ball")
    cube = UsdGeom.Cube.Define(foggy.stage, "/box")
    cube.AddTranslateOp().Set(Gf.Vec3d(-6, 0, 12))
    shot = foggy.open()
    image = shot.render().image
    assert shot.warnings == [
        "/wall: it is not subdivided: its control cage hides and shadows",
        "/ball: solids of type Sphere neither hide volumes nor shadow them; only meshes do",
    ]
    assert image[8, 4, 3] < 0.3 < image[3, 4, 3]
    with pytest.raises(scrim.UsageError, match="^meshes='no': expected holdout, shadows or none$"):
        foggy.open(meshes="no")


def test_media_are_said_by_attributes_or_a_side_car(foggy):
    volume = UsdVol.Volume.Get(foggy.stage, "/fog")
    foggy.say(volume, "g", Sdf.ValueTypeNames.Float, 0.5)
    foggy.say(volume, "density:ramp", Sdf.ValueTypeNames.Float2Array, [(0, 0), (1, 2)])
    foggy.say(volume, "emission:grid", Sdf.ValueTypeNames.String, "density")
    foggy.say(volume, "emission:ramp", Sdf.ValueTypeNames.Float4Array, [(0, 0, 0, 0), (1, 1, 0.5, 0)])
    made = foggy.open().scene(1)["volume"][0]
    assert made["density"] == {"grid": "density", "scale": pytest.approx(EXTINCTION), "ramp": [[0, 0], [1, 2]]}
    assert made["medium"]["phase"] == {"g": 0.5, "type": "hg"} and made["medium"]["albedo"] == pytest.approx([0.9] * 3)
    assert made["medium"]["emission"]["ramp"] == [[0, [0, 0, 0]], [1, [1, 0.5, 0]]]
    side = foggy.folder / "side.toml"
    side.write_text('["/fog"]\ndensity.scale = 0.1\ng = -0.5\n["/key"]\nsamples = 4\n[render]\nquality = "draft"\n')
    shot = foggy.open(sidecar=side)
    made = shot.scene(1)
    assert made["volume"][0]["density"]["scale"] == 0.1 and made["volume"][0]["medium"]["phase"]["g"] == -0.5
    assert made["render"] == {"quality": "draft"} and made["light"][0]["samples"] == 4
    side.write_text('["/smog"]\ng = 0.5\n')
    with pytest.raises(scrim.InputError, match="side.toml: '/smog' is not a prim of the stage$"):
        foggy.open(sidecar=side)
    side.write_text('["/fog"]\ndensty.scale = 3\n')
    with pytest.raises(scrim.InputError, match=r"shot.usda:\d+:\d+: .*'densty'"):
        foggy.open(sidecar=side).render()


def test_the_exposure_of_the_camera_counts_once_in_each_frame(foggy):
    foggy.stage.GetPrimAtPath("/cam").GetAttribute("exposure").Set(2.0)
    foggy.stage.GetPrimAtPath("/fog").RemoveProperty("scrim:albedo")  # the side-car alone says what the medium is
    side = foggy.folder / "side.toml"
    side.write_text('["/fog".medium]\nemission = { grid = "density", scale = 2 }\n'
                    'blackbody = { grid = "density", intensity = 3 }\n')  # fmt: skip
    shot = foggy.open(sidecar=side)
    media = [shot.scene(frame)["volume"][0]["medium"] for frame in (1, 2, 3)]
    assert [medium["emission"]["scale"] for medium in media] == pytest.approx([8, 8, 8])
    assert [medium["blackbody"]["intensity"] for medium in media] == pytest.approx([12, 12, 12])


def test_a_volume_of_which_nothing_is_said_has_a_stated_medium(foggy):
    foggy.volume("/other", said=False)
    shot = foggy.open()
    assert shot.scene(1)["volume"][1]["medium"] == {"albedo": [0.18] * 3}
    assert [w for w in shot.warnings if w.startswith("/other: albedo 0.18, isotropic and extinction = grid value")]


def test_fields_that_cannot_be_mapped_are_named(foggy):
    volume = foggy.volume("/two", ["slab.vdb", "slab.vdb"], ["smoke", "heat"])
    shot = foggy.open()
    shot.scene(1)
    assert any("/two: none of its fields heat, smoke is called density" in w for w in shot.warnings), shot.warnings
    foggy.say(volume, "density:grid", Sdf.ValueTypeNames.String, "smoke")
    foggy.say(volume, "blackbody:grid", Sdf.ValueTypeNames.String, "heat")
    UsdVol.OpenVDBAsset.Get(foggy.stage, "/two/heat").AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    volume.CreateFieldRelationship("lost", "/nowhere")
    shot = foggy.open()
    assert shot.scene(1)["volume"][1]["medium"]["blackbody"] == {"grid": "heat"}
    assert "/two: field 'heat' stands elsewhere than the density, and is read where that is" in shot.warnings
    assert "/two: field 'lost' is /nowhere, nothing and not an OpenVDBAsset, and is not read" in shot.warnings


def test_an_asset_is_the_file_of_that_very_name(foggy):
    """Another file, which is one of its frames where the name is taken for a pattern, does not stand in for it."""
    asset = foggy.stage.GetPrimAtPath("/fog/density").GetAttribute("filePath")
    write_fog(foggy.folder, "take1.vdb")
    for name in ("take#.vdb", "take%d.vdb", "take$F.vdb"):
        asset.Set(Sdf.AssetPath(str(foggy.folder / name)))
        with pytest.raises(scrim.InputError, match="take"):
            foggy.open().render(1)
        write_fog(foggy.folder, name)
        assert alpha(foggy.open().render(1)).max() > 0.3


def test_archives_are_read(foggy):
    from pxr import UsdUtils

    foggy.stage.Save()
    archive = foggy.folder / "shot.usdz"
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(foggy.path)), str(archive))
    packed = scrim.usd.open(archive, {"render.quality": "ultra"}, resolution=(16, 16)).render().image
    assert numpy.array_equal(packed, foggy.open().render().image)


def test_archives_of_one_name_are_told_apart(foggy):
    for name, value in (("one", 1), ("two", 2)):
        (foggy.folder / name).mkdir()
        with zipfile.ZipFile(foggy.folder / name / "fog.usdz", "w") as archive:
            archive.write(write_fog(foggy.folder / name, value=value), "fog.vdb")
    asset = foggy.stage.GetPrimAtPath("/fog/density").GetAttribute("filePath")
    for name in ("one", "two"):
        asset.Set(Sdf.AssetPath(f"{name}/fog.usdz[fog.vdb]"), 1 if name == "one" else 2)
    shot = foggy.open()
    files = [shot.scene(frame)["volume"][0]["file"] for frame in (1, 2)]
    images = [shot.render(frame).image[8, 8, 3] for frame in (1, 2)]
    assert files[0] != files[1]
    assert images == pytest.approx([1 - math.exp(-TAU), 1 - math.exp(-2 * TAU)], rel=0.01)


@needs_data
@pytest.mark.parametrize("path", sorted(str(p) for p in DATA.glob("usd/*.usda")), ids=lambda p: Path(p).stem)
def test_openusds_own_volumes_are_rendered(path):
    shot = scrim.usd.open(path, {"render.quality": "draft"}, resolution=(64, 64))
    # The first file of the sequence has grids without voxels.
    assert alpha(shot.render(2)).max() > 0.02


def test_errors_say_what_there_is(foggy, tmp_path):
    with pytest.raises(scrim.InputError, match=r"absent.usda: no such file$"):
        scrim.usd.open(tmp_path / "absent.usda")
    (tmp_path / "bad.usda").write_text("#usda 1.0\ndef {")
    with pytest.raises(scrim.InputError, match=r"bad.usda: OpenUSD cannot read it: "):
        scrim.usd.open(tmp_path / "bad.usda")
    with pytest.raises(scrim.InputError, match=r"^'/eye' is not a camera of the stage; expected /cam$"):
        foggy.open(camera="/eye").render()
    foggy.camera("/second")
    with pytest.raises(scrim.InputError, match=r"^the stage has 2 cameras: name one of /cam, /second$"):
        foggy.open().render()
    assert foggy.open(camera="second").scene(1)["camera"]["type"] == "orthographic"
