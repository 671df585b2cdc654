# SPDX-License-Identifier: Apache-2.0
"""UsdLux: every light against the closed form of what its text says arrives."""

import math
from pathlib import Path

import numpy
import pytest

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdVol  # noqa: E402
from usd_stages import Stage, behind, fluence, front, write_fog  # noqa: E402

FINE = {"render.light_error": 0.002}
DISTANCE = 4.0
LUMINAIRES = Path(__file__).resolve().parents[3] / "examples/scenes/luminaires"


@pytest.fixture
def dusty(tmp_path):
    stage = Stage(tmp_path)
    stage.camera(place=(0, 0, 20), ortho=0.6)
    stage.dust()
    return stage


def arrives(stage, **keywords):
    """Of each channel."""
    shot = stage.open(FINE, **keywords)
    return fluence(shot.render()), shot


def at_distance(light, turn=(0, 0, 0)):
    """Off the dust along +z, so that it shines on it along -z."""
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, DISTANCE))
    light.AddRotateXYZOp().Set(Gf.Vec3f(*turn))
    return light


def cap(angle):
    return 2 * math.pi * (1 - math.cos(math.radians(angle / 2)))


@pytest.mark.parametrize(
    "angle, normalize, expected",
    [
        (0.0, False, 3.0),
        (0.0, True, 3.0),
        (40.0, False, 3.0 * cap(40)),
        (40.0, True, 3.0 * cap(40) / (math.pi * math.sin(math.radians(20)) ** 2)),
    ],
)
def test_a_distant_light_is_radiance_over_its_disk(dusty, angle, normalize, expected):
    dusty.light("DistantLight", intensity=3.0, angle=angle, normalize=normalize)
    found, shot = arrives(dusty)
    assert found == pytest.approx([expected] * 3, rel=0.005)
    card = 3.0 * (math.pi * math.sin(math.radians(angle / 2)) ** 2 if angle and not normalize else 1)
    assert any(f"/key: irradiance {card:.4g} on what faces it" in note for note in shot.notes), shot.notes


def test_files_from_before_may_mean_irradiance(dusty):
    dusty.light("DistantLight", intensity=3.0, angle=0.53)
    now, _ = arrives(dusty)
    before, shot = arrives(dusty, distant="irradiance")
    assert before == pytest.approx([3.0] * 3, rel=0.005)
    assert now == pytest.approx(before * math.pi * math.sin(math.radians(0.265)) ** 2, rel=0.005)
    assert "irradiance 3 on what faces it" in shot.notes[0] and "read as irradiance" in shot.notes[0]


def test_a_slab_lit_along_and_against_the_view(tmp_path):
    write_fog(tmp_path)
    stage = Stage(tmp_path)
    stage.camera()
    stage.volume()
    turned = stage.light("DistantLight", intensity=2.0, angle=0.0, normalize=True).AddRotateYOp()
    for turn, closed in ((0.0, front), (180.0, behind)):
        turned.Set(turn)
        middle = stage.open().render().image[7:9, 7:9, :3]
        assert middle == pytest.approx(closed(2.0), rel=0.004)


@pytest.mark.parametrize("scale", [1.0, 0.5])
@pytest.mark.parametrize("normalize", [False, True])
def test_a_sphere_is_seen_under_its_solid_angle(dusty, scale, normalize):
    light = at_distance(dusty.light("SphereLight", intensity=5.0, exposure=1.0, radius=1.0, normalize=normalize))
    light.AddScaleOp().Set(Gf.Vec3f(scale))
    radiance = 10.0 / (4 * math.pi * scale**2 if normalize else 1)
    expected = radiance * 2 * math.pi * (1 - math.sqrt(1 - (scale / DISTANCE) ** 2))
    assert arrives(dusty)[0] == pytest.approx([expected] * 3, rel=0.01)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_rectangle_is_seen_under_its_solid_angle(dusty, normalize):
    light = at_distance(dusty.light("RectLight", intensity=5.0, width=1.0, height=0.5, normalize=normalize))
    light.AddScaleOp().Set(Gf.Vec3f(2, 3, 1))
    w, h, d = 2.0, 1.5, DISTANCE
    solid = 4 * math.atan(w * h / (2 * d * math.sqrt(4 * d * d + w * w + h * h)))
    assert arrives(dusty)[0] == pytest.approx([5.0 * solid / (w * h if normalize else 1)] * 3, rel=0.01)
    light.GetPrim().GetAttribute("xformOp:rotateXYZ").Set(Gf.Vec3f(0, 180, 0))
    assert arrives(dusty)[0] == pytest.approx([0.0] * 3, abs=1e-6)  # it shines to one side


