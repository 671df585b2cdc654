#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What is restless from frame to frame: a still volume under a sun that turns slowly, then under one that stands.

    tests/tools/bench/peers_flicker.py [--frames N] [--res N] [--degrees D] [--skip TOOL]... [--csv FILE] [ASSET]

Tools and what they need are those of peers.py; the asset is a .vdb or noise:RESOLUTION (noise:128). In each frame the
sun has turned by --degrees about the picture's up. Those that draw at random get a new seed for each frame, as
animations do: with one seed for all, noise stands still like dirt on the lens while the volume moves behind it.

Flicker is the RMS of I(t-1) - 2 I(t) + I(t+1), less that of the same frames of Scrim at quality ultra, pixel by pixel,
over the mean of those: over all pixels that show something in any of the frames, and all frames but the first and last.
A picture whose error moves along with the light has little of it, noise of a standard deviation s has 2.4 s. `same`
tells whether all frames are equal to the bit. Seconds are a frame's of rendering alone, the median.
"""
import argparse
import csv
import json
import math
import os
import statistics
import tempfile
from pathlib import Path

import numpy as np
import peers
import peers_exr
import peers_tools
from peers import BIN
from peers_check import run

COLUMNS = ["sun", "tool", "how", "flicker", "same", "seconds"]
RANDOM = {"mitsuba": [(("llvm_ad_rgb", "volpath"), (1, 16))], "luxcore": [((1,), (1,))],
          "cycles 3": [((1,), (1, 16))], "cycles 4": [((1,), (1, 16))], "cycles 5": [((0,), (1, 16))]}


def turned(direction, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = direction
    return [c * x + s * z, y, c * z - s * x]


def scrim(work, quality, suns, options):
    """Pictures and seconds of all frames. The light has a key at each, so no time between keys counts."""
    text, keys = (work / "scene.toml").read_text(), [[i, sun] for i, sun in enumerate(suns, 1)]
    head, tail = text.rsplit("direction = ", 1)
    scene = work / "keyed.toml"
    scene.write_text(f"{head}direction = {{ keys = {keys} }}\n{tail.split(chr(10), 1)[1]}"
                     "[output]\ntype = \"float\"\ncompression = \"none\"\n")
    run([BIN / "scrim", "render", scene, "-o", work / "scrim.####.exr", "--frames", f"1-{len(suns)}", "--quality",
         quality, "--set", f"camera.resolution=[{options.res}, {options.res}]", "--threads", str(options.threads), "-q",
         "--stats", work / "stats.json"], work / "log")
    frames = json.loads((work / "stats.json").read_text())
    return ([peers_exr.read(work / f"scrim.{i:04}.exr") for i in range(1, len(suns) + 1)],
            [f["seconds"]["plan"] + f["seconds"]["render"] for f in frames])


def one_by_one(work, suns, command, seconds):
    """As `scrim`, of a tool that is started for each frame: `command(i, sun, picture)`."""
    pictures, times = [], []
    for i, sun in enumerate(suns):
        run(command(i, sun, work / "frame.exr"), work / "log")
        times.append(seconds((work / "log").read_text()))
        pictures.append(peers_exr.read(work / "frame.exr"))
    return pictures, times


def vdb_render(work, numbers, suns, options):
    def command(_, sun, picture):
        chosen = list(peers.vdb_render_settings(numbers | {"light": sun}, options.threads))[1]
        return [*chosen.command(picture), "-compression", "none"]

    first = list(peers.vdb_render_settings(numbers, options.threads))[1]
    return first.label, one_by_one(work, suns, command, first.render_seconds)


def at_random(work, numbers, suns, tool, start, how, samples):
    def command(i, sun, picture):
        file = peers_tools.write_numbers(numbers, work, "frame", light=sun, seed=i)
        return peers_tools.command(tool, start, file, picture, samples, *how)

    return one_by_one(work, suns, command, peers_tools.seconds)


def second_differences(pictures):
    frames = np.stack([p.mean(-1) for p in pictures]).astype(np.float64)
    return frames[:-2] - 2 * frames[1:-1] + frames[2:]


def rows(options, work):
    vdb = peers.asset_file(options.asset, work)
    run([BIN / "scrim_peers", "scene", vdb, work / "scene.toml", work / "pixels.txt", "1"], work / "made.json")
    numbers = json.loads((work / "made.json").read_text())
    numbers |= {"threads": options.threads, "resolution": [options.res] * 2}
    dense = peers_tools.add_array(numbers, work)
    found = peers_tools.found()
    peers_tools.say_missing(found)
    for sun, degrees in (("turns", options.degrees), ("stands", 0)):
        count = options.frames if degrees else 4  # what stands needs no more
        suns = [turned(numbers["light"], degrees * i) for i in range(count)]
        truth, _ = scrim(work, "ultra", suns, options)
        shown = np.max([p.mean(-1) for p in truth], axis=0) > 1e-6
        mean = float(np.mean([p.mean(-1)[shown] for p in truth]))

        def row(tool, how, result):
            pictures, times = result
            rest = (second_differences(pictures) - second_differences(truth))[:, shown]
            same = all(np.array_equal(p, pictures[0]) for p in pictures)
            return dict(zip(COLUMNS, [sun, tool, how, f"{math.sqrt((rest**2).mean()) / mean:.6g}",
                                      "yes" if same else "no", f"{statistics.median(times):.4g}"]))

        for quality in ("draft", "standard"):
            yield row("scrim", f"quality {quality}", scrim(work, quality, suns, options))
        if "vdb_render" not in options.skip and peers.shutil.which("vdb_render"):
            yield row("vdb_render", *vdb_render(work, numbers, suns, options))
        for tool, (start, _) in found.items():
            if {tool, tool.split()[0]} & set(options.skip) or (tool in ("mitsuba", "luxcore") and not dense):
                continue
            for how, counts in RANDOM.get(tool, [((1,), (1, 16))]):
                for samples in counts if sun == "turns" else counts[:1]:
                    yield row(tool, f"samples {samples} {peers_tools.describe(tool, how)}",
                              at_random(work, numbers, suns, tool, start, how, samples))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", metavar="ASSET", nargs="?", default="noise:128")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--res", type=int, default=256)
    parser.add_argument("--degrees", type=float, default=1)
    parser.add_argument("--skip", action="append", default=[], metavar="TOOL")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--csv", default="peers_flicker.csv")
    options = parser.parse_args()
    print(f"{'sun':<8}{'tool':<12}{'how':<40}{'flicker %':>10}{'same':>6}{'seconds':>10}", flush=True)
    with tempfile.TemporaryDirectory() as work, open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for r in rows(options, Path(work)):
            writer.writerow(r)
            print(f"{r['sun']:<8}{r['tool']:<12}{r['how']:<40}{100 * float(r['flicker']):>10.3f}{r['same']:>6}"
                  f"{r['seconds']:>10}", flush=True)


if __name__ == "__main__":
    main()
