# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a small scene that needs no file, and the program to compare with."""

import os
import subprocess
from pathlib import Path

import pytest
from scrim_kit import toml_text

import scrim

ROOT = Path(__file__).resolve().parents[3]
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

# The least that a shot needs, for what is about words and not about pictures.
SHOT = {
    "camera": {"position": [0.0, 0.0, 3.0], "target": [0.0, 0.0, 0.0], "resolution": [32, 24]},
    "volume": [{"name": "smoke", "source": "noise", "parameters": {"resolution": 16}, "density": {"scale": 5.0}}],
    "light": [{"name": "key", "type": "distant", "direction": [0.0, 0.0, -1.0]}],
}

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


@pytest.fixture
def shot(tmp_path):
    """The path of SHOT as the kit of the front ends writes it."""
    path = tmp_path / "shot.toml"
    path.write_text(toml_text.document(SHOT), encoding="utf-8")
    return str(path)


@pytest.fixture
def ask(tmp_path):
    """Runs the program in the folder of the test, and gives its standard output. Fails where the program does."""

    def run(*arguments):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, cwd=tmp_path, timeout=60)
        assert done.returncode == 0, done.stderr.decode(errors="replace")
        return done.stdout.decode()

    return run
