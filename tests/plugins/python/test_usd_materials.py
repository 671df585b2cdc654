# SPDX-License-Identifier: Apache-2.0
"""Volume materials of other renderers are rendered as what they say, and what is not mapped is named."""

import math
import re

import OpenEXR
import pytest

pytest.importorskip("pxr", reason="usd-core is not installed")

from conftest import ROOT  # noqa: E402
from pxr import Gf, Sdf, UsdGeom, UsdShade, UsdVol  # noqa: E402
from usd_stages import EDGE, Stage, behind, front, write_fog  # noqa: E402

from scrim.usd import _materials  # noqa: E402

FLOAT, COLOR, VECTOR, TEXT = (getattr(Sdf.ValueTypeNames, n) for n in ("Float", "Color3f", "Vector3f", "String"))


@pytest.fixture
def foggy(tmp_path):
    """The slab, lit from the front, of which nothing is said to Scrim alone."""
    write_fog(tmp_path)
    stage = Stage(tmp_path)
    stage.camera()
    stage.volume(said=False)
    stage.light("DistantLight", intensity=1.0, angle=0.0)
    return stage


def kind_of_value(value):
    if isinstance(value, str):
        return TEXT
    if isinstance(value, int):
        return Sdf.ValueTypeNames.Int
    if isinstance(value, list):
        return (
            Sdf.ValueTypeNames.FloatArray
            if not value or isinstance(value[0], float)
            else Sdf.ValueTypeNames.Color3fArray
        )
    return FLOAT if isinstance(value, float) else COLOR


def shader(stage, path, kind, **inputs):
    made = UsdShade.Shader.Define(stage.stage, path)
    made.CreateIdAttr(kind)
    for name, value in inputs.items():
        if isinstance(value, UsdShade.Shader):
            output = value.CreateOutput("out", Sdf.ValueTypeNames.Token)
            made.CreateInput(name, Sdf.ValueTypeNames.Token).ConnectToSource(output)
        else:
            value = Gf.Vec3f(*value) if isinstance(value, tuple) else value
            made.CreateInput(name, kind_of_value(value)).Set(value)
    return made


def bind(stage, made, context="", volume="/fog", terminal="volume"):
    """Makes a shader the volume of a material of the fog."""
    material = UsdShade.Material.Define(stage.stage, "/mat")
    outputs = {"volume": material.CreateVolumeOutput, "surface": material.CreateSurfaceOutput}
    outputs[terminal](context).ConnectToSource(made.CreateOutput("out", Sdf.ValueTypeNames.Token))
    UsdShade.MaterialBindingAPI.Apply(stage.stage.GetPrimAtPath(volume)).Bind(material)
    return material


FULL = 'scattering = "full" is taken'


def volume_of(stage):
    """The volume of the scene, and all warnings but that its light scatters more than once."""
    shot = stage.open()
    return shot.scene(1)["volume"][0], [warning for warning in shot.warnings if FULL not in warning]


def middle(stage):
    """What the picture shows in the middle of the slab, where light scatters once: red, green, blue, alpha."""
    stage.say(UsdVol.Volume.Get(stage.stage, "/fog"), "scattering", Sdf.ValueTypeNames.Token, "single")
    image = stage.open().render().image.astype(float)
    return image[6:10, 6:10].mean(axis=(0, 1))


def test_the_plain_floats_of_arnold_are_the_slab_of_the_closed_form(foggy):
    bind(
        foggy, shader(foggy, "/mat/s", "arnold:standard_volume", density=0.05, scatter_color=(0.9, 0.9, 0.9)), "arnold"
    )
    expected = front(1.0)  # extinction 0.05 and albedo 0.9, as usd_stages has them
    seen = middle(foggy)
    assert seen[:3] == pytest.approx([expected] * 3, rel=0.003)
    assert seen[3] == pytest.approx(1 - math.exp(-0.05 * EDGE), rel=0.002)


def test_arnold_without_values_is_its_documented_defaults(foggy):
    bind(foggy, shader(foggy, "/mat/s", "standard_volume"), "arnold", terminal="surface")
    volume, warnings = volume_of(foggy)
    assert volume["density"] == {"grid": "density", "scale": pytest.approx(1.0)}
    assert volume["medium"] == {"albedo": pytest.approx([0.5] * 3), "phase": {"type": "isotropic"}}
    assert warnings == []  # no field is called temperature, and nobody said that one should be