@pytest.mark.parametrize("normalize", [False, True])
def test_a_disk_is_seen_under_its_solid_angle(dusty, normalize):
    at_distance(dusty.light("DiskLight", intensity=5.0, radius=0.8, normalize=normalize))
    solid = 2 * math.pi * (1 - DISTANCE / math.hypot(DISTANCE, 0.8))
    area = math.pi * 0.64 if normalize else 1
    assert arrives(dusty)[0] == pytest.approx([5.0 * solid / area] * 3, rel=0.01)


def test_a_point_gives_what_its_sphere_gives_from_afar(dusty):
    light = at_distance(dusty.light("SphereLight", intensity=5.0, radius=0.1))
    light.GetTreatAsPointAttr().Set(True)
    assert arrives(dusty)[0] == pytest.approx([5.0 * math.pi * 0.01 / DISTANCE**2] * 3, rel=0.005)
    light.GetNormalizeAttr().Set(True)
    assert arrives(dusty)[0] == pytest.approx([5.0 / 4 / DISTANCE**2] * 3, rel=0.005)


def test_a_cone_makes_a_spot(dusty):
    light = at_distance(dusty.light("SphereLight", intensity=5.0, radius=0.1))
    light.GetTreatAsPointAttr().Set(True)
    dusty.stage.GetPrimAtPath("/dust").GetAttribute("scrim:density:scale").Set(0.05)
    UsdVol.Volume.Get(dusty.stage, "/dust").AddScaleOp().Set(Gf.Vec3f(0.1))
    UsdGeom.Camera.Get(dusty.stage, "/cam").GetHorizontalApertureAttr().Set(0.6)
    UsdGeom.Camera.Get(dusty.stage, "/cam").GetVerticalApertureAttr().Set(0.6)
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.GetShapingConeAngleAttr().Set(20.0)
    full = 5.0 * math.pi * 0.01 / DISTANCE**2
    turned = light.GetPrim().GetAttribute("xformOp:rotateXYZ")
    cosines = [math.cos(math.radians(a)) for a in (20, 15, 10)]
    t = (cosines[1] - cosines[0]) / (cosines[2] - cosines[0])  # UsdLux has 0.5 here: halfway between the angles
    soft = t * t * (3 - 2 * t)
    for turn, softness, part in ((0, 0, 1), (15, 0, 1), (25, 0, 0), (15, 0.5, soft), (8, 0.5, 1)):
        turned.Set(Gf.Vec3f(turn, 0, 0))
        shaping.GetShapingConeSoftnessAttr().Set(float(softness))
        found, shot = arrives(dusty)
        assert found == pytest.approx([full * part] * 3, rel=0.01, abs=1e-9), turn
        light_of = shot.scene(1)["light"][0]
        assert light_of["cone"] == 40.0 and light_of["blend"] == softness
        assert any("fades by the cosine" in w for w in shot.warnings) == (softness > 0)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_photometric_file_multiplies_by_its_candelas(dusty, normalize):
    """That of 1200 candelas times the cosine, whose mean over the half space is 600."""
    light = at_distance(dusty.light("SphereLight", intensity=0.01, radius=0.1), (35, 0, 0))
    light.GetTreatAsPointAttr().Set(True)
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.GetShapingIesFileAttr().Set(Sdf.AssetPath(str(LUMINAIRES / "downlight.ies")))
    shaping.GetShapingIesNormalizeAttr().Set(normalize)
    candelas = (2 if normalize else 1200) * math.cos(math.radians(35))
    found, shot = arrives(dusty)
    assert found == pytest.approx([0.01 * math.pi * 0.01 * candelas / DISTANCE**2] * 3, rel=0.01)
    assert not any("IES" in w for w in shot.warnings)


