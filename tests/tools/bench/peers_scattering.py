#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Light that scatters any number of times: Scrim's `full` beside path tracers with many bounces.

    tests/tools/bench/peers_scattering.py [--res N] [--samples N]... [--reference N] [--g G] [--albedo A] [--sky S]
                                          [--bounces N] [--frames N] [--csv FILE] [--jpg FILE] [ASSET]

The tools and what they need are those of peers.py; the asset is a .vdb or noise:RESOLUTION. It is lit by one sun and an
even sky of radiance --sky, in a picture of N x N pixels.

The truth is the mean of --reference samples of Mitsuba (of Cycles where there is none), rendered with two seeds. Each
picture is held against both: the mean of (picture - first)(picture - second) over means of 4 x 4 pixels is its squared
error, and the noise of the references, which do not know each other, has no part in it. `error` is its root over the
mean of the truth, with twice the standard error that the spread of these products gives. `mean` is the picture's
brightness beside that of the truth. Seconds are those of rendering alone, all processors.

With --frames the sun turns by a degree a frame. Flicker is the RMS of the second difference in time of means over 4 x 4
pixels, less that of the same frames of Scrim at `high`, over the mean. Path tracers get a new seed for each frame.

--jpg (which needs Pillow) shows Scrim at `standard`, and the path tracers with the fewest samples, side by side.
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
from peers_check import blocks, run
from peers_flicker import second_differences, turned

BLOCK = 4
COLUMNS = ["tool", "how", "seconds", "memory", "error", "uncertain", "mean", "flicker"]
HOW = {"mitsuba": ("llvm_ad_rgb", "volpath"), "cycles 3": (1,), "cycles 4": (1,), "cycles 5": (0,)}
QUALITIES = ("draft", "standard", "high")


def error_of(picture, truths):
    """Error, what it may be off by (95 %), and brightness beside the truth."""
    a, first, second = (blocks(p, BLOCK) for p in (picture, *truths))
    products, level = (a - first) * (a - second), (first.mean() + second.mean()) / 2
    square = max(products.mean(), 0)
    spread = 2 * products.std() / math.sqrt(products.size)
    error = math.sqrt(square)
    return error / level, (math.sqrt(square + spread) - error) / level, a.mean() / level - 1


def save(pictures, path):
    """The pictures side by side, as bright as the first one needs, each pixel as four."""
    from PIL import Image
    white = np.percentile(pictures[0], 99.9)
    row = np.concatenate([np.clip(p / white, 0, 1)**(1 / 2.2) for p in pictures], axis=1)
    Image.fromarray((255 * row.repeat(2, 0).repeat(2, 1)).astype(np.uint8)).save(path, quality=92)


class Scene:
    def __init__(self, options, work):
        self.options, self.work = options, work
        self.asset = peers.asset_file(options.asset, work)
        run([BIN / "scrim_peers", "scene", self.asset, work / "scene.toml", work / "pixels.txt", "1"],
            work / "made.json")
        self.numbers = json.loads((work / "made.json").read_text())
        self.numbers |= {"threads": options.threads, "resolution": [options.res] * 2, "albedo": options.albedo,
                         "g": options.g, "sky": options.sky, "bounces": options.bounces}
        self.dense = peers_tools.add_array(self.numbers, work)

    def scrim(self, quality, sun):
        options, stats = self.options, self.work / "stats.json"
        medium = {"albedo": [options.albedo] * 3, "scattering": '"full"',
                  "phase": f'{{ type = "hg", g = {options.g} }}'}
        sets = [f"volume.volume1.medium.{key}={value}" for key, value in medium.items()]
        sets += [f"camera.resolution=[{options.res}, {options.res}]", f"light.key.direction={list(sun)}",
                 f"ambient.color={[1, 1, 1]}", f"ambient.intensity={options.sky}", 'output.type="float"',
                 'output.compression="none"']
        command = [BIN / "scrim", "render", self.work / "scene.toml", "--quality", quality, "--threads",
                   str(options.threads), "-q", "--stats", stats, *(w for s in sets for w in ("--set", s)), "-o"]

        def seconds(_):
            frame = json.loads(stats.read_text())[0]["seconds"]
            return frame["plan"] + frame["render"]

        return self.measured(peers.Setting("scrim", quality, lambda picture: [*command, picture], seconds))

    def measured(self, setting):
        """A picture, the seconds of rendering it, and megabytes."""
        picture = self.work / "picture.exr"
        setting.measure(picture)
        return peers_exr.read(picture), setting.render_times[0], setting.memory[0]

    def at_random(self, tool, start, samples, sun, seed, denoise):
        file = peers_tools.write_numbers(self.numbers, self.work, "scattering", light=list(sun), seed=seed,
                                         denoise=denoise)
        return self.measured(peers.Setting(tool, "", lambda picture: peers_tools.command(
            tool, start, file, picture, samples, *HOW[tool]), peers_tools.seconds))


