# SPDX-License-Identifier: Apache-2.0
"""TOML: what the kit writes, the program reads back as the same values."""

import enum
import math
import os
import random
import subprocess
from array import array
from pathlib import Path

import pytest
from conftest import PROGRAM, SHOT
from scrim_kit import Failure, toml_text

tomllib = pytest.importorskip("tomllib", reason="the tests read TOML by Python 3.11")

NUMBERS = [0, -1, 2**63 - 1, -(2**63), 0.1, -0.0, 1e-5, 1e16, 1.5e300, 5e-324, 0.30000000000000004, math.pi, 100.0]
STRINGS = [
    "plain",
    "quote \" and \\ and '",
    "line\nline\r\ttab \b\f",
    "".join(map(chr, range(1, 0x20))) + "\x7f\x80",  # the program takes no NUL
    "é ß 中 \U0001f525 \u2028",
    "####.%04d.$F4.${NAME}",
    "a = 1 # [b]",
]


def read_by_the_program(ask, path):
    """The scene as the program has read and written it anew, which it does where something is overridden."""
    return tomllib.loads(ask("render", path, "--print-scene", "--set", "output.fps=25.0"))


def test_every_value_is_read_back_by_the_program(ask, tmp_path):
    values = {f"n{i}": number for i, number in enumerate(NUMBERS)}
    values |= {f"s{i}": text for i, text in enumerate(STRINGS)}
    values |= {"a key": 1, 'quo"te\\': 2, "": 3, "é": 4, "a.b": 5, "-_9": 6}
    path = tmp_path / "shot.toml"
    path.write_text(toml_text.document({**SHOT, "variables": values}), encoding="utf-8")
    read = read_by_the_program(ask, path)
    assert read["variables"] == values
    assert [type(v) for v in read["variables"].values()] == [type(values[k]) for k in read["variables"]]
    assert {name: read[name] for name in SHOT} == SHOT


def test_tables_lists_and_switches_are_read_back_by_the_program(ask, tmp_path):
    keys = [[1, [0.0, 0.5, 0.25]], [2.5, [1.0, 0.0, 0.0]]]
    moving = {"translate": {"keys": keys}, "scale": [1.0, 2.0, 3.0]}
    medium = {"albedo": [0.5, 0.25, 0.125], "phase": {"type": "two-lobe", "g1": 0.5, "g2": -0.5, "blend": 0.25}}
    scene = {
        **SHOT,
        "volume": [{**SHOT["volume"][0], "transform": moving, "medium": medium, "lights": []}],
        "light": [
            {"name": "a", "type": "distant", "direction": [1, 0, 0], "shadows": False, "color": [1, 0.5, 0]},
            {"name": "b", "type": "distant", "direction": {"keys": keys}, "shadows": True},
        ],
        "output": {"layers": ["light", "depth"], "file": "a.####.exr"},
        "scene_version": 2,
    }
    path = tmp_path / "shot.toml"
    path.write_text(toml_text.document(scene), encoding="utf-8")
    read = read_by_the_program(ask, path)
    assert read["output"].pop("fps") == 25 and read == scene


def test_overrides_are_read_by_the_program(ask, shot):
    overrides = {
        "camera.near": 1e-05,
        "camera.position": (0.5, 0, 3),
        "volume.smoke.medium.phase": {"type": "hg", "g": 0.25},
        "light.key.shadows": False,
        "variables.NAME": STRINGS[3],
        "output.file": STRINGS[1] + ".exr",
    }
    words = [word for key, it in overrides.items() for word in ("--set", toml_text.assignment(key, it))]
    read = tomllib.loads(ask("render", shot, "--print-scene", *words))
    assert read["camera"]["near"] == 1e-05 and read["camera"]["position"] == [0.5, 0, 3]
    assert read["volume"][0]["medium"]["phase"] == {"type": "hg", "g": 0.25}
    assert read["light"][0]["shadows"] is False
    assert read["variables"]["NAME"] == STRINGS[3] and read["output"]["file"] == STRINGS[1] + ".exr"


@pytest.mark.parametrize("number, text", [(math.inf, "inf"), (-math.inf, "-inf"), (math.nan, "nan")])
def test_numbers_that_are_none_are_refused_by_the_program(shot, number, text):
    words = ["--set", toml_text.assignment("camera.position", [0, number, 3])]
    done = subprocess.run([PROGRAM, "plan", shot, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 3 and f"'position[1]' is {text}; expected a number" in done.stderr


def test_any_nested_value_is_toml():
    """By Python's own reader: the program has no place for most of these."""
    dice = random.Random(7)

    def some(depth):
        kind = dice.randrange(7 if depth else 4)
        if kind == 0:
            return dice.choice(NUMBERS)
        if kind == 1:
            return dice.choice(["", *STRINGS])
        if kind == 2:
            return dice.random() * 10.0 ** dice.randrange(-300, 300)
        if kind == 3:
            return dice.random() < 0.5
        if kind == 4:
            return [some(depth - 1) for _ in range(dice.randrange(4))]
        return {dice.choice([*STRINGS, "a", "b", "c"]): some(depth - 1) for _ in range(dice.randrange(4))}

    for _ in range(500):
        scene = {str(i): some(4) for i in range(3)}
        assert tomllib.loads(toml_text.document(scene)) == scene


class Vector:
    """As Blender's: it has items in an order, and is no sequence of Python's."""

    def __len__(self):
        return 2

    def __getitem__(self, i):
        return (0.5, 1.0)[i]


class Level(enum.IntEnum):
    HIGH = 2


def test_numbers_and_lists_of_other_kinds_are_written_plainly():
    for it, text in [
        (Vector(), "[0.5, 1.0]"),
        (array("d", [0.5]), "[0.5]"),
        ((1, 2), "[1, 2]"),
        (Level.HIGH, "2"),
        (Path("a/b"), '"a/b"'),
        ({}, "{  }"),
        ([], "[]"),
    ]:
        assert toml_text.value(it, "it") == text


def test_arrays_of_numpy_are_lists():
    numpy = pytest.importorskip("numpy")
    assert toml_text.value(numpy.array([[1, 2], [3, 4]]), "it") == "[[1, 2], [3, 4]]"
    assert toml_text.value([numpy.float32(0.5), numpy.float64(0.1), numpy.int64(3)], "it") == "[0.5, 0.1, 3]"
    assert toml_text.value(numpy.bool_(True), "it") == "true"


@pytest.mark.parametrize(
    "it, text",
    [
        (object(), r"^'it' is of type object; expected a bool, a number, a string, a path, a list or a dict$"),
        ([0, [object()]], r"^'it\[1\]\[0\]' is of type object; expected"),
        ({"k": None}, r"^'it.k' is of type NoneType; expected"),
        (b"bytes", r"^'it' is of type bytes; expected"),
        ({1}, r"^'it' is of type set; expected"),
        ({3: 4}, r"^a key of a scene is 3, expected a string$"),
        (os.fsdecode(b"a\xff"), r"^'it' is not UTF-8: 'a\\udcff'$"),
    ],
)
def test_what_toml_does_not_have_is_named(it, text):
    with pytest.raises(Failure, match=text):
        toml_text.value(it, "it")


def test_names_of_files_that_are_no_utf8_are_named():
    with pytest.raises(Failure, match="^'volume.file' is not UTF-8"):
        toml_text.document({"volume": [{"file": os.fsdecode(b"smoke\xfe.vdb")}]})
