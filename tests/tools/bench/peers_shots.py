#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Shots of several volumes (shots_scenes.py) in Scrim, Mitsuba and Cycles: processor time at the same error.

    tests/tools/bench/peers_shots.py [--skip TOOL]... [--width N] [--verify N] [--limit S] [--csv FILE] [SHOT...]

What it needs is said in peers_tools.py; the shots are a, b, c-10 and e. All tools render the same volumes, camera, sun
and sky, with single, isotropic scattering. Cycles adds up volumes that overlap; Mitsuba does not, and peers_media.py
says what it gets instead.

The truth is Scrim's picture at `ultra`, in e at `high`, since `ultra` takes minutes there. Brute force checks it at
--verify pixels, or as many as it gets done in --limit seconds; with a sky it gets none done. So what counts is whether
the other tools agree. For each shot there are three tables:

- whether all show the same scene, as in peers_check.py: two pictures with different seeds, held against the truth in
  means over 8 x 8 pixels, and in single pixels ("bias, pixels").
- what was measured. Error is relative RMSE against the truth, over pixels with more than a thousandth of the brightest
  one's light. Noise is that of one picture, as two seeds tell: where it is the error, there is no other.
- processor time at the same error, as peers_ratios.py has it from the table before.

Seconds are of the processor, user and system: other work on the machine stretches the clock, but hardly these. Scrim's
are those of the whole command, the least of three. Those of the others are of rendering alone, without start, loading,
compiling and writing; "command" has all that, and a picture of one sample, which is rendered before. Memory is what the
command had resident at most.
"""
import argparse
import csv
import json
import os
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import peers_exr
import peers_ratios
import peers_tools
import shots
import shots_scenes
from peers_check import BIN, BLOCK, blocks, compare

COLUMNS = ["asset", "tool", "setting", "render_seconds", "command_seconds", "memory", "error", "noise"]
AGREEMENT = ["tool", "version", "how", "samples", "mean", "bias", "noise", "bias, pixels", "noise, pixels"]
QUALITIES = ("draft", "standard", "high", "ultra")
HOW = {"mitsuba": ("llvm_ad_rgb", "volpath"), "cycles 4": (1,), "cycles 5": (0,)}
# The truth, and samples: few, and as many as a minute of the processor has, or less.
SHOTS = {"a": ("ultra", {"mitsuba": (256, 1024), "cycles": (16, 64), "cycles 5": (64, 256)}),
         "b": ("ultra", {"mitsuba": (64, 256), "cycles": (4, 16), "cycles 5": (32, 128)}),
         "c-10": ("ultra", {"mitsuba": (64, 256), "cycles": (16, 64), "cycles 5": (32, 128)}),
         "e": ("high", {"mitsuba": (16, 64), "cycles": (2, 8), "cycles 5": (16, 64)})}


class Shot:
    """A scene for Scrim, the same in numbers for the others, and the truth."""

    def __init__(self, name, work, options):
        self.name, self.work, self.options = name, work, options
        self.best, self.samples = SHOTS[name]
        shot = shots_scenes.SHOTS[name](shots_scenes.Assets(BIN / "scrim", work))
        self.scene = work / f"{name}.toml"
        self.scene.write_text(shot.view + "\n" + "".join(v.text for v in shot.volumes))
        self.numbers = self.in_numbers(tomllib.loads(self.scene.read_text()))
        if options.width:
            width, height = self.numbers["resolution"]
            self.numbers["resolution"] = [options.width, round(height * options.width / width)]
        self.truth, self.brute = self.best_picture()
        self.shown = self.truth.max(-1) > 1e-3 * self.truth.max()

    def best_picture(self):
        """The truth, and in words what brute force says of it."""
        if self.numbers["sky"] or not self.options.verify:
            return self.scrim(self.best)[0], ""
        image, _ = self.scrim(self.best, "--verify", self.options.verify, "--verify-limit", self.options.limit)
        found = json.loads((self.work / "stats.json").read_text())[0]["verification"]
        if not found["pixels"]:
            return image, f", not checked: brute force was done with no pixel in {self.options.limit:g} s"
        return image, f", {100 * found['error']:.2g} % off brute force at {found['pixels']} pixels"

    def in_numbers(self, scene):
        camera, lights = scene["camera"], {light["type"]: light for light in scene["light"]}
        look = np.subtract(camera["target"], camera["position"])
        sun, grids, volumes = np.array(lights["distant"]["direction"]), {}, []
        for volume in scene["volume"]:
            file, place = volume["file"], volume["transform"]
            if file not in grids:
                grids[file] = {"asset": file, "grid": "density"}
                if not peers_tools.add_array(grids[file], self.work):
                    raise SystemExit("there is no module 'pyopenvdb' (Debian package python3-openvdb)")
            volumes.append(grids[file] | {"scale": volume["density"]["scale"], "translate": place["translate"],
                                          "size": place["scale"][0]})
        return {"volumes": volumes, "eye": camera["position"], "look": (look / np.linalg.norm(look)).tolist(),
                "fov": camera["fov"], "resolution": camera["resolution"], "albedo": 0.9,
                "light": (sun / np.linalg.norm(sun)).tolist(), "irradiance": lights["distant"]["intensity"],
                "sky": lights["dome"]["intensity"] if "dome" in lights else 0, "threads": self.options.threads}

    def rendered(self, command, picture):
        """A picture, what its command cost, and its log."""
        log = self.work / "log"
        cost = shots.run(command, log, self.options.timeout)
        if cost.failure:
            raise SystemExit(f"{' '.join(map(str, command))}: {cost.failure}")
        return peers_exr.read(picture), cost, log.read_text()

    def scrim(self, quality, *more):
        """A picture, and what the command cost."""
        picture = self.work / "picture.exr"
        command = [BIN / "scrim", "render", self.scene, "-o", picture, "--quality", quality, "-q", "--threads",
                   self.options.threads, "--stats", self.work / "stats.json", "--set", 'output.compression="none"',
                   "--set", 'output.type="float"', "--set", f"camera.resolution={self.numbers['resolution']}", *more]
        return self.rendered(command, picture)[:2]

    def at_random(self, tool, start, samples, seed):
        """A picture, the processor seconds of rendering it, and what the command cost."""
        picture = self.work / "picture.exr"
        file = peers_tools.write_numbers(self.numbers, self.work, "shot", seed=seed)
        image, cost, log = self.rendered(peers_tools.command(tool, start, file, picture, samples, *HOW[tool]), picture)
        return image, peers_tools.seconds(log, "processor"), cost

    def error(self, pictures):
        """The error of a picture, and the noise of one; "" where there is but one."""
        shown, truth = [p[self.shown].astype(float) for p in pictures], self.truth[self.shown]
        level = truth.mean()
        noise = np.sqrt(((shown[0] - shown[1])**2).mean() / 2) / level if len(shown) > 1 else ""
        return np.sqrt(np.mean([(p - truth)**2 for p in shown])) / level, noise


def of_scrim(shot):
    """Rows of COLUMNS."""
    for quality in QUALITIES[:QUALITIES.index(shot.best)]:
        pictures, costs = zip(*(shot.scrim(quality) for _ in range(3)))
        seconds = min(c.processor for c in costs)
        row = (shot.name, "scrim", f"quality {quality}", seconds, seconds, costs[0].memory, *shot.error(pictures[:1]))
        yield dict(zip(COLUMNS, row))


def of_others(shot, tools):
    """Rows of COLUMNS, each with one of the table of agreement."""
    for tool, (start, version) in tools.items():
        way = peers_tools.describe(tool, HOW[tool])
        for samples in shot.samples.get(tool) or shot.samples[tool.split()[0]]:
            pictures, seconds, costs = zip(*(shot.at_random(tool, start, samples, seed) for seed in (1, 2)))
            row = (shot.name, tool, f"samples {samples} {way}", min(seconds), min(c.processor for c in costs),
                   costs[0].memory, *shot.error(pictures))
            pixels, true = ([image[shot.shown][None] for image in images] for images in (pictures, [shot.truth]))
            agreement = dict(zip(AGREEMENT, (tool, version, way, samples, *compare(pictures, blocks(shot.truth)),
                                             *compare(pixels, blocks(true[0], 1), 1)[1:])))
            yield dict(zip(COLUMNS, row)), agreement


def print_agreement(shot, rows):
    width, height = shot.numbers["resolution"]
    print(f"## {shot.name}: {width} x {height} pixels, {len(shot.numbers['volumes'])} volumes\n\nThe truth: scrim, "
          f"quality {shot.best}{shot.brute}.\n")
    print(f"| tool | samples | mean brightness | bias, {BLOCK} x {BLOCK} | noise | bias, pixels | noise |\n"
          + 7 * "| --- " + "|")
    for r in rows:
        print(f"| {r['tool']} ({r['version']}), {r['how']} | {r['samples']} | {100 * r['mean']:+.2f} % |"
              + "".join(f" {100 * r[c]:.1f} % |" for c in AGREEMENT[5:]))


def print_rows(rows):
    print("\n| tool | processor s | command | MB | error | noise |\n" + 6 * "| --- " + "|")
    for r in rows:
        noise = f"{100 * r['noise']:.2g} %" if r["noise"] != "" else ""
        print(f"| {r['tool']}, {r['setting']} | {r['render_seconds']:.2g} | {r['command_seconds']:.2g} "
              f"| {r['memory']:.0f} | {100 * r['error']:.2g} % | {noise} |")


def report(shot, tools):
    """Prints the tables of a shot; rows of COLUMNS."""
    others = list(of_others(shot, tools))
    rows, agreement = [*of_scrim(shot), *(row for row, _ in others)], [agrees for _, agrees in others]
    print_agreement(shot, agreement)
    print_rows(rows)
    peers_ratios.table(rows, {})  # no bias is held against a tool: it may be the truth's own
    print(flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("shots", nargs="*", metavar="SHOT", help=", ".join(SHOTS))
    add("--skip", action="append", default=[], metavar="TOOL", help="mitsuba, cycles, 'cycles 4'")
    add("--width", type=int, help="of pictures, in place of that of each shot")
    add("--verify", type=int, default=100, help="pixels of ultra that are held against brute force")
    add("--limit", type=float, default=20, help="seconds of that")
    add("--timeout", type=float, default=900, help="seconds of a command")
    add("--threads", type=int, default=os.cpu_count())
    add("--csv", default="peers_shots.csv")
    options = parser.parse_args()
    unknown = [s for s in options.shots if s not in SHOTS]
    if unknown:
        parser.error(f"no shot {unknown[0]!r}; there is {', '.join(SHOTS)}")
    found = peers_tools.found()
    peers_tools.say_missing(found, ("mitsuba", "cycles"))
    tools = {tool: how for tool, how in found.items()
             if tool in HOW and not {tool, tool.split()[0]} & set(options.skip)}
    with tempfile.TemporaryDirectory() as work, open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for name in options.shots or SHOTS:
            writer.writerows(report(Shot(name, Path(work), options), tools))
            file.flush()


if __name__ == "__main__":
    main()
