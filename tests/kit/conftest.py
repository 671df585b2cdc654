# SPDX-License-Identifier: Apache-2.0
"""The kit of the front ends, from the source tree, and the program that it is held against: $SCRIM."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "plugins" / "kit"))

# A shot that needs no file.
SCENE = {
    "camera": {"position": [0.0, 0.0, 3.0], "target": [0.0, 0.0, 0.0], "resolution": [32, 24]},
    "volume": [{"name": "smoke", "source": "noise", "parameters": {"resolution": 16}, "density": {"scale": 5.0}}],
    "light": [{"name": "key", "type": "distant", "direction": [0.0, 0.0, -1.0]}],
}


@pytest.fixture
def scrim():
    """The path of the program."""
    return os.environ["SCRIM"]


@pytest.fixture
def scene(tmp_path):
    """The path of SCENE as the kit writes it."""
    from scrim_kit import toml_text

    path = tmp_path / "scene.toml"
    path.write_text(toml_text.document(SCENE), encoding="utf-8")
    return str(path)


@pytest.fixture
def ask(scrim, tmp_path):
    """Runs the program in a folder of its own, and gives its standard output. Fails where the program does."""

    def run(*arguments):
        done = subprocess.run([scrim, *arguments], capture_output=True, cwd=tmp_path, timeout=60)
        assert done.returncode == 0, done.stderr.decode(errors="replace")
        return done.stdout.decode()

    return run


@pytest.fixture
def script(tmp_path):
    """Makes a program that stands for scrim, of lines of a shell."""

    def make(text):
        path = tmp_path / "program"
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        return str(path)

    return make
