# SPDX-License-Identifier: Apache-2.0
"""Ranges and patterns of frames: those of the kit are those of the program."""

import json
import os
import random
import re
import subprocess

import pytest
from conftest import PROGRAM
from scrim_kit import Failure
from scrim_kit.frames import at_frame, parse_range, pattern_of, range_text, without_frame

FRAMES = "7,12345-12347x2,-12--11,0,7"
# All that a pattern may hold, and what looks like it.
PIECES = (
    *("####", "%04d", "$F4", "#", "%d", "$F", "$F0", "$F12", "%4d", "%0d", "%00d", "%03d", "%s", "100%", "$$", "$#"),
    *("$%", "$$F4", "$#$#", "$%04d", "$#####", "##$F2%02d", "$F4000", "$F99999999999", "%099999999999d", "#" * 30),
)
ATOMS = (*"#%Fd04/x-", "#", "%", "$$", "$#", "$%", "$F", "$F2", "%0", "%03d")
FOLDERS = ("a##b/", "%04d/", "$F4/", "do$$lar/", "x$#y/$%d/", "-5/", "")


@pytest.fixture
def planned(ask, shot):
    """{frame: path} as the program resolves an output."""

    def paths(pattern, frames=FRAMES):
        plans = json.loads(ask("plan", shot, "--json", f"--frames={frames}", "-o", pattern))
        return {plan["frame"]: plan["outputs"]["file"]["path"] for plan in plans}

    return paths


@pytest.mark.parametrize("folder", FOLDERS)
def test_patterns_are_those_of_the_program(planned, folder):
    pattern = folder + ".".join(PIECES) + ".exr"
    said = planned(pattern)
    assert list(said) == [7, 12345, 12347, -12, -11, 0]
    assert said == {frame: at_frame(pattern, frame) for frame in said}


def test_any_mixture_is_that_of_the_program(planned):
    dice = random.Random(3)
    for _ in range(40):
        pattern = "x" + "".join(dice.choice(ATOMS) for _ in range(dice.randrange(1, 24))) + "x.exr"
        pattern = re.sub(r"\$F(?=[A-Za-z])", "$F-", pattern)  # the program takes $Fd for a mistake
        pattern = re.sub("//+", "/", pattern)
        said = planned(pattern, "-3,42")
        assert said == {frame: at_frame(pattern, frame) for frame in (-3, 42)}, pattern


@pytest.mark.parametrize("name", ["do$lar", "take#2", "a##b.%04d.$F4.x", "100%", "$$", "$#", "${HOME}", "plain", "-5"])
def test_every_name_has_a_pattern(planned, name):
    path = f"{name}/{name}.exr"
    assert planned(pattern_of(path), "7") == {7: path}
    assert at_frame(pattern_of(path), 7) == path
    assert without_frame(pattern_of(path)) == path


def test_a_pattern_names_a_file_to_read(ask, tmp_path):
    """Whatever stands beside it that the name would be a pattern of."""
    for name, resolution in (("s#.vdb", 16), ("s7.vdb", 24)):
        made = [PROGRAM, "make", "noise", f"resolution={resolution}", "-q", "-o", name]
        subprocess.run(made, check=True, cwd=tmp_path, timeout=60)
    voxels = json.loads(ask("plan", pattern_of("s#.vdb"), "--json", "--frames=7"))[0]["plan"]["voxel"]
    os.unlink(tmp_path / "s#.vdb")
    assert json.loads(ask("plan", "s#.vdb", "--json", "--frames=7"))[0]["plan"]["voxel"] != voxels
    with pytest.raises(AssertionError, match="s#.vdb"):
        ask("plan", pattern_of("s#.vdb"), "--json", "--frames=7")


def test_names_without_their_frame():
    assert [without_frame(p) for p in ("a.####", "a$#1.%04d", "%4d.$F")] == ["a.", "a#1.", "%4d."]


def test_frames_are_written_shortly(planned):
    assert range_text([1, 2, 3, 7, 9, 10]) == "1-3,7,9-10"
    assert range_text([-3, -2, -1, 0, 5]) == "-3-0,5" and range_text([]) == ""
    for frames in ([-3, -2, 8], [1], [-1], [1, 2, 4, 5, 6]):
        assert parse_range(range_text(frames), "") == frames
        assert list(planned("a.exr", range_text(frames))) == frames


@pytest.mark.parametrize("text", ["1-9x4,20,3", " 5 , 4-6", "3-3", "-2--1", "00012", "7,7,7", "10-20x50", "1-3x0001"])
def test_ranges_are_those_of_the_program(planned, text):
    assert parse_range(text, "--frames") == list(planned("a.exr", text))


WRONG = ("1:3", "3-1", "1-3x0", "", ",", "1,", "a", "1-", "1x2", "1-3x", "1-3x-1", "+1", "1 - 3", "1.5", "٣", "1-2-3")


@pytest.mark.parametrize("text", WRONG)
def test_wrong_ranges_are_refused_as_the_program_does(shot, text):
    with pytest.raises(Failure) as failure:
        parse_range(text, "--frames")
    assert str(failure.value) == f"--frames {text}: expected a range such as 1-48x2,60"
    done = subprocess.run([PROGRAM, "plan", shot, "--json", f"--frames={text}"], capture_output=True, timeout=60)
    assert done.returncode == failure.value.status == 2, done.stderr


@pytest.mark.parametrize(
    "text, reason",
    [
        ("1000000001", "frames and steps up to 1000000000"),
        ("-1000000001-0x9999999", "frames and steps up to 1000000000"),
        ("1-2x9999999999", "frames and steps up to 1000000000"),
        ("1-1000001", "at most 1000000 frames"),
        ("1-999999,-2--1", "at most 1000000 frames"),
    ],
)
def test_ranges_that_are_too_long_are_refused_as_the_program_does(shot, text, reason):
    with pytest.raises(Failure, match=f"^--frames {text}: expected {reason}$"):
        parse_range(text, "--frames")
    done = subprocess.run([PROGRAM, "plan", shot, "--json", f"--frames={text}"], capture_output=True, timeout=60)
    assert done.returncode == 2, done.stderr
