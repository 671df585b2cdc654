# SPDX-License-Identifier: Apache-2.0
# Runs code in OpenVDB AX by the program that $SCRIM names, for tests of what becomes of nodes.
import json
import os
import subprocess
import tempfile


def numbers_of(code, **grids):
    """The number in each grid that `code` makes, at a voxel where the `grids` hold these numbers."""
    program = os.environ["SCRIM"]

    def run(*arguments):
        return subprocess.run([program, *arguments], check=True, capture_output=True, text=True, cwd=folder).stdout

    with tempfile.TemporaryDirectory() as folder:
        run("make", "primitives", "shapes=box size=1,1,1", "voxel=0.5", "-o", "box.vdb")
        given = "".join(f"f@{name} = {value!r}f;" for name, value in grids.items())
        run("make", "ax", "file=box.vdb", f"code={given}", "-o", "given.vdb")
        with open(os.path.join(folder, "nodes.ax"), "w") as file:
            file.write(code)
        run("make", "ax", "file=given.vdb", "ax_file=nodes.ax", "-o", "made.vdb")
        info = json.loads(run("info", "made.vdb", "--json"))
    assert all(grid["min_value"] == grid["max_value"] for grid in info["grids"] if "max_value" in grid)
    return {g["name"]: g["max_value"] for g in info["grids"] if g["name"].startswith("scrim_") and "max_value" in g}