def test_a_tint_of_arnold_is_extinction_by_channel(foggy):
    clear = tuple(math.exp(-t) for t in (1.0, 2.0, 4.0))
    bind(foggy, shader(foggy, "/mat/s", "arnold:standard_volume", density=0.05, scatter=0.8,
                       scatter_color=(1.0, 1.0, 1.0), transparent=clear, transparent_depth=2.0,
                       scatter_anisotropy=0.4), "arnold")  # fmt: skip
    volume, warnings = volume_of(foggy)
    assert warnings == []
    assert volume["density"]["scale"] == pytest.approx(0.1, rel=1e-5)
    tint = volume["medium"]["extinction_tint"]
    assert tint["rgb"] == pytest.approx([0.25, 0.5, 1.0], rel=1e-5) and tint["colorspace"] == "lin_rec709_scene"
    assert volume["medium"]["albedo"] == pytest.approx([0.8] * 3)
    assert volume["medium"]["phase"] == {"type": "hg", "g": pytest.approx(0.4)}


def two_fields(foggy, other):
    """The slab with a second field of this name, which is the same grid."""
    volume = foggy.volume("/fog", ["slab.vdb", "slab.vdb"], ["density", other], said=False)
    foggy.stage.GetPrimAtPath(f"/fog/{other}").GetAttribute("fieldName").Set("density")
    return volume


def test_arnold_glows_by_a_channel_its_density_or_a_temperature(foggy):
    two_fields(foggy, "heat")
    made = shader(foggy, "/mat/s", "arnold:standard_volume", density=0.05, scatter=0.0, emission_mode="channel",
                  emission=0.5, emission_color=(1.0, 0.5, 0.0))  # fmt: skip
    bind(foggy, made, "arnold")
    depth = (1 - math.exp(-0.05 * EDGE)) / 0.05  # how far into the slab one sees
    shot = foggy.open({"output.colorspace": "lin_rec709_scene"})
    path = shot.render().write(str(foggy.folder / "glow.exr"))
    with OpenEXR.File(str(path), separate_channels=True) as file:
        shown = [file.channels()[name].pixels[6:10, 6:10].mean() for name in "RGB"]
    assert shown == pytest.approx([0.5 * depth, 0.25 * depth, 0.0], rel=0.01, abs=0.01)
    volume, _ = volume_of(foggy)
    assert volume["medium"]["emission"]["grid"] == "density" and volume["medium"]["emission"]["scale"] == 0.5
    made.GetInput("emission_mode").Set("density")
    assert volume_of(foggy)[0]["medium"]["emission"]["grid"] == "density"
    made.GetInput("emission_mode").Set("blackbody")
    made.CreateInput("temperature_channel", TEXT).Set("heat")
    made.CreateInput("blackbody_kelvin", FLOAT).Set(2000.0)
    made.CreateInput("temperature", FLOAT).Set(1.5)
    assert volume_of(foggy)[0]["medium"]["blackbody"] == {"grid": "density", "scale": 3000.0, "intensity": 0.5}
    made.GetInput("emission_mode").Set("none")
    assert not {"emission", "blackbody"} & set(volume_of(foggy)[0]["medium"])


def test_grids_that_are_no_fields_and_inputs_without_a_counterpart_are_named(foggy):
    noise = shader(foggy, "/mat/noise", "arnold:noise")
    bind(foggy, shader(foggy, "/mat/s", "arnold:standard_volume", emission_channel="flames", emission_mode="channel",
                       scatter_color_channel="Cd", displacement=(0.0, 1.0, 0.0), scatter=noise), "arnold")  # fmt: skip
    volume, warnings = volume_of(foggy)
    assert volume["medium"] == {"albedo": [0.5] * 3, "phase": {"type": "isotropic"}}
    assert sorted(warnings) == [
        "/fog: its material takes albedo from 'Cd', which is no field of it, and is left out",
        "/fog: its material takes emission from 'flames', which is no field of it, and is left out",
        "/mat/s: standard_volume: not mapped: displacement",
        "/mat/s: standard_volume: scatter comes from /mat/noise (noise), which is not mapped",
    ]


def materialx(foggy, **rates):
    vdf = shader(foggy, "/mat/vdf", "ND_anisotropic_vdf", **rates)
    edf = shader(foggy, "/mat/edf", "ND_uniform_edf", color=(0.25, 0.25, 0.25))
    bind(foggy, shader(foggy, "/mat/v", "ND_volume", vdf=vdf, edf=edf), "mtlx")
    return vdf


