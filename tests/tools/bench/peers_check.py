#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the tools of peers.py that draw at random render the same scene as Scrim: what is left when noise is gone.

    tests/tools/bench/peers_check.py [--csv FILE] [--res N] [--only TOOL]... [--samples N] ASSET

A factor, a shift of half a voxel or a step that is too long would be hidden by noise of some 10 %, so each tool renders
the scene twice, with two seeds. Compared are means over 8 x 8 pixels with those of Scrim at quality ultra (whose own
error is below 0.1 %, see --verify):

- mean: how much brighter the whole picture is;
- bias: the root of the mean product of both pictures' differences to Scrim, over the mean of the picture. Noise of two
  seeds has no product in the mean, so it is what the two have in common: an error that more samples do not lower. It is
  known but for `noise`, of the same kind: what the product of two independent noises may still be (two sigmas).
"""
import argparse
import csv
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import peers_exr
import peers_tools
from peers_tools import HERE

BIN = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin"
BLOCK = 8
COLUMNS = ["tool", "version", "how", "samples", "mean", "bias", "noise"]
# What is asked of each; how, and how many samples.
SETTINGS = {"mitsuba": [(("llvm_ad_rgb", "volpath"), 64)], "luxcore": [((1,), 32), ((4,), 32)],
            "cycles 3": [((1,), 32)], "cycles 4": [((1,), 32), ((0.5,), 32)],
            "cycles 5": [((0,), 16), ((0,), 64), ((1,), 32)]}


def blocks(image, edge=BLOCK):
    height, width = (n // edge for n in image.shape[:2])
    return image[:height * edge, :width * edge].reshape(height, edge, width, edge, 3).mean((1, 3, 4)).astype(float)


def compare(pictures, truth, edge=BLOCK):
    a, b = (blocks(p, edge) - truth for p in pictures)
    product, level = a * b, truth.mean()
    noise = math.sqrt(2 * (a - b).var() / 2 / math.sqrt(a.size)) / level
    return (a + b).mean() / 2 / level, math.sqrt(max(0.0, product.mean())) / level, noise


def run(command, log):
    with open(log, "w") as out:
        if subprocess.run(command, stdout=out, stderr=subprocess.STDOUT).returncode:
            raise SystemExit(f"{command} failed:\n{Path(log).read_text()[-2000:]}")


def rows(options, work):
    run([BIN / "scrim_peers", "scene", options.asset, work / "scene.toml", work / "pixels.txt", "1"],
        work / "made.json")
    numbers = json.loads((work / "made.json").read_text()) | {"threads": os.cpu_count()}
    numbers["resolution"] = [options.res] * 2
    dense = peers_tools.add_array(numbers, work)
    run([BIN / "scrim", "render", work / "scene.toml", "-o", work / "truth.exr", "--quality", "ultra", "-q", "--set",
         f"camera.resolution=[{options.res}, {options.res}]", "--set", "output.compression=\"none\"", "--set",
         "output.type=\"float\""], work / "log")
    truth = blocks(peers_exr.read(work / "truth.exr"))
    tools = peers_tools.found()
    peers_tools.say_missing(tools)
    for tool, (start, version) in tools.items():
        if (options.only and tool not in options.only) or (tool in ("mitsuba", "luxcore") and not dense):
            continue
        for how, samples in SETTINGS.get(tool, [((1,), 32)]):
            samples = options.samples or samples
            pictures = [work / f"{seed}.exr" for seed in (1, 2)]
            for seed, picture in enumerate(pictures, 1):
                file = peers_tools.write_numbers(numbers, work, "check", seed=seed, twice=False)
                run(peers_tools.command(tool, start, file, picture, samples, *how), work / "log")
            mean, bias, noise = compare([peers_exr.read(p) for p in pictures], truth)
            yield dict(zip(COLUMNS, [tool, version, peers_tools.describe(tool, how), samples, f"{mean:.5f}",
                                     f"{bias:.5f}", f"{noise:.5f}"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", metavar="ASSET", help="a .vdb")
    parser.add_argument("--csv", default="peers_check.csv")
    parser.add_argument("--res", type=int, default=512)
    parser.add_argument("--samples", type=int, help="in place of those of each tool")
    parser.add_argument("--only", action="append", default=[], metavar="TOOL")
    options = parser.parse_args()
    print(f"{'tool':<10}{'version':<10}{'how':<22}{'samples':>8}{'mean %':>9}{'bias %':>9}{'noise %':>9}", flush=True)
    with tempfile.TemporaryDirectory() as work, open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for r in rows(options, Path(work)):
            writer.writerow(r)
            print(f"{r['tool']:<10}{r['version']:<10}{r['how']:<22}{r['samples']:>8}" +
                  "".join(f"{100 * float(r[c]):>9.2f}" for c in COLUMNS[4:]), flush=True)


if __name__ == "__main__":
    main()