def test_a_dome_shines_from_everywhere(dusty):
    dusty.light("DomeLight", intensity=0.5, color=Gf.Vec3f(1, 0.5, 0.25))
    found, shot = arrives(dusty)
    working = shot.opened(1).render().image  # the colour went from Rec.709 to the working space
    matrix = numpy.array(
        [[0.6130974, 0.3395231, 0.0473795], [0.0701937, 0.9163540, 0.0134524], [0.0206156, 0.1095698, 0.8698146]]
    )
    assert found == pytest.approx(4 * math.pi * 0.5 * matrix @ [1, 0.5, 0.25], rel=0.01)
    assert working.shape == (16, 16, 4)


@pytest.mark.parametrize("kind, up, turn", [("DomeLight", "Y", 0), ("DomeLight_1", "Z", 0), ("DomeLight", "Y", 90)])
def test_a_domes_picture_stands_as_openexr_says(tmp_path, kind, up, turn):
    """A sky of which only the quarter around one direction shines."""
    OpenEXR = pytest.importorskip("OpenEXR")
    sky = numpy.zeros((16, 32, 3), numpy.float32)
    sky[6:10, 6:10] = 10.0  # a quarter from the left: longitude pi/2, +x
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": sky}).write(
        str(tmp_path / "sky.exr")
    )
    stage = Stage(tmp_path, up)
    stage.camera(place=(0, 0, 20), ortho=0.6)
    stage.dust()
    dome = stage.light(kind, intensity=1.0)
    dome.GetTextureFileAttr().Set(Sdf.AssetPath("sky.exr"))
    dome.AddRotateYOp().Set(float(turn))
    table = stage.open().scene(1)["light"][0]
    # The direction of the bright quarter, by the scene's own words for a dome, and by OpenEXR's.
    expected = Gf.Rotation(Gf.Vec3d.YAxis(), turn).TransformDir(Gf.Vec3d(1, 0, 0))
    assert scene_direction(table, 0.25) == pytest.approx(list(expected), abs=1e-6)
    # Smoke that scatters forwards is bright before that quarter, and dark where it is behind the camera.
    assert seen_towards(stage, expected) > 3 * seen_towards(stage, -expected)


def test_a_dome_with_a_sky_of_scrim_has_its_sun_over_the_middle(tmp_path):
    """The attributes of a clear sky, one of them by frame; other renderers have the picture."""
    stage = Stage(tmp_path)
    stage.camera(place=(0, 0, 20), ortho=0.6)
    stage.dust()
    dome = stage.light("DomeLight", intensity=1.0)
    dome.GetTextureFileAttr().Set(Sdf.AssetPath("sky.exr"))
    dome.AddRotateYOp().Set(90.0)
    elevation = dome.GetPrim().CreateAttribute("scrim:sky:sun_elevation", Sdf.ValueTypeNames.Float)
    elevation.Set(20.0, 1)
    elevation.Set(40.0, 2)
    dome.GetPrim().CreateAttribute("scrim:visible", Sdf.ValueTypeNames.Bool).Set(True)
    shot = stage.open()
    table = shot.scene(1)["light"][0]
    assert table["sky"] == {"sun_elevation": 20.0} and "texture" not in table and table["visible"] is True
    assert shot.scene(2)["light"][0]["sky"] == {"sun_elevation": 40.0}
    assert scene_direction(table, 0.5) == pytest.approx([1, 0, 0], abs=1e-6)
    assert seen_towards(stage, Gf.Vec3d(1, 0.4, 0).GetNormalized()) > 2 * seen_towards(stage, Gf.Vec3d(-1, 0.4, 0).GetNormalized())