def settings_of(scene, tools):
    """What is measured: tool, how, and a function of the sun's direction and a seed that renders."""
    for quality in QUALITIES:
        yield "scrim", f"quality {quality}", lambda sun, _, quality=quality: scene.scrim(quality, sun)
    for tool, (start, _) in tools.items():
        for samples in scene.options.samples:
            for denoise in (False, True) if tool.startswith("cycles") else (False,):
                yield (tool, f"{samples} samples" + (", denoised" if denoise else ""),
                       lambda sun, seed, tool=tool, start=start, samples=samples, denoise=denoise: scene.at_random(
                           tool, start, samples, sun, seed, denoise))


def rows(options, work):
    scene = Scene(options, work)
    tools = {tool: how for tool, how in peers_tools.found().items()
             if tool in HOW and (scene.dense or tool != "mitsuba")}
    if not tools:
        raise SystemExit("there is no path tracer to hold Scrim against; see peers_tools.py")
    sun = scene.numbers["light"]
    teller = "mitsuba" if "mitsuba" in tools else next(iter(tools))
    truths = [scene.at_random(teller, tools[teller][0], options.reference, sun, seed, False)[0] for seed in (101, 102)]
    first, second = (blocks(t, BLOCK) for t in truths)
    print(f"truth: {teller}, twice {options.reference} samples, which differ by "
          f"{100 * np.std(first - second) / first.mean():.2f} % in means")
    suns = [turned(sun, i) for i in range(options.frames)]
    steady = [scene.scrim("high", s)[0] for s in suns] if suns else []
    shown = []
    for tool, how, render in settings_of(scene, tools):
        renders = [render(sun, seed) for seed in range(3 if tool == "scrim" else 1)]
        picture = renders[-1][0]
        if how == "quality standard" or how.startswith(f"{min(options.samples)} "):
            shown.append(picture)
        error, uncertain, mean = error_of(picture, truths)
        flicker = ""
        if suns:
            frames = [render(s, 10 + i)[0] for i, s in enumerate(suns)]
            rest = [second_differences([blocks(f, BLOCK)[..., None] for f in part]) for part in (frames, steady)]
            flicker = f"{math.sqrt(((rest[0] - rest[1])**2).mean()) / blocks(steady[0], BLOCK).mean():.5f}"
        yield dict(zip(COLUMNS, [tool, how, f"{statistics.median(r[1] for r in renders):.4g}",
                                 f"{renders[0][2]:.0f}", f"{error:.5f}", f"{uncertain:.5f}", f"{mean:.5f}", flicker]))
    if options.jpg:
        save(shown, options.jpg)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", metavar="ASSET", nargs="?", default="noise:128")
    parser.add_argument("--res", type=int, default=256)
    parser.add_argument("--samples", type=int, action="append", help="of path tracers; 64 and 256")
    parser.add_argument("--reference", type=int, default=256)
    parser.add_argument("--g", type=float, default=0.85)
    parser.add_argument("--albedo", type=float, default=0.999)
    parser.add_argument("--sky", type=float, default=0.5)
    parser.add_argument("--bounces", type=int, default=128)
    parser.add_argument("--frames", type=int, default=0)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--csv", default="peers_scattering.csv")
    parser.add_argument("--jpg")
    options = parser.parse_args()
    options.samples = options.samples or [64, 256]
    with tempfile.TemporaryDirectory() as work, open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for r in rows(options, Path(work)):
            writer.writerow(r)
            file.flush()
            print(f"{r['tool']:<10}{r['how']:<24}{r['seconds']:>9} s{100 * float(r['error']):>8.2f} +- "
                  f"{100 * float(r['uncertain']):.2f} %, mean {100 * float(r['mean']):+.2f} %  {r['flicker']}",
                  flush=True)


if __name__ == "__main__":
    main()
