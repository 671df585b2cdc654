# SPDX-License-Identifier: Apache-2.0
"""The programs of examples/python run, and do what they say."""

import subprocess
import sys

import numpy
import OpenEXR
import pytest
from conftest import ROOT

import scrim

EXAMPLES = ROOT / "examples" / "python"


@pytest.fixture
def example(python_path, tmp_path):
    def run(name, *arguments):
        return subprocess.run(
            [sys.executable, EXAMPLES / name, *map(str, arguments)],
            env=python_path,
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )

    return run


def pixels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def test_relighting_is_rendering_with_other_lights(example, smoke, tmp_path):
    # Presets choose texels and sheets by what lights show; here both renders get the same.
    smoke.write_text(smoke.read_text() + "\n[render]\ntexel = 0.9\nsheet_thickness = 1\n")
    done = example("relight.py", smoke, "relit.npy", "key=2,1,0.5", "rim=0.25")
    assert done.returncode == 0, done.stderr
    relit = numpy.load(tmp_path / "relit.npy")
    rendered = scrim.open(smoke, {"light.key.color": [2, 1, 0.5], "light.rim.intensity": 0.25}).render().image
    assert relit.max() > 0.1 and numpy.allclose(relit, rendered, rtol=1e-4, atol=1e-5)


def test_a_turntable_is_a_picture_for_each_frame(example, tmp_path, program):
    assert program("make", "noise", "resolution=16", "-q", "-o", tmp_path / "smoke.vdb").returncode == 0
    done = example("turntable.py", "smoke.vdb", "turn.####.exr", 3, 32)
    assert done.returncode == 0, done.stderr
    assert sorted(done.stdout.split()) == ["turn.0001.exr", "turn.0002.exr", "turn.0003.exr"]
    first, second = pixels(tmp_path / "turn.0001.exr"), pixels(tmp_path / "turn.0002.exr")
    assert first["A"].max() > 0.1
    assert first["A"].shape != second["A"].shape or not numpy.array_equal(first["A"], second["A"])


def test_the_simulations_plume_rises(example, tmp_path):
    done = example("simulation.py", "plume.####.exr", 6, 16, 36)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-1] == "plume.0006.exr"
    heights = []
    for frame in (1, 6):
        with OpenEXR.File(str(tmp_path / f"plume.{frame:04}.exr"), separate_channels=True) as file:
            top = file.header()["dataWindow"][0][1]
            rows = file.channels()["A"].pixels.sum(axis=1)
            heights.append(top + (rows * numpy.arange(len(rows))).sum() / rows.sum())
    assert heights[1] < heights[0] - 0.3  # y points down