def scene_direction(table, u):
    """examples/SCENES.md: the middle of the picture is +z, a quarter to the right of it -x, for `up` = +y."""
    turn = Gf.Rotation(Gf.Vec3d.YAxis(), table["rotation"]).TransformDir(
        Gf.Vec3d(math.sin(2 * math.pi * (0.5 - u)), 0, math.cos(2 * math.pi * (0.5 - u)))
    )
    return list(Gf.Rotation(Gf.Vec3d.YAxis(), Gf.Vec3d(*table["up"])).TransformDir(turn))


def seen_towards(stage, towards):
    """What a camera shows that looks there through the dust."""
    override = {
        "volume.dust.medium.phase": {"type": "hg", "g": 0.9},
        "camera.matrix": looking([float(c) for c in towards]),
    }
    return stage.open(override).render().image[:, :, :3].sum()


def looking(towards):
    z = -numpy.array(towards)
    x = numpy.cross([0, 1, 0.1], z)
    x /= numpy.linalg.norm(x)
    matrix = numpy.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, numpy.cross(z, x), z, 20 * z
    return matrix


def test_temperature_is_usds_own_colour(dusty):
    dusty.light("DistantLight", intensity=1.0, angle=0.0, enableColorTemperature=True, colorTemperature=3000.0)
    table = arrives(dusty)[1].scene(1)["light"][0]
    assert table["color"]["rgb"] == pytest.approx(list(UsdLux.BlackbodyTemperatureAsRgb(3000.0)))
    assert table["color"]["colorspace"] == "lin_rec709_scene"


def test_colours_are_those_of_their_space(dusty):
    light = dusty.light("DistantLight", intensity=1.0, angle=0.0, color=Gf.Vec3f(0.2, 0.6, 0.9))
    attribute = light.GetColorAttr()
    attribute.SetColorSpace("lin_ap1_scene")
    assert arrives(dusty)[0] == pytest.approx([0.2, 0.6, 0.9], rel=0.003)  # ACEScg is the working space
    attribute.ClearColorSpace()
    Usd.ColorSpaceAPI.Apply(light.GetPrim()).CreateColorSpaceNameAttr("lin_ap1_scene")
    assert arrives(dusty)[0] == pytest.approx([0.2, 0.6, 0.9], rel=0.003)
    attribute.SetColorSpace("lin_rec2020_scene")  # by way of ACES2065-1
    to_ap1 = Gf.ColorSpace("lin_ap1_scene").Convert(Gf.ColorSpace("lin_rec2020_scene"), Gf.Vec3f(0.2, 0.6, 0.9))
    assert arrives(dusty)[0] == pytest.approx(list(to_ap1.GetRGB()), rel=0.005)


def test_a_pixel_of_the_camera_is_exposed(dusty):
    dusty.light("DistantLight", intensity=1.0, angle=0.0)
    camera = dusty.stage.GetPrimAtPath("/cam")
    camera.GetAttribute("exposure").Set(2.0)
    assert arrives(dusty)[0] == pytest.approx([4.0] * 3, rel=0.003)


