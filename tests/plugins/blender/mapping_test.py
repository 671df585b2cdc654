# SPDX-License-Identifier: Apache-2.0
# What the add-on maps and reads, without Blender: laws by closed forms, nodes by look-alikes, pictures byte by byte.
# What it shares with the other front ends is tested by tests/plugins/python/test_kit_*.py.
import math
import os
import struct
import sys

import numpy as np
import pytest
from lookalikes import link, node, principled, tree_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
from scrim import exr, formulae, nodes  # noqa: E402
from scrim.program_path import program_path  # noqa: E402
from scrim.scrim_kit import Failure  # noqa: E402

# Laws


def test_extinction_is_scattering_and_absorption():
    assert formulae.principled_extinction([0.5, 1, 0.2], [0, 0, 1]) == pytest.approx([1, 1, 0.2])
    assert formulae.principled_extinction([0.5], [0.25]) == pytest.approx([0.75])
    scale, keys = formulae.medium([1, 0.5, 0], [2, 1, 0])
    assert scale == 2 and keys == {"albedo": [0.5, 0.5, 0], "extinction_tint": [1, 0.5, 0]}


def test_density_of_an_object_falls_with_its_size():
    matrix = [[2, 0, 0, 5], [0, 2, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]]
    assert formulae.object_density(matrix) == pytest.approx(0.5)


def test_lenses_fit_the_side_that_blender_says():
    # 36 mm over 50 mm, in a picture twice as high as wide: AUTO takes the height.
    horizontal, sensor, aspect = formulae.camera_window(100, 200, 1, "AUTO", 36, 24)
    lens = formulae.camera_lens("PERSP", horizontal, sensor, aspect, 50, 1, (0.1, 0.2))
    assert lens["fov_axis"] == "vertical" and lens["fov"] == pytest.approx(math.degrees(2 * math.atan(0.36)))
    assert lens["shift"] == pytest.approx([0.2, 0.4])
    horizontal, sensor, aspect = formulae.camera_window(100, 200, 1, "HORIZONTAL", 36, 24)
    assert formulae.camera_lens("ORTHO", horizontal, sensor, aspect, 50, 3, (0, 0))["height"] == pytest.approx(6)
    assert formulae.camera_window(100, 200, 1, "VERTICAL", 36, 24)[:2] == (False, 24)


def test_a_shutter_opens_where_blender_says():
    assert formulae.shutter(0.5, "CENTER") == [-0.25, 0.25]
    assert formulae.shutter(0.5, "START") == [0, 0.5]
    assert formulae.shutter(0.5, "END") == [-0.5, 0]


# Nodes


def test_principled_volume_by_its_grid():
    tree = tree_of(principled(Density=3.0, Color=(0.9, 0.6, 0.3, 1), Anisotropy=0.4))
    density, keys = nodes.medium_of(tree, ["density"]).keys()
    assert density == {"grid": "density", "scale": pytest.approx(3)}
    assert keys["albedo"] == pytest.approx([0.9, 0.6, 0.3])
    assert keys["phase"] == {"type": "hg", "g": 0.4} and "extinction_tint" not in keys


def test_object_density_scales_what_scatters_and_what_glows():
    tree = tree_of(principled(Blackbody_Intensity=2.0))
    density, keys = nodes.medium_of(tree, ["density", "temperature"]).keys(0.5)
    assert density["scale"] == 0.5 and keys["blackbody"]["intensity"] == 1
    assert keys["blackbody"] == {"grid": "temperature", "scale": 1000, "intensity": 1, "normalize": False}


def test_grids_of_colours_are_albedo():
    medium = nodes.medium_of(tree_of(principled(Color_Attribute="Cd")), ["density", "Cd"])
    assert medium.keys()[1]["albedo"] == {"grid": "Cd", "scale": 0.5} and not medium.notes


def test_two_scatters_are_two_lobes():
    grid = node("ShaderNodeAttribute", outputs=("Fac",), values={"attribute_type": "GEOMETRY", "attribute_name": "d"})
    scatters = [
        node("ShaderNodeVolumeScatter", Color=(c, c, c, 1), Density=1.0, Anisotropy=g,
             values={"phase": "HENYEY_GREENSTEIN"})
        for c, g in ((0.6, 0.8), (0.2, -0.3))
    ]  # fmt: skip
    for one in scatters:
        link(grid, one, "Density")
    keys = nodes.medium_of(tree_of(*scatters), ["d"]).keys()[1]
    assert keys["phase"] == {"type": "two-lobe", "g1": 0.8, "g2": -0.3, "blend": pytest.approx(0.25)}


