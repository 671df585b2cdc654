#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What each kind of light costs, as a multiple of a sun in the same run.

    tests/tools/bench/light_prices.py [--quality P]... [--rounds N] [--verify N] [--only NAME]... [--pixels N]
                                      [--resolution N] [--out FOLDER]

Needs a build (SCRIM_BUILD names it). A plume of noise (1.6 million voxels) of 0.11 optical depth a voxel is lit by a
sun, a dome of one colour, a rectangle, a sphere beside the plume and one in it, a point in it, three of these with a
sun, and by 1, 8 and 100 plain lights. Rounds are interleaved; the time is the least of what --stats calls plan and
render, `cpu` the least processor time of the whole process (which other work on the machine disturbs less), the memory
the largest of the process. Errors are those of `--verify N` (default 400; 0: none).

Of the last lights, `plain` is the same scene without shadows: what a first, an eighth and a hundredth shadowed light
costs is their time over that.
"""
import argparse
import json
import math
import os
import subprocess
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
BIN = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin"

CAMERA = "[camera]\nposition = [2.6, 0.9, 4.1]\ntarget = [0, 0, 0]\nfov = 30\nresolution = [{0}, {0}]\n"
VOLUME = ('[[volume]]\nname = "plume"\nfile = "{}"\ndensity = {{ scale = 20 }}\n[volume.medium]\n'
          "albedo = [0.9, 0.9, 0.9]\n")
SUN = ('distant"\ndirection = [-1, -1, -0.5]', 5)
DOME = ("dome\"", 1)
RECTANGLE = ('area"\nshape = "rectangle"\nwidth = 1.3\nheight = 1.3\nposition = [2, 1.6, 1]\ntarget = [0, 0, 0]', 8)
BESIDE = ('area"\nshape = "sphere"\nradius = 0.045\nposition = [0.75, 0.2, 0.4]', 150)
INSIDE = ('area"\nshape = "sphere"\nradius = 0.045\nposition = [-0.05, 0.3, -0.08]', 60)
POINT = ('point"\nposition = [-0.05, 0.3, -0.08]', 0.4)


def suns(count):
    """Distant lights all round, evenly over the upper half of the sky and a little below."""
    lights = []
    for i in range(count):
        y = 1 - 1.3 * (i + 0.5) / count
        turn, r = 2.399963 * i, max(0, 1 - y * y) ** 0.5
        lights.append((f'distant"\ndirection = [{r * math.cos(turn):.5f}, {-y:.5f}, '
                       f'{r * math.sin(turn):.5f}]', 6 / count))
    return lights


def lamps(count):
    """Points with decay around and among the plume, on a grid."""
    lights = []
    for i in range(count):
        x, y, z = i % 5, i // 5 % 5, i // 25
        lights.append((f'point"\nposition = [{-0.8 + 0.4 * x:.3f}, {-0.9 + 0.45 * y:.3f}, {-0.6 + 0.4 * z:.3f}]',
                       6 / count))
    return lights


CASES = {"sun": [SUN], "dome": [DOME], "rectangle": [RECTANGLE], "sphere beside": [BESIDE], "sphere inside": [INSIDE],
         "point inside": [POINT], "three and a sun": [SUN, DOME, RECTANGLE, INSIDE],
         "1 light plain": [SUN], "1 light": [SUN], "8 lights plain": suns(8), "8 lights": suns(8),
         "100 lamps plain": lamps(100), "100 lamps": lamps(100)}


def scene(name, asset, pixels):
    text = CAMERA.format(pixels) + VOLUME.format(asset)
    for i, (kind, intensity) in enumerate(CASES[name]):
        shadows = "shadows = false\n" if name.endswith("plain") else ""
        text += f'[[light]]\nname = "l{i}"\ntype = "{kind}\nintensity = {intensity}\n{shadows}'
    return text


def render(path, work, quality, more=()):
    """(seconds of plan and render, of the whole process, MB, processor time, stats)."""
    stats = work / "stats.json"
    begin = time.monotonic()
    child = subprocess.Popen([str(BIN / "scrim"), "render", str(path), "-o", str(path.with_suffix(".exr")), "--quality",
                              quality, "--stats", str(stats), "-q", *more])
    _, status, usage = os.wait4(child.pid, 0)
    whole = time.monotonic() - begin
    if os.waitstatus_to_exitcode(status) not in (0, 5):
        raise RuntimeError(f"{path} failed")
    told = json.loads(stats.read_text())[0]
    seconds = told["seconds"]["plan"] + told["seconds"]["render"]
    return seconds, whole, usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime, told


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quality", action="append")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--verify", type=int, default=400)
    parser.add_argument("--only", action="append")
    parser.add_argument("--pixels", type=int, default=512)
    parser.add_argument("--resolution", type=int, default=366)
    parser.add_argument("--out", type=Path, default=Path("light_prices"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    asset = options.out.resolve() / f"plume{options.resolution}.vdb"
    if not asset.exists():
        subprocess.run([BIN / "scrim", "make", "noise", f"resolution={options.resolution}", "shape=plume", "-o", asset,
                        "-q"], check=True)
    cases = [c for c in CASES if not options.only or c in options.only or c == "sun"]
    for quality in options.quality or ["standard"]:
        found = {name: [] for name in cases}
        for name in cases:
            path = options.out / f"{name.replace(' ', '_')}.toml"
            path.write_text(scene(name, asset, options.pixels))
        for _ in range(options.rounds):
            for name in cases:
                found[name].append(render(options.out / f"{name.replace(' ', '_')}.toml", options.out, quality))
        print(f"{quality}, load {os.getloadavg()[0]:.1f}\n{'light':<18}{'s':>8}{'of a sun':>10}{'whole':>8}{'cpu':>8}"
              f"{'of a sun':>10}{'MB':>7}{'of a sun':>10}{'error %':>9}")
        sun = [min(f[i] for f in found["sun"]) for i in range(4)]
        for name in cases:
            seconds, whole = min(f[0] for f in found[name]), min(f[1] for f in found[name])
            memory, cpu, error = max(f[2] for f in found[name]), min(f[3] for f in found[name]), ""
            if options.verify > 0:
                told = render(options.out / f"{name.replace(' ', '_')}.toml", options.out, quality,
                              ["--verify", str(options.verify)])[4]
                error = f"{100 * told['verification']['error']:.2f}"
            print(f"{name:<18}{seconds:>8.3f}{seconds / sun[0]:>10.2f}{whole:>8.2f}{cpu:>8.2f}"
                  f"{cpu / sun[3]:>10.2f}{memory:>7.0f}{memory / sun[2]:>10.2f}{error:>9}", flush=True)


if __name__ == "__main__":
    main()
