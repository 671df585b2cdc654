# SPDX-License-Identifier: Apache-2.0
"""How the program starts Python: nothing that lies in the current folder is run, whoever put it there."""

import os
import subprocess
import sys

import pytest
from conftest import PROGRAM, SMOKE

pytest.importorskip("tornado")
pytest.importorskip("tomlkit")

HOSTILE = (
    "scrim", "scrim_kit", "numpy", "tornado", "tomlkit", "pxr", "sitecustomize", "usercustomize", "json", "linecache",
    "encodings", "runpy", "os", "readline",
)  # fmt: skip
# How PYTHONPATH may name the current folder without a word of the user: an empty entry.
PATHS = ("{}", ":{}", "{}:", "{}::{}")


@pytest.fixture
def hostile(tmp_path):
    """A folder of modules that say that they were run, in the file `owned`."""
    for name in HOSTILE:
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'owned')!r}, 'a').write({name + ' '!r})\n")
    (tmp_path / "smoke.toml").write_text(SMOKE)
    return tmp_path


@pytest.fixture(params=["as it is", "without safe paths"])
def python(request, tmp_path_factory):
    """The Python that runs the tests; and as Python 3.10 would do, which knows no PYTHONSAFEPATH."""
    if request.param == "as it is":
        return sys.executable
    old = tmp_path_factory.mktemp("old") / "python3"
    old.write_text(f'#!/bin/sh\nunset PYTHONSAFEPATH\nexec "{sys.executable}" "$@"\n')
    old.chmod(0o755)
    return str(old)


def environment(python_path, python, path):
    package = python_path["PYTHONPATH"]
    return {**python_path, "SCRIM_PYTHON": python, "PYTHONPATH": path.replace("{}", package)}


def owned(folder):
    there = folder / "owned"
    return there.read_text() if there.exists() else ""


@pytest.mark.parametrize("path", PATHS)
def test_the_viewer_runs_no_module_of_the_current_folder(hostile, python_path, python, path):
    viewer = subprocess.Popen(
        [PROGRAM, "view", "smoke.toml", "--no-browser"], cwd=hostile, env=environment(python_path, python, path),
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    line = viewer.stdout.readline()
    viewer.terminate()
    said = viewer.communicate()[1]
    assert not owned(hostile) and "http://" in line, line + said


@pytest.mark.parametrize("path", PATHS)
def test_rendering_a_stage_runs_no_module_of_the_current_folder(hostile, python_path, python, path):
    usd_stages = pytest.importorskip("usd_stages", reason="usd-core is not installed")
    stage = usd_stages.lit_fog_stage(hostile)
    stage.stage.Save()
    done = subprocess.run(
        [PROGRAM, "render", stage.path, "--frames", "1", "--res", "8x8", "-q", "-o", "a.exr"], cwd=hostile,
        env=environment(python_path, python, path), capture_output=True, text=True,
    )  # fmt: skip
    assert not owned(hostile) and done.returncode == 0, done.stderr
    assert (hostile / "a.exr").exists()


def test_a_folder_that_the_path_names_is_where_modules_are_found(tmp_path, python_path):
    (tmp_path / "scrim.py").write_text("raise ImportError('mine')")
    done = subprocess.run(
        [PROGRAM, "view", "smoke.toml"], cwd=tmp_path, capture_output=True, text=True,
        env={**python_path, "SCRIM_PYTHON": sys.executable, "PYTHONPATH": f"{tmp_path / 'none'}:."},
    )  # fmt: skip
    assert done.returncode == 3 and "mine; the viewer is in Scrim's Python package" in done.stderr, done.stderr


def test_programs_that_python_starts_find_their_own_modules(tmp_path, python_path):
    """The variable that protects Python is not passed on."""
    package = tmp_path / "scrim" / "view"
    package.mkdir(parents=True)
    (tmp_path / "scrim" / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package / "__main__.py").write_text("import os\ndef main(): print(os.environ.get('PYTHONSAFEPATH'))\n")
    for given, expected in ((None, "None"), ("1", "1")):
        more = {} if given is None else {"PYTHONSAFEPATH": given}
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONSAFEPATH"} | more
        done = subprocess.run(
            [PROGRAM, "view", "smoke.toml"], capture_output=True, text=True,
            env={**environment, "SCRIM_PYTHON": sys.executable, "PYTHONPATH": str(tmp_path)},
        )  # fmt: skip
        assert done.stdout.strip() == expected, done.stderr
