#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How steady presets are in motions that shots have: what `scrim study --steady` finds of each.

    tests/tools/bench/steady.py [--asset FILE.vdb] [--quality NAME]... [--motion NAME]... [--scattering full]
                                [--depth D] [--albedo A] [--g G] [--frames N] [--res WxH] [--csv FILE]

The volume is a ball of noise, or an asset with cubic voxels about the origin; --depth is its optical depth a voxel where it is densest. Motions, a frame:

    behind, aside, front   the sun turns by half a degree about the picture's up
    orbit                  the camera turns by half a degree about the volume
    pan                    the camera moves aside by a hundredth of the volume
    lamp, within           a lamp moves by a hundredth of the volume beside it, or in it, where it has a radius of three hundredths
    bare                   a lamp without a radius moves in the volume, the same way
    swelling               the volume grows by half a hundredth

A row a motion and preset: excess of the beauty and of its layers, in per cent, the most that is promised, and seconds.
Needs a build (SCRIM_BUILD names it).
"""
import argparse
import csv
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCRIM = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin" / "scrim"
MOTIONS = ("behind", "aside", "front", "orbit", "pan", "lamp", "within", "bare", "swelling")
AZIMUTHS = {"behind": 0, "aside": 90, "front": 150}  # degrees of the sun; 0 is behind the volume
COLUMNS = ["motion", "quality", "beauty", "direct", "indirect", "promised", "seconds"]


def volume_of(options):
    """The volume's lines, its middle, its size and the edge of a voxel, in world units."""
    if options.asset is None:
        lines = ('source = "noise"\n[volume.parameters]\nresolution = 96\nshape = "ball"\nsize = 3.4\nfrequency = 4.5\n'
                 'turbulence = 1.3\nwarp = 0.35\ncoverage = 0.62\nsoftness = 0.15\nseed = 7\n')
        return lines, [0, 0, 0], 3.4, 3.4 / 96
    info = json.loads(subprocess.run([SCRIM, "info", "--json", options.asset], check=True, capture_output=True).stdout)
    grid = info["grids"][0]
    voxel, low, high = grid["voxel_size"][0], grid["index_lower"], grid["index_upper"]
    middle = [voxel * (a + b) / 2 for a, b in zip(low, high)]
    size = voxel * max(b - a for a, b in zip(low, high))
    return f'file = "{Path(options.asset).resolve()}"\n', middle, size, voxel


def keyed(values):
    return "{ keys = [" + ", ".join(f"[{i}, {value}]" for i, value in enumerate(values, 1)) + "] }"


def vector(v):
    return "[" + ", ".join(f"{x:.9g}" for x in v) + "]"


def direction(azimuth, elevation=28):
    a, e = math.radians(azimuth), math.radians(elevation)
    return vector([math.sin(a) * math.cos(e), -math.sin(e), math.cos(a) * math.cos(e)])


def scene_of(motion, options):
    lines, middle, size, voxel = volume_of(options)
    frames = range(options.frames)

    def at(x, y, z):
        return vector([m + size * d for m, d in zip(middle, (x, y, z))])

    def around(degrees):
        a = math.radians(degrees)
        return at(1.5 * math.sin(a), 0.1, 1.5 * math.cos(a))

    position, target = around(0), at(0, 0, 0)
    if motion == "orbit":
        position = keyed(around(0.5 * i) for i in frames)
    if motion == "pan":
        position, target = (keyed(at(0.01 * i, y, z) for i in frames) for y, z in ((0.1, 1.5), (0, 0)))
    width, height = options.res.split("x")
    density = options.depth / voxel
    text = f'[camera]\nposition = {position}\ntarget = {target}\nfov = 45\nresolution = [{width}, {height}]\n'
    text += f'[[volume]]\nname = "smoke"\n{lines}[volume.density]\n'
    text += f'scale = {density}\n'
    if motion == "swelling":
        text += f'[volume.transform]\nscale = {keyed(vector([1.005 ** i] * 3) for i in frames)}\n'
    text += (f'[volume.medium]\nalbedo = [{options.albedo}, {options.albedo}, {options.albedo}]\n'
             f'phase = {{ type = "hg", g = {options.g} }}\nscattering = "{options.scattering}"\n')
    if motion in ("lamp", "within", "bare"):
        place = (-0.5, 0.3, 0.3) if motion == "lamp" else (-0.15, 0, 0)
        moving = keyed(at(place[0] + 0.01 * i, *place[1:]) for i in frames)
        text += f'[[light]]\nname = "lamp"\ntype = "point"\nposition = {moving}\nintensity = {2 * size * size}\n'
        text += f"radius = {0.03 * size if motion == 'within' else 0}\n"
    else:
        turning = AZIMUTHS.get(motion)
        sun = keyed(direction(turning + 0.5 * i) for i in frames) if turning is not None else direction(40)
        text += f'[[light]]\nname = "sun"\ntype = "distant"\ndirection = {sun}\nintensity = 10\n'
    layers = ["direct", "indirect"] if options.scattering == "full" else ["direct"]
    return text + f"[output]\nlayers = {json.dumps(layers)}\n"


def measured(motion, quality, options, work):
    scene = Path(work) / f"{motion}.toml"
    scene.write_text(scene_of(motion, options))
    run = subprocess.run([SCRIM, "study", scene, "--steady", "--frames", f"1-{options.frames}", "--quality", quality,
                          "-o", work, "--progress", "none", "-q"], capture_output=True, text=True)
    if run.returncode not in (0, 5):
        raise SystemExit(run.stderr)
    found = json.loads((Path(work) / "steady.json").read_text())
    excess = {layer["layer"]: f"{100 * layer['excess']:.3f}" for layer in found["layers"]}
    return dict(zip(COLUMNS, [motion, quality, *(excess.get(c, "") for c in COLUMNS[2:5]),
                              f"{100 * found['promised']:g}", f"{found['seconds']:.0f}"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--asset")
    parser.add_argument("--quality", action="append")
    parser.add_argument("--motion", action="append", choices=MOTIONS)
    parser.add_argument("--scattering", default="single", choices=("single", "octaves", "full"))
    parser.add_argument("--depth", type=float, default=0.2)
    parser.add_argument("--albedo", type=float, default=0.9)
    parser.add_argument("--g", type=float, default=0.3)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--res", default="192x108")
    parser.add_argument("--csv", default="steady.csv")
    options = parser.parse_args()
    print("".join(f"{c:>10}" for c in COLUMNS), flush=True)
    with tempfile.TemporaryDirectory() as work, open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for quality in options.quality or ("draft", "standard", "high"):
            for motion in options.motion or MOTIONS:
                row = measured(motion, quality, options, work)
                writer.writerow(row)
                print("".join(f"{row[c]:>10}" for c in COLUMNS), flush=True)


if __name__ == "__main__":
    main()
