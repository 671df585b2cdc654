# SPDX-License-Identifier: Apache-2.0
"""Each key of the table of a volume, as an attribute `scrim:*` and in a side-car."""

import math
import shutil
import sys

import pytest

pytest.importorskip("pxr", reason="usd-core is not installed")

from pxr import Gf, Sdf, UsdGeom, UsdVol  # noqa: E402
from scrim_kit import toml_text  # noqa: E402
from usd_stages import TAU, Stage, write_fog  # noqa: E402

import scrim  # noqa: E402
from scrim import _scrim  # noqa: E402

TABLES = {topic: table["properties"] for topic, table in _scrim.scene_schema()["$defs"].items()}
T = Sdf.ValueTypeNames

# A value of each key whose JSON schema does not show one: the type in USD, the value there, and that of the scene.
SPECIAL = {
    "name": (T.String, "mist", "mist"),
    "file": (T.String, "slab.vdb", "slab.vdb"),
    "source": (T.String, "noise", "noise"),
    "frame.keys": (T.Float2Array, [(1, 1), (2, 3)], [[1, 1], [2, 3]]),
    "clip": (T.Float3Array, [(-4, -4, -4), (4, 4, 4)], [[-4, -4, -4], [4, 4, 4]]),
    "clip_plane": (T.Float4, Gf.Vec4f(1, 0, 0, 2), [1, 0, 0, 2]),
    "ax": (T.String, "f@density *= 2;", "f@density *= 2;"),
    "ax_file": (T.String, "double.ax", "double.ax"),
    "transform.matrix": (T.Matrix4d, Gf.Matrix4d(1).SetTranslate((1, 2, 3)),
                         [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]),
    "density.ramp": (T.Float2Array, [(0, 0), (1, 2)], [[0, 0], [1, 2]]),
    "medium.emission.ramp": (T.Float4Array, [(0, 0, 0, 0), (1, 1, 0.5, 0)], [[0, [0, 0, 0]], [1, [1, 0.5, 0]]]),
    "classified.gradient": (T.Float2Array, [(5, 0), (20, 1)], [[5, 0], [20, 1]]),
    "classified.window": (T.String, "lung", "lung"),
    "medium.transparency": (T.Color3f, Gf.Vec3f(0.5), [0.5, 0.5, 0.5]),
}  # fmt: skip
# What the scene needs beside a key, by the key or a table that holds it.
BESIDE = {
    "medium.phase.alpha": {"medium": {"phase": {"type": "draine", "g": 0.5}}},
    "medium.phase.size": {"medium": {"phase": {"type": "droplets"}}},
    "medium.phase.g1": {"medium": {"phase": {"type": "two-lobe", "g2": 0.5}}},
    "medium.phase.g2": {"medium": {"phase": {"type": "two-lobe", "g1": 0.5}}},
    "medium.phase.blend": {"medium": {"phase": {"type": "two-lobe", "g1": 0.5, "g2": 0.5}}},
    "medium.emission": {"medium": {"emission": {"grid": "density"}}},
    "medium.emission.range": {
        "medium": {"emission": {"grid": "density", "ramp": [[0, [0, 0, 0]], [1, [1, 0.5, 0]]]}},
    },
    "medium.blackbody": {"medium": {"blackbody": {"grid": "density"}}},
    "medium.transparency_depth": {"medium": {"transparency": [0.5, 0.5, 0.5]}},
    "detail": {"density": {"noise": {"frequency": 3.0}}},
    "density.mask": {"density": {"mask": {"grid": "density"}}},
    "medium.emission.mask": {"medium": {"emission": {"grid": "density", "mask": {"grid": "density"}}}},
    "medium.blackbody.mask": {"medium": {"blackbody": {"grid": "density", "mask": {"grid": "density"}}}},
    "velocity": {"velocity": {"grid": "density"}},
    "frame.between": {"velocity": {"grid": "density"}},
    "classified": {"classified": {"window": "bone"}},
    "classified.window_zero": {"classified": {"window": [0, 1]}},
    "classified.albedo": {"classified": {"window": "bone", "scattering": "full"}},
}
APART = {"classified.transfer", "grids", "parameters"}  # have tests of their own


