# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a small scene that needs no file, and the program to compare with."""

import os
import subprocess
from pathlib import Path

import pytest

import scrim

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(scrim.__file__).parent / "bin" / "scrim"

SMOKE = """\
[camera]
position = [0, 0.3, 5]
target = [0, 0, 0]
fov = 36
resolution = [64, 48]

[[volume]]
name = "smoke"
source = "noise"
parameters = { resolution = 32, seed = 4 }
density = { scale = 25 }

[[light]]
name = "key"
type = "distant"
direction = [0.6, -0.5, -0.6]
intensity = 4.5

[[light]]
name = "rim"
type = "distant"
direction = [-0.8, -0.3, 0.5]
color = [0.5, 0.7, 1]

[output]
type = "float"
layers = ["light", "depth"]
"""

# A slab of 16 units seen and lit from the front: closed forms are known of it.
SLAB = {
    "camera": {
        "type": "orthographic",
        "position": [0, 0, 50],
        "target": [0, 0, 0],
        "height": 24,
        "resolution": [32, 32],
    },
    "volume": [{"name": "fog", "density": {"scale": 0.1}, "medium": {"albedo": [0.9, 0.9, 0.9]}}],
    "light": [{"name": "key", "type": "distant", "direction": [0, 0, -1]}],
}


@pytest.fixture
def smoke(tmp_path):
    """The path of a scene."""
    path = tmp_path / "smoke.toml"
    path.write_text(SMOKE)
    return path


@pytest.fixture
def program():
    """Runs the program that the package holds."""

    def run(*arguments, **options):
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)

    return run


@pytest.fixture
def python_path():
    """The environment in which a child finds the package."""
    package = str(Path(scrim.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": package}