def test_rates_of_materialx_are_the_slab_of_the_closed_form(foggy):
    materialx(foggy, absorption=(0.005, 0.005, 0.005), scattering=(0.045, 0.045, 0.045), anisotropy=0.0)
    seen = middle(foggy)
    glow = 0.25 * (1 - math.exp(-0.05 * EDGE)) / 0.05
    assert seen[:3] == pytest.approx([front(1.0) + glow] * 3, rel=0.004)
    foggy.stage.GetPrimAtPath("/mat/edf").GetAttribute("inputs:color").Set(Gf.Vec3f(0))
    UsdGeom.Xformable.Get(foggy.stage, "/key").AddRotateYOp().Set(180.0)
    assert middle(foggy)[:3] == pytest.approx([behind(1.0)] * 3, rel=0.004)


def test_rates_of_materialx_may_come_from_a_field_times_a_constant(foggy):
    read = shader(foggy, "/mat/read", "ND_geompropvalue_vector3", geomprop="density")
    rate = shader(foggy, "/mat/rate", "ND_multiply_vector3", in1=read, in2=(0.1, 0.2, 0.4))
    vdf = materialx(foggy, anisotropy=0.3)
    vdf.CreateInput("scattering", VECTOR).ConnectToSource(rate.CreateOutput("out", VECTOR))
    volume, warnings = volume_of(foggy)
    assert warnings == []
    assert volume["density"] == {"grid": "density", "scale": pytest.approx(0.4)}
    assert volume["medium"]["extinction_tint"]["rgb"] == pytest.approx([0.25, 0.5, 1.0])
    assert volume["medium"]["albedo"] == [1.0] * 3 and volume["medium"]["phase"]["g"] == pytest.approx(0.3)


def test_absorption_alone_scatters_nothing_and_combined_nodes_are_named(foggy):
    vdf = shader(foggy, "/mat/vdf", "ND_absorption_vdf", absorption=(0.05, 0.05, 0.05))
    made = shader(foggy, "/mat/v", "ND_volume", vdf=vdf)
    bind(foggy, made, "mtlx")
    seen = middle(foggy)
    assert seen[:3].max() == 0 and seen[3] == pytest.approx(1 - math.exp(-0.05 * EDGE), rel=0.002)
    mixed = shader(foggy, "/mat/mix", "ND_mix_vdf", fg=vdf, mix=0.5)
    made.GetInput("vdf").ConnectToSource(mixed.CreateOutput("out", Sdf.ValueTypeNames.Token))
    assert "/mat/mix: ND_mix_vdf is not mapped" in volume_of(foggy)[1]


def test_karmas_volume_has_two_lobes(foggy):
    bind(foggy, shader(foggy, "/mat/s", "kma_volume", absorption=(0.01, 0.01, 0.01), scattering=(0.04, 0.04, 0.04),
                       anisotropy=0.6, anisotropy2=-0.2, anisotropymix=0.25), "kma")  # fmt: skip
    volume, warnings = volume_of(foggy)
    assert warnings == [] and volume["medium"]["albedo"] == pytest.approx([0.8] * 3)
    assert volume["medium"]["phase"] == {
        "type": "two-lobe", "g1": pytest.approx(0.6), "g2": pytest.approx(-0.2), "blend": pytest.approx(0.25)
    }  # fmt: skip


def pyro(foggy, **inputs):
    two_fields(foggy, "flame")
    made = shader(foggy, "/mat/s", "kma_pyroshader", densityscale=0.05, smokecolor=(0.9, 0.9, 0.9), **inputs)
    bind(foggy, made, "kma")
    return made


def test_smoke_of_karmas_pyro_is_as_thick_as_densityscale_says(foggy):
    pyro(foggy)
    seen = middle(foggy)
    assert seen[3] == pytest.approx(1 - math.exp(-0.05 * EDGE), rel=0.002)
    assert seen[:3] == pytest.approx([front(1.0)] * 3, rel=0.003)


def test_fire_of_karmas_pyro_is_intensity_times_the_ramps_colour(foggy):
    made = pyro(foggy, enablefire=1, fireintscale=2.0, fireint_volumename="flame", firecolor_volumename="flame",
                firecolormode="0", firecolorramp_keys=[0.0, 1.0], firecolorramp_values=[Gf.Vec3f(0), Gf.Vec3f(1)],
                smokegain=3.0)  # fmt: skip
    volume, warnings = volume_of(foggy)
    glow = volume["medium"]["emission"]
    assert glow["grid"] == "density" and glow["scale"] == 2.0
    at = {place: colour[0] for place, colour in glow["ramp"]}
    assert at[0.0] == 0 and at[0.5] == pytest.approx(0.25) and at[1.0] == pytest.approx(1.0)
    assert warnings == ["/mat/s: kma_pyroshader: not mapped: smokegain"]
    made.GetInput("firecolor_volumename").Set("density")
    volume, warnings = volume_of(foggy)
    assert "ramp" not in volume["medium"]["emission"]
    assert "/mat/s: kma_pyroshader: the colour of its fire is by the grid 'density', and is taken as white" in warnings
    made.GetInput("enablefire").Set(0)
    assert "emission" not in volume_of(foggy)[0]["medium"]