def paths(topic="volume", prefix=""):
    """The paths of all keys of a table, and of the tables in it."""
    for key, schema in TABLES[topic].items():
        if "$ref" in schema:
            yield from paths(schema["$ref"].rpartition("/")[2], f"{prefix}{key}.")
        elif prefix + key not in APART:
            yield prefix + key, schema


def sample(path, schema):
    """A value of the key, not the default one."""
    if path in SPECIAL:
        return SPECIAL[path]
    kind = schema["anyOf"][0] if "anyOf" in schema else schema
    kind = kind["anyOf"][0] if "anyOf" in kind else kind
    if "enum" in kind:
        word = {"type": "rayleigh", "scattering": "full"}.get(path.rpartition(".")[2], kind["enum"][-1])
        return T.Token, word, word
    types = kind["type"] if isinstance(kind["type"], list) else [kind["type"]]
    if types[0] == "string":
        return T.String, "density", "density"
    if types[0] == "boolean":
        return T.Bool, path != "shadows", path != "shadows"
    if types[0] == "integer":
        return T.Int, 3, 3
    if types[0] == "number":
        number = 0.5 if kind.get("minimum", 0) < 1 else 1.5
        return T.Float, number, number
    if kind["items"]["type"] == "string":
        return T.StringArray, ["key"], ["key"]
    count = kind["minItems"]
    numbers = [0.25, 0.5, 0.75][:count] if count < 4 else [1, 0, 0, 1]
    if count == 2:
        numbers = [0, 0.5]
    return {2: T.Float2, 3: T.Float3}[count], {2: Gf.Vec2f, 3: Gf.Vec3f}[count](numbers), numbers


def found_at(table, path):
    for part in path.split("."):
        table = table[part]
    return table


def beside(path):
    """What the scene needs beside the key: by the longest path that has an entry."""
    parts = path.split(".")
    names = [".".join(parts[:n]) for n in range(len(parts), 0, -1)]
    return next((BESIDE[name] for name in names if name in BESIDE), {})


@pytest.fixture(scope="module")
def slab(tmp_path_factory):
    return write_fog(tmp_path_factory.mktemp("slab"))


@pytest.fixture
def fog(tmp_path, slab):
    """The slab of fog, seen and lit from the front."""
    shutil.copy(slab, tmp_path)
    (tmp_path / "double.ax").write_text("f@density *= 2;")
    made = Stage(tmp_path)
    made.camera()
    made.volume()
    made.light("DistantLight", intensity=1.0, angle=0.0)
    return made


def beside_as_toml(path):
    """What the scene needs beside the key, without the key."""
    tables = beside(path)
    flat = {}

    def walk(table, prefix):
        for key, value in table.items():
            if isinstance(value, dict):
                walk(value, f"{prefix}{key}.")
            elif prefix + key != path:
                flat[prefix + key] = value

    walk(tables, "")
    return "".join(f"{toml_text.assignment(key, value)}\n" for key, value in flat.items())


@pytest.mark.parametrize(("path", "schema"), [pytest.param(*it, id=it[0]) for it in paths()])
@pytest.mark.parametrize("way", ["attribute", "side-car"])
def test_each_key_of_the_table_is_known(fog, way, path, schema):
    kind, value, expected = sample(path, schema)
    prim = fog.stage.GetPrimAtPath("/fog")
    if path.startswith("classified") or path == "medium.albedo":
        prim.RemoveProperty("scrim:albedo")
    side = fog.folder / "side.toml"
    text = '["/fog"]\n' + beside_as_toml(path)
    if way == "attribute":
        prim.CreateAttribute("scrim:" + path.replace(".", ":"), kind).Set(value)
    else:
        text += toml_text.assignment(path, expected) + "\n"
    side.write_text(text)
    shot = fog.open(sidecar=side)
    assert found_at(shot.scene(1)["volume"][0], path) == expected
    shot.opened(1)  # raises where the scene does not take it


def depth(shot, frame=1):
    return -math.log(1 - shot.render(frame).image[8, 8, 3])


