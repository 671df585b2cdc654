# SPDX-License-Identifier: Apache-2.0
# What the add-on maps and reads, without Blender: laws by closed forms, nodes by look-alikes, pictures byte by byte.
import math
import os
import struct
import subprocess
import sys
import time

import numpy as np
import pytest
from lookalikes import link, node, principled, tree_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "plugins", "blender"))
from scrim import child, exr, export, formulae, meshes, nodes, scene_text  # noqa: E402

# Laws


def test_a_sun_gives_the_same_irradiance_whatever_its_angle():
    for angle in (0.0, 0.01, 0.5, 1.5):
        sun = formulae.sun([2, 1, 0], angle)
        # On a card that faces the sun: radiance times the integral of the cosine, pi sin^2(half).
        half = 0.5 * angle
        solid = 2 * math.pi * (1 - math.cos(half)) if angle else 1.0
        card = sun["intensity"] / solid * (math.pi * math.sin(half) ** 2 if angle else 1.0)
        assert card == pytest.approx(2.0)
        assert sun["color"] == [1, 0.5, 0]


def test_a_sphere_has_the_intensity_of_its_point():
    small = formulae.point([8, 8, 8], 0.0)
    large = formulae.point([8, 8, 8], 0.5)
    assert large["intensity"] * math.pi * 0.5**2 == pytest.approx(small["intensity"])


def test_a_disk_gives_what_its_area_says():
    disk, square = (formulae.area([1, 1, 1], 2, 2, ellipse) for ellipse in (True, False))
    assert disk["intensity"] * math.pi * disk["radius"] ** 2 == pytest.approx(1 / math.pi)
    assert square["intensity"] * 4 == pytest.approx(1 / math.pi)
    assert formulae.area([1, 1, 1], 2, 2, False, normalize=False)["intensity"] == pytest.approx(1 / math.pi)


def test_a_spot_fades_between_the_same_cosines():
    for size in (0.3, 1.0, 2.5):
        for blend in (0.0, 0.2, 1.0):
            spot = formulae.spot([1, 1, 1], size, blend)
            outer = math.cos(size / 2)
            inner = math.cos(math.radians(spot["cone"]) / 2 * (1 - spot["blend"]))
            assert inner - outer == pytest.approx((1 - outer) * blend, abs=1e-12)


def test_strength_counts_exposure_and_temperature():
    assert formulae.light_strength((1, 0.5, 0), 3, 1, (1, 1, 0.5)) == [6, 3, 0]


def test_a_light_that_takes_light_away_gives_none():
    assert formulae.split([-1, 0, 0]) == ([1, 1, 1], 0)


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


# Scenes, pictures, meshes


def test_scenes_are_toml():
    import tomllib

    scene = {"camera": {"fov": 35.0, "matrix": [[1.0, 0.0], [0.0, 1.0]]}, "volume": [{"name": 'a"\\\n', "on": True}]}
    assert tomllib.loads(scene_text.scene_text(scene)) == {"scene_version": 2, **scene}


def test_numbers_that_are_none_are_refused():
    with pytest.raises(ValueError, match="inf is no number for a scene"):
        scene_text.scene_text({"camera": {"near": math.inf}})


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
        (b"PNG", "is no EXR"),
        (picture_bytes(compression=3), "is compressed; expected none"),
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


def test_meshes_are_ply(tmp_path):
    meshes.write_ply(tmp_path / "a.ply", np.arange(9).reshape(3, 3), np.array([[0, 1, 2]]))
    data = (tmp_path / "a.ply").read_bytes()
    assert data.endswith(struct.pack("<9f", *range(9)) + struct.pack("<B3i", 3, 0, 1, 2))


def test_names_are_plain_and_used_once():
    names = export.Names()
    assert [names.of(n) for n in ("Key.001", "Key 001", "")] == ["Key_001", "Key_001_2", "_"]


# The child


def script(tmp_path, text):
    path = tmp_path / "program"
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)
    return str(path)


def test_a_child_reports(tmp_path):
    program = script(tmp_path, """echo '{"progress":50.0}'; echo other; echo 'scrim: warning: w' >&2; exit 5""")
    parts = []
    status, told = child.run([program], parts.append)
    assert (status, parts, child.warnings(told)) == (child.WRITTEN_BUT_MISSED, [0.5], ["w"])


def test_a_child_is_cancelled(tmp_path):
    program = script(tmp_path, f"echo $$ > {tmp_path}/pid; exec sleep 60")
    begun = time.monotonic()
    with pytest.raises(child.Cancelled):
        child.run([program], cancelled=lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").stat().st_size > 0)
    assert time.monotonic() - begun < 10
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_a_child_in_the_background_may_say_much(tmp_path):
    """More than pipes hold: 200 KiB of warnings, and as much on standard output."""
    line = "scrim: warning: " + "w" * 1000
    many = f"for i in $(seq 200); do echo '{line}' >&2; echo '{line}'; done; echo 'scrim: error: why' >&2; exit 3"
    background = child.Background([script(tmp_path, many)], str(tmp_path / "told"))
    deadline = time.monotonic() + 10
    while not background.ended():
        if time.monotonic() > deadline:
            background.stop()
            pytest.fail("it was stopped by what it says")
        time.sleep(0.01)
    status, told = background.result()
    assert (status, len(told), child.reason(status, told)) == (3, 201, "why")


def test_a_child_in_the_background_is_stopped(tmp_path):
    background = child.Background([script(tmp_path, "echo begun >&2; exec sleep 60")], str(tmp_path / "told"))
    assert not background.ended()
    background.stop()
    assert background.ended() and background.result()[0] < 0


def test_a_child_ends_with_its_parent(tmp_path):
    """The parent ends as SIGTERM ends Blender: without a word."""
    program = script(tmp_path, f"echo $$ > {tmp_path}/pid; exec sleep 60")
    code = f"import sys; sys.path[:0] = {sys.path!r}; from scrim import child; child.run([{program!r}])"
    parent = subprocess.Popen([sys.executable, "-c", code])
    deadline = time.monotonic() + 20
    while not ((tmp_path / "pid").exists() and (tmp_path / "pid").read_text().strip()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    pid = int((tmp_path / "pid").read_text())
    while time.monotonic() < deadline:
        try:
            with open(f"/proc/{pid}/stat") as file:
                if file.read().rpartition(")")[2].split()[0] == "Z":
                    return
        except FileNotFoundError:
            return
        time.sleep(0.05)
    os.kill(pid, 9)
    pytest.fail("the child lives on")


def test_why_a_child_failed():
    assert child.reason(3, ["x", "scrim: error: 'fov' is 200", ""]) == "'fov' is 200"
    assert child.reason(-11, []) == "scrim was ended by signal 11"
    assert child.reason(1, []) == "scrim ended with exit status 1"


def test_the_program_is_found(tmp_path, monkeypatch):
    program = script(tmp_path, "")
    os.rename(program, tmp_path / "scrim")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("SCRIM", raising=False)
    assert child.find_program() == str(tmp_path / "scrim")
    text = "the add-on's preferences name 'no' as the program scrim, which cannot be run"
    with pytest.raises(child.Failure, match=text):
        child.find_program("no")
    monkeypatch.setenv("SCRIM", "/nowhere/scrim")
    with pytest.raises(child.Failure, match=r"\$SCRIM names '/nowhere/scrim' as the program scrim, which cannot"):
        child.find_program()
    monkeypatch.delenv("SCRIM")
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(child.Failure, match="the program scrim was not found: name it in the add-on's preferences"):
        child.find_program()
