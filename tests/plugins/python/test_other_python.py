# SPDX-License-Identifier: Apache-2.0
"""The package in front of a Python for which its module was not built."""

import pathlib
import shutil
import subprocess
import sys

import pytest
import scrim


@pytest.mark.parametrize(
    "module, expected",
    [
        ("_scrim.cpython-37-x86_64-linux-gnu.so", "is for Python 3.7, and this is Python"),
        (None, "holds no module _scrim"),
    ],
)
def test_the_package_says_what_to_do(tmp_path, module, expected):
    package = tmp_path / "scrim"
    package.mkdir()
    for file in pathlib.Path(scrim.__file__).parent.glob("*.py"):
        shutil.copy(file, package)
    if module:
        (package / module).write_bytes(b"")
    run = subprocess.run([sys.executable, "-c", "import scrim"], cwd=tmp_path, env={}, capture_output=True, text=True)
    assert run.returncode != 0
    last = run.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: ") and expected in last, run.stderr
    assert "configure with" in last or "build it with" in last