def test_links_are_lights_of_volumes(dusty):
    far = dusty.dust("/other", place=(0, 0, -1))
    for name in ("both", "one", "none"):
        dusty.light("DistantLight", f"/{name}", intensity=1.0, angle=0.0)
    link = UsdLux.LightAPI(dusty.stage.GetPrimAtPath("/one")).GetLightLinkCollectionAPI()
    link.ExcludePath(far.GetPath())
    link = UsdLux.LightAPI(dusty.stage.GetPrimAtPath("/none")).GetShadowLinkCollectionAPI()
    link.CreateIncludeRootAttr(False)
    shot = dusty.open()
    scene = shot.scene(1)
    dust, other = scene["volume"]
    assert "lights" not in dust and other["lights"] == ["both", "none"]
    assert [light.get("shadows", True) for light in scene["light"]] == [True, True, False]
    assert "shadows" not in dust and "shadows" not in other
    link.IncludePath("/dust")
    shot = dusty.open()
    dust, other = shot.scene(1)["volume"]
    assert "shadows" not in dust and other["shadows"] == ["both", "one"]
    assert not shot.warnings
    assert shot.render().image[:, :, 3].max() > 0
    dusty.stage.GetPrimAtPath("/dust").CreateAttribute("scrim:medium:scattering", Sdf.ValueTypeNames.Token).Set("full")
    shot = dusty.open()
    assert "shadows" not in shot.scene(1)["volume"][1]
    assert any(w.startswith("/other: a shadowLink leaves it out") for w in shot.warnings)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_cylinder_lies_along_its_x_axis_and_is_seen_under_its_solid_angle(dusty, normalize):
    """A thin one, across: 2 r l / (d (d^2 + l^2 / 4)^0.5). Turned end on, it shows nothing."""
    light = at_distance(dusty.light("CylinderLight", intensity=5.0, length=1.0, radius=0.01, normalize=normalize))
    light.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))
    r, l, d = 0.01, 2.0, DISTANCE
    solid = 2 * r * l / (d * math.sqrt(d * d + 0.25 * l * l))
    area = 2 * math.pi * r * l if normalize else 1
    assert arrives(dusty)[0] == pytest.approx([5.0 * solid / area] * 3, rel=0.02)
    light.GetPrim().GetAttribute("xformOp:rotateXYZ").Set(Gf.Vec3f(0, 90, 0))
    assert arrives(dusty)[0][0] < 0.1 * 5.0 * solid / area


@pytest.mark.parametrize(
    "kind, text",
    [
        ("GeometryLight", "/odd: lights of type GeometryLight are not rendered"),
        ("PortalLight", "/odd: lights of type PortalLight are not rendered"),
    ],
)
def test_lights_that_are_not_there_are_named(dusty, kind, text):
    dusty.light(kind, "/odd")
    shot = dusty.open()
    assert "light" not in shot.scene(1) and text in shot.warnings


@pytest.mark.parametrize("meshes", ["holdout", "none"])
@pytest.mark.parametrize("normalize", [False, True])
def test_a_mesh_that_shines_does_so_outwards(dusty, normalize, meshes):
    """Of a cube off the dust, one face is seen from there, and what it hides of the dust is behind it."""
    solid = UsdGeom.Cube.Define(dusty.stage, "/lamp")
    solid.CreateSizeAttr(1.0)
    solid.AddTranslateOp().Set(Gf.Vec3d(DISTANCE + 0.5, 0, 0))
    UsdLux.MeshLightAPI.Apply(solid.GetPrim())
    light = UsdLux.LightAPI(solid.GetPrim())
    light.CreateIntensityAttr(5.0)
    light.CreateNormalizeAttr(normalize)
    found, shot = arrives(dusty, meshes=meshes)
    face = 4 * math.asin(0.25 / (DISTANCE**2 + 0.25))
    assert found == pytest.approx([5.0 * face / (6 if normalize else 1)] * 3, rel=0.02)
    assert not any("/lamp" in warning for warning in shot.warnings)


def test_an_open_mesh_shines_to_the_side_of_its_orientation(dusty):
    sheet = UsdGeom.Mesh.Define(dusty.stage, "/lamp")
    sheet.CreatePointsAttr([(-1, -1, DISTANCE), (-1, 1, DISTANCE), (1, 1, DISTANCE), (1, -1, DISTANCE)])
    sheet.CreateFaceVertexCountsAttr([4])
    sheet.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    sheet.CreateSubdivisionSchemeAttr("none")
    UsdLux.MeshLightAPI.Apply(sheet.GetPrim())
    UsdLux.LightAPI(sheet.GetPrim()).CreateIntensityAttr(5.0)
    expected = 5.0 * 4 * math.asin(1 / (DISTANCE**2 + 1))
    assert arrives(dusty, meshes="none")[0] == pytest.approx([expected] * 3, rel=0.01)
    sheet.CreateOrientationAttr("leftHanded")
    assert arrives(dusty, meshes="none")[0] == pytest.approx([0.0] * 3, abs=1e-6)