def test_keys_of_the_grids_change_the_picture(fog):
    """ax, clip, and a source in place of the fields, which have no transform of their own then."""
    prim = fog.stage.GetPrimAtPath("/fog")
    prim.CreateAttribute("scrim:ax", T.String).Set("f@density *= $gain;")
    prim.CreateAttribute("scrim:parameters:gain", T.Float).Set(2.0)
    assert depth(fog.open()) == pytest.approx(2 * TAU, rel=0.01)
    prim.CreateAttribute("scrim:clip_plane", T.Double4).Set(Gf.Vec4d(0, 0, 1, 0))
    assert depth(fog.open()) == pytest.approx(TAU, rel=0.05)
    prim.RemoveProperty("scrim:ax")
    prim.CreateAttribute("scrim:ax_file", T.Asset).Set(Sdf.AssetPath("double.ax"))
    prim.RemoveProperty("scrim:parameters:gain")
    assert depth(fog.open()) == pytest.approx(TAU, rel=0.05)
    for name in ("ax_file", "clip_plane"):
        prim.RemoveProperty(f"scrim:{name}")
    prim.CreateAttribute("scrim:grids:density:add", T.StringArray).Set(["slab.vdb:density", "slab.vdb:density"])
    shot = fog.open()
    assert depth(shot) == pytest.approx(2 * TAU, rel=0.01) and "file" not in shot.scene(1)["volume"][0]
    UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
    assert fog.open().render().image[:, :, 3].max() == 0
    prim.CreateAttribute("scrim:transform:translate", T.Double3).Set(Gf.Vec3d(0, 0, 0))
    assert depth(fog.open()) == pytest.approx(2 * TAU, rel=0.01)


def test_a_sequence_shows_what_is_between_its_files(fog):
    """Files of density 1 and 3; frame 2 of the stage lies between them."""
    for number, value in ((1, 1), (2, 3)):
        write_fog(fog.folder, f"fog.000{number}.vdb", value=value)
    fog.stage.SetStartTimeCode(1)
    fog.stage.SetEndTimeCode(3)
    prim = fog.stage.GetPrimAtPath("/fog")
    prim.CreateAttribute("scrim:file", T.String).Set("fog.####.vdb")
    prim.CreateAttribute("scrim:frame:speed", T.Float).Set(0.5)
    prim.CreateAttribute("scrim:frame:offset", T.Float).Set(0.5)
    prim.CreateAttribute("scrim:frame:between", T.Token).Set("blend")
    shot = fog.open()
    assert [depth(shot, frame) / TAU for frame in shot.frames] == pytest.approx([1, 2, 3], rel=0.01)


def test_a_volume_without_fields_may_be_a_source(fog):
    fog.stage.RemovePrim("/fog")
    volume = fog.volume("/made", [], [])
    fog.say(volume, "source", T.String, "noise")
    fog.say(volume, "parameters:resolution", T.Int, 16)
    fog.say(volume, "density:scale", T.Float, 5.0)
    volume.AddScaleOp().Set(Gf.Vec3f(8))
    shot = fog.open()
    made = shot.scene(1)["volume"][0]
    assert made["source"] == "noise" and made["parameters"] == {"resolution": 16} and "density" in made
    assert shot.render().image[:, :, 3].max() > 0.3 and not shot.warnings


def test_masks_and_components_name_fields(fog):
    """Fields of several files: the grid of a mask is the channel, as that of a glow is."""
    volume = fog.volume("/two", ["slab.vdb", "double.vdb"], ["density", "heat"])
    fog.say(volume, "density:mask:grid", T.String, "heat")
    fog.say(volume, "velocity:grid", T.StringArray, ["heat", "heat", "heat"])
    shot = fog.open()
    made = shot.scene(1)["volume"][1]
    assert made["density"]["mask"] == {"grid": "heat"} and sorted(made["grids"]) == ["density", "heat"]
    assert made["velocity"]["grid"] == ["heat"] * 3 and not shot.warnings
    UsdVol.OpenVDBAsset.Get(fog.stage, "/two/heat").GetFilePathAttr().Set(Sdf.AssetPath("slab.vdb"))
    UsdVol.OpenVDBAsset.Get(fog.stage, "/two/heat").GetFieldNameAttr().Set("temperature")
    assert fog.open().scene(1)["volume"][1]["density"]["mask"] == {"grid": "temperature"}


