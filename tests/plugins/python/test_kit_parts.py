# SPDX-License-Identifier: Apache-2.0
"""Names and meshes, and where the kit is: in every front end, and nothing of it a second time."""

import re
import struct
import subprocess
import sys
import zipfile
from array import array

import pytest
from conftest import ROOT, SHOT
from scrim_kit import ply, toml_text
from scrim_kit.names import Names

import scrim

PLUGINS = ROOT / "plugins"
KIT = PLUGINS / "kit" / "scrim_kit"


def test_names_are_plain_and_given_once():
    names = Names()
    assert [names.of(n) for n in ("Key.001", "Key 001", "Key.001", "")] == ["Key_001", "Key_001_2", "Key_001_3", "_"]
    assert [names.of("fog", "a_fog") for _ in range(3)] == ["fog", "a_fog", "a_fog_2"]


def test_names_are_taken_by_the_program(ask, tmp_path):
    names = Names()
    given = [names.of(text) for text in ("Key.001", "Key 001", "é[0]", "", "9", "a\nb", '"')]
    scene = {**SHOT, "light": [{**SHOT["light"][0], "name": name} for name in given]}
    (tmp_path / "shot.toml").write_text(toml_text.document(scene))
    ask("plan", "shot.toml", *(word for name in given for word in ("--set", f"light.{name}.intensity=2")))


def test_meshes_are_ply(tmp_path):
    ply.write(tmp_path / "a.ply", array("f", range(9)), array("i", (0, 1, 2, 2, 1, -3)))
    data = (tmp_path / "a.ply").read_bytes()
    assert data.endswith(struct.pack("<9f", *range(9)) + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 2, 1, -3))
    assert b"element vertex 3\n" in data and b"element face 2\n" in data


def test_arrays_of_numpy_are_meshes(tmp_path):
    numpy = pytest.importorskip("numpy")
    ply.write(tmp_path / "a.ply", array("f", range(9)), array("i", (0, 1, 2)))
    points, corners = numpy.arange(9, dtype=numpy.float32).reshape(3, 3), numpy.array([[0, 1, 2]], numpy.int32)
    ply.write(tmp_path / "b.ply", points, corners)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    with pytest.raises(TypeError, match="a mesh has a buffer of format 'd', expected 'f'"):
        ply.write(tmp_path / "b.ply", points.astype(float), corners)


def test_meshes_are_read_by_the_library(tmp_path):
    """A plate before the lower half of the smoke hides that. It changes the dials that the preset chooses."""
    corners = [-9, -9, 2, 9, -9, 2, 9, 0, 2, -9, 0, 2]
    ply.write(tmp_path / "plate.ply", array("f", corners), array("i", (0, 1, 2, 0, 2, 3)))
    # A preset looks at what the plate leaves, and may choose other dials.
    shot = {**SHOT, "render": {"texel": 0.5, "sheet_thickness": 1}}
    whole = scrim.loads(shot).render().image[:, :, 3]
    upper = scrim.loads({**shot, "mesh": [{"file": "plate.ply"}]}, folder=tmp_path).render().image[:, :, 3]
    assert whole[12:].max() > 0.1 and upper[12:].max() == 0
    assert abs(upper[:12] - whole[:12]).max() < 0.01


def test_the_add_ons_archive_holds_the_kit(tmp_path):
    subprocess.run([sys.executable, "-B", PLUGINS / "blender" / "make_zip.py", tmp_path / "a.zip"], check=True)
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        names = archive.namelist()
        archive.extractall(tmp_path)
    assert {f"scrim/scrim_kit/{file.name}" for file in KIT.glob("*.py")} <= set(names)
    assert {"scrim/__init__.py", "scrim/blender_manifest.toml"} <= set(names)
    assert all(name.startswith("scrim/") and name.endswith((".py", ".toml")) for name in names)
    code = "from scrim.scrim_kit import frames; import scrim; print(len(scrim.__path__), frames.__name__)"
    done = subprocess.run([sys.executable, "-B", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "1 scrim.scrim_kit.frames\n"


@pytest.mark.parametrize("front_end", ["blender/scrim", "farm/scrim_farm", "python/scrim"])
def test_front_ends_use_the_kit_and_have_nothing_of_it(front_end):
    sources = {path: path.read_text() for path in (PLUGINS / front_end).rglob("*.py")}
    own = "".join(sources.values())
    assert re.search(r"^from \.?scrim_kit", own, re.MULTILINE)
    for word in ("re.sub(r\"[$#%]", '.replace("$"', "property list uchar", "PR_SET_PDEATHSIG", "scrim: error: ",
                 "json.dumps("):  # fmt: skip
        assert word not in own, f"{word} is in {[path for path, text in sources.items() if word in text]}"


def test_the_kit_needs_nothing_but_python():
    """And its modules import one another relatively, so that it can be a package of an add-on."""
    for path in KIT.glob("*.py"):
        for name in re.findall(r"^ *(?:from|import) (\S+)", path.read_text(), re.MULTILINE):
            assert name.startswith(".") or name.split(".")[0] in sys.stdlib_module_names, f"{path.name}: {name}"