def test_a_volume_that_shines_is_named(dusty):
    UsdLux.VolumeLightAPI.Apply(dusty.stage.GetPrimAtPath("/dust"))
    shot = dusty.open()
    assert "light" not in shot.scene(1)
    assert "/dust: the light that it gives as a volume is not rendered" in shot.warnings


def test_what_a_dome_has_that_is_not_rendered_is_named(dusty):
    UsdGeom.Camera.Get(dusty.stage, "/cam").GetShutterCloseAttr().Set(0.5)
    dome = dusty.light("DomeLight")
    turn = dome.AddRotateYOp()
    turn.Set(0.0, 1)
    turn.Set(90.0, 2)
    dome.AddScaleOp().Set(Gf.Vec3f(1, 1, -1))
    dome.GetTextureFormatAttr().Set("angular")
    UsdLux.ShapingAPI.Apply(dome.GetPrim())
    dome.GetPortalsRel().AddTarget("/dust")
    shot = dusty.open()
    shot.scene(1)
    for text in (
        "/key: it turns while the shutter is open, and is rendered as it stands at the frame",
        "/key: it is mirrored, but rendered without mirroring",
        "/key: its picture of format 'angular' is read as latlong",
        "/key: portals are not needed, and not read",
        "/key: its cone is not rendered",
    ):
        assert text in shot.warnings, shot.warnings


def test_lights_move_while_the_shutter_is_open(dusty):
    """A point that comes nearer: the mean of its inverse squares."""
    UsdGeom.Camera.Get(dusty.stage, "/cam").GetShutterCloseAttr().Set(1.0)
    light = dusty.light("SphereLight", intensity=4.0, normalize=True)
    light.GetTreatAsPointAttr().Set(True)
    place = light.AddTranslateOp()
    place.Set(Gf.Vec3d(0, 0, 4), 1)
    place.Set(Gf.Vec3d(0, 0, 2), 2)
    shot = dusty.open({"render.shutter_samples": 16})
    assert fluence(shot.render()) == pytest.approx([1 / (4 * 2)] * 3, rel=0.02)


def test_what_a_light_has_that_is_not_rendered_is_named(dusty):
    light = at_distance(dusty.light("SphereLight", radius=0.5, diffuse=0.5))
    light.AddScaleOp().Set(Gf.Vec3f(1, 2, 1))
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.GetShapingFocusAttr().Set(3.0)
    shaping.GetShapingIesFileAttr().Set(Sdf.AssetPath("lamp.ies"))
    shadow = UsdLux.ShadowAPI.Apply(light.GetPrim())
    shadow.GetShadowColorAttr().Set(Gf.Vec3f(1, 0, 0))
    shadow.GetShadowEnableAttr().Set(False)
    flat = at_distance(dusty.light("RectLight", "/flat"))
    UsdLux.ShapingAPI.Apply(flat.GetPrim()).GetShapingConeAngleAttr().Set(30.0)
    shot = dusty.open()
    sphere = shot.scene(1)["light"][0]
    assert sphere["shadows"] is False and sphere["type"] == "spot" and sphere["cone"] == 180.0
    for text in (
        "/key: its focus is not rendered",
        "/key: its scale differs along axes: an ellipsoid is rendered as a sphere of the same volume",
        "/key: a sphere with a cone is rendered as a point: its radius of 0.629961 softens no shadow",
        "/key: its diffuse multiplier is not for volumes, and not read",
        "/key: shadow:color is not rendered",
        "/flat: its cone of 30 degrees to each side is not rendered; it shines to all of one side",
    ):
        assert text in shot.warnings, shot.warnings
    assert any("/key: its IES profile is not rendered: " in w and "lamp.ies" in w for w in shot.warnings)