def test_what_is_said_to_scrim_replaces_what_the_material_says(foggy):
    bind(foggy, shader(foggy, "/mat/s", "arnold:standard_volume", density=3.0, scatter_anisotropy=0.4), "arnold")
    fog = UsdVol.Volume.Get(foggy.stage, "/fog")
    foggy.say(fog, "density:scale", FLOAT, 0.05)
    foggy.say(fog, "g", FLOAT, -0.2)
    volume, warnings = volume_of(foggy)
    assert warnings == [] and volume["density"]["scale"] == pytest.approx(0.05)
    assert volume["medium"]["phase"] == {"type": "hg", "g": pytest.approx(-0.2)}
    assert volume["medium"]["albedo"] == pytest.approx([0.5] * 3)


def test_what_a_shot_cannot_ignore_scatters_fully_and_is_told(foggy):
    made = shader(foggy, "/mat/s", "arnold:standard_volume", density=0.5, scatter_color=(0.2, 0.95, 0.2))
    bind(foggy, made, "arnold")
    shot = foggy.open()
    assert shot.scene(1)["volume"][0]["medium"]["scattering"] == "full"
    assert shot.warnings == [
        '/fog: its material scatters 95% of what it takes from light: scattering = "full" is taken, since light that '
        "scatters once would leave dense smoke more than half a stop too dark; "
        'scrim:scattering = "single" renders faster'
    ]
    made.GetInput("scatter_color").Set(Gf.Vec3f(0.9))
    full = shot_of_middle(foggy)
    fog = UsdVol.Volume.Get(foggy.stage, "/fog")
    once = foggy.say(fog, "scattering", Sdf.ValueTypeNames.Token, "single")
    assert foggy.open().scene(1)["volume"][0]["medium"]["scattering"] == "single"
    assert full > 1.3 * shot_of_middle(foggy)
    once.Clear()
    foggy.say(fog, "octaves:count", Sdf.ValueTypeNames.Int, 4)
    assert "scattering" not in foggy.open().scene(1)["volume"][0]["medium"]
    foggy.stage.GetPrimAtPath("/fog").RemoveProperty("scrim:octaves:count")
    # What is said to Scrim of the albedo counts, and so does a choice of shadows, which full scattering refuses.
    foggy.say(fog, "albedo", COLOR, Gf.Vec3f(0.3))
    assert "scattering" not in foggy.open().scene(1)["volume"][0]["medium"]
    foggy.stage.GetPrimAtPath("/fog").RemoveProperty("scrim:albedo")
    foggy.say(fog, "shadows", Sdf.ValueTypeNames.Bool, False)
    assert "scattering" not in foggy.open().scene(1)["volume"][0]["medium"]


def shot_of_middle(foggy):
    return foggy.open({"render.quality": "draft"}).render().image[6:10, 6:10, 0].mean()


@pytest.mark.parametrize(("colour", "scattering"), [(0.5, None), (0.59, None), (0.6, "full")])
def test_the_rule_is_an_albedo_of_six_tenths(foggy, colour, scattering):
    bind(foggy, shader(foggy, "/mat/s", "standard_volume", scatter_color=(colour,) * 3), "arnold")
    assert foggy.open().scene(1)["volume"][0]["medium"].get("scattering") == scattering
    two_fields(foggy, "Cd")
    bind(foggy, shader(foggy, "/mat/s", "standard_volume", scatter=colour, scatter_color=(1.0, 1.0, 1.0),
                       scatter_color_channel="Cd"), "arnold")  # fmt: skip
    assert foggy.open().scene(1)["volume"][0]["medium"].get("scattering") == scattering


def test_other_shaders_are_named_and_the_default_is_taken(foggy):
    material = bind(foggy, shader(foggy, "/mat/s", "PxrVolume"))
    volume, warnings = volume_of(foggy)
    assert volume["medium"] == {"albedo": [0.18] * 3}
    assert warnings[0].startswith(
        "/fog: material /mat: shader 'PxrVolume' is not mapped; expected one of standard_volume"
    )
    material.GetPrim().RemoveProperty("outputs:volume")
    assert volume_of(foggy)[1][0] == "/fog: material /mat has no volume shader, and is not read"


def test_the_page_lists_every_shader_that_is_mapped():
    page = (ROOT / "examples" / "USD.md").read_text()
    named = set(re.findall(r"`(\w+)`", page[page.index("## Materials of other renderers") :]))
    assert set(_materials.SHADERS) <= named