@pytest.mark.parametrize(
    "build, text",
    [
        (lambda: principled(Density_Attribute="smoke"), "a density that is the same everywhere; link a grid to it"),
        (lambda: node("ShaderNodeMixShader", "Mix"), "node 'Mix'"),
    ],
)
def test_what_cannot_be_mapped_is_named(build, text):
    with pytest.raises(nodes.NotMapped) as raised:
        nodes.medium_of(tree_of(build()), ["density"])
    assert str(raised.value) == text


def test_a_missing_grid_is_named():
    shader = principled(Density_Attribute="")
    grid = node("ShaderNodeAttribute", outputs=("Fac",), values={"attribute_type": "GEOMETRY", "attribute_name": "d"})
    link(grid, shader, "Density")
    with pytest.raises(nodes.NotMapped, match="the grid d: the volume has density, heat"):
        nodes.medium_of(tree_of(shader), ["density", "heat"])


def test_what_only_shapes_the_look_is_noted():
    noise = node("ShaderNodeTexNoise", "Noise")
    shader = principled(Emission_Strength=2.0)
    link(noise, shader, "Anisotropy")
    medium = nodes.medium_of(tree_of(shader), ["density"])
    assert medium.notes == ["node 'Noise' at 'Anisotropy'", "emission of one strength everywhere; link a grid to it"]


# Pictures


def picture_bytes(compression=0, flags=0):
    """2 x 2 pixels at (1, 1) of a display of 4 x 4: a half channel A and a float channel Z."""
    channels = b"".join(n + b"\0" + struct.pack("<iiii", k, 0, 1, 1) for n, k in ((b"A", 1), (b"Z", 2))) + b"\0"
    out = b"\x76\x2f\x31\x01" + struct.pack("<i", 2 | flags)
    for name, kind, content in (
        (b"channels", b"chlist", channels),
        (b"compression", b"compression", bytes([compression])),
        (b"dataWindow", b"box2i", struct.pack("<iiii", 1, 1, 2, 2)),
        (b"displayWindow", b"box2i", struct.pack("<iiii", 0, 0, 3, 3)),
    ):
        out += name + b"\0" + kind + b"\0" + struct.pack("<i", len(content)) + content
    out += b"\0"
    first = len(out) + 16
    lines = [struct.pack("<ii", y, 12) + np.array([y, 0.5], "<f2").tobytes() + np.array([7, y], "<f4").tobytes()
             for y in (1, 2)]  # fmt: skip
    return out + struct.pack("<QQ", first, first + len(lines[0])) + b"".join(lines)


def test_pictures_are_read(tmp_path):
    (tmp_path / "a.exr").write_bytes(picture_bytes())
    picture = exr.read(str(tmp_path / "a.exr"))
    whole = picture.region("Z", 0, 0, 4, 4, outside=-1)
    assert whole.tolist() == [[-1] * 4, [-1, 7, 1, -1], [-1, 7, 2, -1], [-1] * 4]
    assert picture.region("A", 2, 1, 2, 2).tolist() == [[0.5, 0], [0.5, 0]]


@pytest.mark.parametrize(
    "content, text",
    [
        (b"PNG", "is not an EXR"),
        (picture_bytes(compression=3), "is compressed; expected no compression"),
        (picture_bytes(flags=0x200), "is tiled, deep, or of several parts; expected one picture of scan lines"),
    ],
)
def test_other_pictures_are_refused(tmp_path, content, text):
    (tmp_path / "a.exr").write_bytes(content)
    with pytest.raises(ValueError, match=text):
        exr.read(str(tmp_path / "a.exr"))


def test_pictures_that_are_written_are_read(tmp_path):
    rgb = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
    exr.write(tmp_path / "a.exr", rgb)
    picture = exr.read(tmp_path / "a.exr")
    assert np.array_equal(np.stack([picture.region(c, 0, 0, 3, 2) for c in "RGB"], axis=-1), rgb)


# The program


def test_the_program_is_found(tmp_path, monkeypatch):
    (tmp_path / "scrim").write_text("#!/bin/sh\n")
    (tmp_path / "scrim").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("SCRIM", raising=False)
    assert program_path() == str(tmp_path / "scrim")
    text = "the add-on's preferences name 'no' as the program scrim, which cannot be run"
    with pytest.raises(Failure, match=text):
        program_path("no")
    monkeypatch.setenv("SCRIM", "/nowhere/scrim")
    with pytest.raises(Failure, match=r"\$SCRIM names '/nowhere/scrim' as the program scrim, which cannot"):
        program_path()
    monkeypatch.delenv("SCRIM")
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(Failure, match="the program scrim was not found: name it in the add-on's preferences"):
        program_path()