def test_a_transfer_function_is_arrays_of_one_length(fog):
    prim = fog.stage.GetPrimAtPath("/fog")
    prim.RemoveProperty("scrim:albedo")
    prim.CreateAttribute("scrim:classified:transfer:value", T.FloatArray).Set([0, 1])
    prim.CreateAttribute("scrim:classified:transfer:color", T.Color3fArray).Set([(1, 1, 1), (0.5, 0.5, 0.5)])
    extinction = prim.CreateAttribute("scrim:classified:transfer:extinction", T.FloatArray)
    extinction.Set([0, 2])
    shot = fog.open()
    shot.opened(1)
    assert shot.scene(1)["volume"][0]["classified"]["transfer"] == [
        {"value": 0, "color": [1, 1, 1], "extinction": 0},
        {"value": 1, "color": [0.5, 0.5, 0.5], "extinction": 2},
    ]
    extinction.Set([0, 2, 3])
    with pytest.raises(scrim.InputError, match=r"shot.usda: /fog: the parts of classified.transfer, color, extinction, "
                                               r"value, are not arrays of one length$"):  # fmt: skip
        fog.open().scene(1)


# What is said of the fog beside density.scale = 0.05, and the message.
WRONG = [
    ("density", T.Float, 1.0, r"density has a value beside its keys, and cannot have both|"
                              r"density is 1.0; expected a table of keys: density.grid, density.scale, density.ramp"),
    ("medium", T.Float, 2.0, r"medium has a value beside its keys, and cannot have both"),
    ("blackbody", T.String, "heat", r"medium.blackbody is 'heat'; expected a table of keys: medium.blackbody.grid, "),
    ("medium:albedo", T.Color3f, Gf.Vec3f(1), r"medium.albedo is said twice"),
    ("ax", T.TimeCode, Sdf.TimeCode(1), r"a value of type timecode means nothing to Scrim"),
    ("albedo:grid", T.String, "heat", r"medium.albedo has a value beside its keys, and cannot have both"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "kind", "value", "message"), WRONG, ids=[it[0] for it in WRONG])
def test_what_contradicts_itself_is_told_with_its_place(fog, name, kind, value, message):
    fog.stage.GetPrimAtPath("/fog").CreateAttribute(f"scrim:{name}", kind).Set(value)
    with pytest.raises(scrim.InputError, match=rf"shot.usda: /fog.scrim:[\w:]+: ({message})"):
        fog.open().scene(1)


def test_the_program_tells_it_in_a_line(fog, program, python_path):
    fog.stage.GetPrimAtPath("/fog").CreateAttribute("scrim:density", T.Float).Set(1.0)
    fog.stage.GetPrimAtPath("/fog").RemoveProperty("scrim:density:scale")
    fog.stage.Save()
    told = program("render", fog.path, "--print-scene", env={**python_path, "SCRIM_PYTHON": sys.executable})
    assert told.returncode == 3 and told.stderr.count("\n") == 1, told.stderr
    assert "shot.usda: /fog.scrim:density: density is 1.0; expected a table of keys: density.grid, " in told.stderr


def test_a_side_car_that_contradicts_itself_is_told_with_its_place(fog):
    side = fog.folder / "side.toml"
    for text, message in (
        ('["/fog"]\ndensity = 3\n', r"side.toml: /fog: density is 3; expected a table of keys: density.grid, "),
        ('["/fog"]\nalbedo = [1, 1, 1]\nmedium.albedo = [1, 1, 1]\n', r"side.toml: /fog: medium.albedo is said twice$"),
        ('["/fog"]\ndensity.noise = "much"\n', r"side.toml: /fog: density.noise is 'much'; expected a table of keys: "),
    ):
        side.write_text(text)
        with pytest.raises(scrim.InputError, match=message):
            fog.open(sidecar=side).scene(1)
    side.write_text('"/fog" = 3\n')
    with pytest.raises(scrim.InputError, match=r"side.toml: '/fog' is 3; expected a table of keys$"):
        fog.open(sidecar=side)
