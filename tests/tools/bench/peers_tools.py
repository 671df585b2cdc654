# SPDX-License-Identifier: Apache-2.0
"""The tools of peers.py that draw at random: who is there, what they need of the scene, and how they are called.

SCRIM_PEERS_PYTHON names Pythons, with ':' between, that have `mitsuba`, `pyluxcore` or `bpy`, each from PyPI and with
NumPy; a tool is taken from the first that has it, Cycles once for each major version of bpy. Debian's Blender
stands in for Cycles where no Python has bpy. Mitsuba and LuxCore read no OpenVDB files here: they get a dense array,
made with Debian's python3-openvdb.
"""
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PACKAGES = {"mitsuba": "mitsuba", "luxcore": "pyluxcore", "cycles": "bpy"}
ASK = "import importlib.metadata as m\nfor p in {}:\n try: print(p, m.version(p))\n except m.PackageNotFoundError: pass"


def found():
    """{tool: (the start of its command, version)}: mitsuba, luxcore, and cycles 4, cycles 5 and so on."""
    tools = {}
    for python in filter(None, os.environ.get("SCRIM_PEERS_PYTHON", "").split(os.pathsep)):
        said = subprocess.run([python, "-c", ASK.format(tuple(PACKAGES.values()))], check=True, stdout=subprocess.PIPE,
                              text=True).stdout
        for line in said.splitlines():
            package, version = line.split()
            tool = next(t for t, p in PACKAGES.items() if p == package)
            tools.setdefault(f"cycles {version.split('.')[0]}" if tool == "cycles" else tool, ([python], version))
    if not any(t.startswith("cycles") for t in tools) and shutil.which("blender"):
        said = subprocess.run(["blender", "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
        version = re.search(r"Blender ([\d.]+)", said).group(1)
        tools[f"cycles {version.split('.')[0]}"] = (["blender", "-b", "--factory-startup", "-P"], version)
    return tools


def say_missing(tools, wanted=tuple(PACKAGES)):
    for tool, package in PACKAGES.items():
        if tool in wanted and not any(t.split()[0] == tool for t in tools):
            print(f"{tool}: skipped, since no Python of SCRIM_PEERS_PYTHON has '{package}' (from PyPI)"
                  + (", and there is no program 'blender'" if tool == "cycles" else ""))


def add_array(numbers, work):
    """The grid as a file of NumPy's, with a border of zeros, where the centre of its first voxel is, and the voxels'
    edge. Gives whether there is one. A process of its own makes it: peers.py would hand its memory on to all that it
    measures."""
    file = work / f"{Path(numbers['asset']).stem}.npy"
    made = subprocess.run(["/usr/bin/python3", HERE / "peers_tools.py", numbers["asset"], numbers["grid"], file],
                          stdout=subprocess.PIPE, text=True)
    if made.returncode == 0:
        numbers["array"] = str(file)
        numbers["origin"], numbers["voxel"] = json.loads(made.stdout)
    return made.returncode == 0


def write_array(asset, name, file):
    import numpy
    import pyopenvdb
    grid = pyopenvdb.read(asset, name)
    low, high = grid.evalActiveVoxelBoundingBox()
    low = tuple(c - 1 for c in low)
    array = numpy.zeros([h - l + 2 for l, h in zip(low, high)], numpy.float32)
    grid.copyToArray(array, ijk=low)
    numpy.save(file, numpy.maximum(array, 0))
    print(json.dumps((grid.transform.indexToWorld(low), grid.transform.voxelSize()[0])))


def write_numbers(numbers, work, name, **more):
    """Those of the scene and what a tool is told beside; "twice" is for Cycles."""
    file = work / f"numbers-{name}.json"
    file.write_text(json.dumps({"twice": True, "seed": 0} | numbers | more))
    return file


def command(tool, start, numbers_file, picture, samples, *how):
    """`how`: of Mitsuba variant and integrator, of LuxCore the step, of Cycles the step rate and the adaptive noise."""
    script = HERE / f"peers_{tool.split()[0]}.py"
    dashes = ["--"] if tool.startswith("cycles") else []
    return [*start, script, *dashes, numbers_file, picture, str(samples), *map(str, how)]


def describe(tool, how):
    if tool == "mitsuba":
        return " ".join(how)
    if tool == "luxcore":
        return f"step {how[0]:g}"
    rate, *adaptive = how
    return (f"step rate {rate:g}" if rate else "null collisions") + "".join(f" adaptive {a:g}" for a in adaptive)


def seconds(log, what="render"):
    """Of rendering, by the clock, or of all processors ("processor"; Mitsuba and Cycles say it)."""
    return float(re.findall(rf"^{what} ([\d.e+-]+)$", log, re.MULTILINE)[-1])


if __name__ == "__main__":
    write_array(*sys.argv[1:])
