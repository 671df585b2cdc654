# SPDX-License-Identifier: Apache-2.0
"""The package: version, types, and the program within."""

import subprocess
import sys
from pathlib import Path

import scrim


def test_the_version_is_the_programs(program):
    assert program("--version").stdout.splitlines()[0] == f"scrim {scrim.__version__}"


def test_the_program_runs_as_a_module(smoke, tmp_path, python_path):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "scrim", *map(str, arguments)], env=python_path, capture_output=True, text=True
        )

    done = run("render", smoke, "-o", tmp_path / "out.exr", "--res", "16x12", "-q")
    assert done.returncode == 0 and (tmp_path / "out.exr").exists(), done.stderr
    assert run("render", tmp_path / "absent.toml").returncode == 3
    assert run("fly").returncode == 2


def test_types_come_with_it():
    folder = Path(scrim.__file__).parent
    assert (folder / "py.typed").exists()
    stubs = (folder / "_scrim.pyi").read_text()
    for name in ("Field", "Frame", "Job", "Plan", "Shot"):
        assert f"class {name}:" in stubs
        for member in vars(getattr(scrim, name)):
            assert member.startswith("_") or f"def {member}(" in stubs, f"{name}.{member}"
    compile(stubs, "_scrim.pyi", "exec")


def test_everything_public_is_documented():
    for name in scrim.__all__:
        thing = getattr(scrim, name)
        assert thing.__doc__, name
        for member in vars(thing) if isinstance(thing, type) else ():
            if not member.startswith("_"):
                assert getattr(thing, member).__doc__, f"{name}.{member}"
