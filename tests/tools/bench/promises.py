#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Do presets keep what they promise? Error and time of each, in scenes by lot.

    tests/tools/bench/promises.py SEED [--scenes N] [--first I] [--preset P]... [--pixels N] [--limit SECONDS]
                                  [--extended] [--ax] [--scans] [--scattering] [--out FOLDER]

Draws N scenes (promises_scenes.py): noise, primitives, .vdb volumes and classified scans of $SCRIM_DATA (without it:
sources alone), thin to nearly opaque in a voxel, voxels of a fraction of a pixel to many, one to four shadowed lights
all round. Each is written to FOLDER as a scene of its own. Needs a build (SCRIM_BUILD names it).

A preset promises an error (relative RMSE against brute force): draft 3 %, standard 1 %, high 0.3 %, ultra 0.1 %; of
classified volumes 5, 2, 1 and 0.5 %. The reference is evaluated once a scene, at the pixels that
`scrim render --verify` would choose, in at most --limit seconds; all settings are held against it. Time is what --stats
calls plan and render, the least of three renders (of one, where that takes --slow seconds).

What time the error would have needed is found by a search: texels from coarse to fine, with sheets of one, two and
three texels, until the finest promise is met. `best` is the least time of a setting, presets included, that keeps the
promise; `equal` that of one with the preset's own error. A promise is kept where the error is no more than that, and
certainly broken where the whole 95 % interval is above; scenes in between need more --pixels.

With --scattering the scenes are smoke in which light scatters more than once (draw_scattering), the truth is the path
tracer's, its variance taken out, and what is promised is an error of means over 4 x 4 pixels: 5, 2, 1 and 0.5 %. There
is no search then, and no grain.

Of `standard` the grain is measured, too: the difference to a much finer rendering (texel 0.2, sheets 0.4) of 96 x 96
pixels, less its mean over 5 x 5, as RMS over the mean; no more than 0.3 % is promised.

FOLDER gets promises.csv, promises.svg and the scenes. A scene that fails is listed, and the others go on.
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import promises_plot
import promises_scenes

HERE = Path(__file__).resolve().parent
BIN = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin"
PROMISES = {"draft": (0.03, 0.05), "standard": (0.01, 0.02), "high": (0.003, 0.01), "ultra": (0.001, 0.005)}
DARK = 1e-5  # the least radiance that half floats keep to a part in a hundred
SCATTERING = {"draft": 0.05, "standard": 0.02, "high": 0.01, "ultra": 0.005}
GRAIN = 0.003  # of the mean, promised of `standard`
TEXELS = (2, 1.4, 1, 0.7, 0.5, 0.35, 0.25, 0.18, 0.13)  # voxels
SHEETS = (2, 1, 3)  # texels
FINEST = ("render.texel=0.2", "render.sheet_thickness=0.4", "render.footprint_steps=16")
COLUMNS = ["scene", "asset", "voxels", "classified", "opacity", "pixels_per_voxel", "lights", "edge", "preset",
           "promise", "error", "lower", "upper", "seconds", "best_seconds", "best_setting", "equal_seconds",
           "equal_setting", "grain", "reference_pixels", "problem"]


def run(*command, limit=None):
    """Stdout; a RuntimeError with the last line of stderr where it fails."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          timeout=limit)
    if done.returncode != 0:
        raise RuntimeError((done.stderr.strip() or f"{command[0]}: exit status {done.returncode}").splitlines()[-1])
    return done.stdout


class Measure:
    """Renders one scene at settings and holds them against its reference."""

    def __init__(self, scene, options):
        self.scene, self.options = scene, options
        self.work = scene.with_suffix("")
        self.work.mkdir(exist_ok=True)
        self.pixels = self.work / "pixels.csv"
        run(BIN / "scrim_peers", "pixels", scene, self.pixels, options.pixels, options.limit)
        lines = self.pixels.read_text().splitlines()
        self.count = len(lines)
        # Half floats end at 6e-8: of a lamp behind an optical depth of 20 a picture keeps nothing.
        most = max((float(value) for line in lines for value in line.split()[2:5]), default=0)
        if most < DARK:
            raise RuntimeError(f"nothing is to be seen: no pixel of the reference is brighter than {most:.1g}")

    def render(self, name, arguments, repeats):
        """(seconds, error, lower, upper) of the picture NAME.exr."""
        picture, stats, seconds = self.work / f"{name}.exr", self.work / "stats.json", []
        for _ in range(repeats):
            run(BIN / "scrim", "render", self.scene, "-o", picture, "--stats", stats, "--threads",
                self.options.threads, "-q", *arguments)
            spent = json.loads(stats.read_text())[0]["seconds"]
            seconds.append(spent["plan"] + spent["render"])
            if seconds[0] > self.options.slow:
                break
        error, lower, upper = map(float, run(BIN / "scrim_peers", "error", self.pixels, picture).split()[:3])
        return min(seconds), error, lower, upper

    def dials(self, texel, sheets, repeats=1):
        values = (f"render.texel={texel}", f"render.sheet_thickness={sheets:g}",
                  f"render.footprint_steps={8 if texel >= 0.5 else 16}")
        return self.render("dials", [word for value in values for word in ("--set", value)], repeats)

    def search(self, finest):
        """{setting: (seconds, error)}, texels down to where `finest` is met or time is up."""
        found = {}
        for ratio in SHEETS:
            for texel in TEXELS:
                sheets = ratio * texel
                seconds, error, *_ = self.dials(texel, sheets)
                if seconds < 0.5:
                    seconds = min(seconds, self.dials(texel, sheets)[0])
                found[f"texel {texel:g} sheets {sheets:g}"] = (seconds, error)
                if error <= finest or seconds > self.options.slow:
                    break
        return found

    def grain(self, edge):
        """Of `standard`, in the middle of what the reference looked at."""
        crop = 96 if edge >= 96 else edge
        places = sorted(tuple(map(int, line.split()[:2])) for line in self.pixels.read_text().splitlines())
        x, y = (max(0, min(edge - crop, int(statistics.median(p[a] for p in places)) - crop // 2)) for a in (0, 1))
        truth = self.work / "truth.exr"
        run(BIN / "scrim", "render", self.scene, "-o", truth, "--crop", f"{x},{y},{x + crop},{y + crop}", "-q",
            *(word for value in FINEST for word in ("--set", value)), limit=max(60, 4 * self.options.limit))
        return float(run(BIN / "scrim_peers", "grain", self.work / "standard.exr", truth, 5))


def least(settings, error):
    """(seconds, setting) of the fastest that is no worse than `error`."""
    good = [(seconds, name) for name, (seconds, e) in settings.items() if e <= error]
    return min(good) if good else (None, "")


def measure_scene(index, options, folder):
    """Rows of COLUMNS, one a preset."""
    if options.scans:
        asset, facts, text = promises_scenes.draw_scan(index, BIN / "scrim", folder / "assets")
    elif options.scattering:
        asset, facts, text = promises_scenes.draw_scattering(options.seed, index, BIN / "scrim", folder / "assets")
    else:
        asset, facts, text = promises_scenes.draw(options.seed, index, BIN / "scrim", folder / "assets",
                                                  options.extended, options.ax)
    scene = folder / f"{options.seed}-{index:03}.toml"
    scene.write_text(f"# {asset.label}\n{text}")
    measure = Measure(scene, options)
    promise = {p: SCATTERING[p] if options.scattering else PROMISES[p][1 if asset.classified else 0]
               for p in options.preset}
    presets = {p: measure.render(p, ["--quality", p], 1 if options.scattering else 3) for p in options.preset}
    settings = measure.search(min(promise.values())) if options.search else {}
    settings.update({f"quality {p}": presets[p][:2] for p in presets})
    for preset, (seconds, error, lower, upper) in presets.items():
        best, best_setting = least(settings, promise[preset])
        equal, equal_setting = least(settings, error)
        problem = grain = ""
        if preset == "standard" and not options.scattering:
            try:
                grain = measure.grain(facts["edge"])
            except (RuntimeError, subprocess.TimeoutExpired) as failure:
                problem = f"grain: {failure}"
        yield {"scene": scene.name, "asset": asset.label, "voxels": asset.voxels, "classified": int(asset.classified),
               **facts, "preset": preset, "promise": promise[preset], "error": error, "lower": lower, "upper": upper,
               "seconds": seconds, "best_seconds": best, "best_setting": best_setting, "equal_seconds": equal,
               "equal_setting": equal_setting, "grain": grain, "reference_pixels": measure.count, "problem": problem}


def quantile(values, part):
    return sorted(values)[min(len(values) - 1, int(part * len(values)))] if values else float("nan")


def broken(row):
    """Certainly: the whole interval lies above the promise."""
    return row["lower"] > row["promise"]


def print_scene(rows, seconds):
    first = rows[0]
    print(f"{first['scene']}: {first['asset']}, {first['voxels']} voxels of {first['pixels_per_voxel']:.2g} pixels, "
          f"optical depth up to {first['opacity']:.2g} a voxel, {first['lights']} lights, "
          f"{first['reference_pixels']} reference pixels ({seconds:.0f} s)")
    for r in rows:
        best = f"{r['best_seconds']:.3f} s ({r['best_setting']})" if r["best_seconds"] else "none that was tried"
        equal = f"{r['seconds'] / r['equal_seconds']:.2f}" if r["equal_seconds"] else "-"
        grain = f", grain {100 * r['grain']:.2f} %" if r["grain"] != "" else ""
        grain += f" ({r['problem']})" if r["problem"] else ""
        mark = "BROKEN" if broken(r) else "kept  " if r["upper"] <= r["promise"] else "unsure"
        print(f"  {r['preset']:<9}{100 * r['promise']:>5.1f} % {mark}{100 * r['error']:>8.3f} % "
              f"({100 * r['lower']:.3f} to {100 * r['upper']:.3f}) {r['seconds']:>8.3f} s; best {best}; "
              f"time/equal {equal}{grain}")
    sys.stdout.flush()


def print_summary(rows, failed):
    print(f"\n{'preset':<10}{'scenes':>7}{'kept':>7}{'broken':>8}{'worst error/promise':>21}"
          f"{'time/best: median':>19}{'90 %':>7}{'time/equal: median':>20}{'90 %':>7}{'grain kept':>12}")
    for preset in dict.fromkeys(r["preset"] for r in rows):
        of = [r for r in rows if r["preset"] == preset]
        best = [r["seconds"] / r["best_seconds"] for r in of if r["best_seconds"]]
        equal = [r["seconds"] / r["equal_seconds"] for r in of if r["equal_seconds"]]
        grains = [r["grain"] for r in of if r["grain"] != ""]
        kept = f"{sum(g <= GRAIN for g in grains)} of {len(grains)}" if grains else ""
        print(f"{preset:<10}{len(of):>7}{100 * sum(r['error'] <= r['promise'] for r in of) / len(of):>6.0f}%"
              f"{100 * sum(map(broken, of)) / len(of):>7.0f}%"
              f"{max(r['error'] / r['promise'] for r in of):>21.2f}{quantile(best, 0.5):>19.2f}"
              f"{quantile(best, 0.9):>7.2f}{quantile(equal, 0.5):>20.2f}{quantile(equal, 0.9):>7.2f}{kept:>12}")
    for index, reason in failed:
        print(f"scene {index} failed: {reason}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", type=int)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--preset", action="append", choices=PROMISES, help="all of them, if none is named")
    parser.add_argument("--pixels", type=int, default=150, help="of the reference that count")
    parser.add_argument("--limit", type=float, default=60, help="seconds for the reference of a scene")
    parser.add_argument("--slow", type=float, default=8, help="seconds of a setting after which no finer one is tried")
    parser.add_argument("--no-search", dest="search", action="store_false", help="presets alone")
    parser.add_argument("--extended", action="store_true", help="skies, surfaces and lamps in the smoke instead of suns")
    parser.add_argument("--scattering", action="store_true", help="smoke in which light scatters more than once")
    parser.add_argument("--ax", action="store_true", help="volumes that expressions make, and no others")
    parser.add_argument("--scans", action="store_true", help="ten surfaces from three sides; not by lot")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("promises"))
    options = parser.parse_args()
    options.preset = options.preset or list(PROMISES)
    options.search = options.search and not options.scattering
    (options.out / "assets").mkdir(parents=True, exist_ok=True)
    folder, rows, failed = options.out.resolve(), [], []
    with open(folder / "promises.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for index in range(options.first, options.first + options.scenes):
            begin = time.monotonic()
            try:
                of_scene = list(measure_scene(index, options, folder))
            except Exception as failure:  # the lot may find any fault of any part: it is listed, the others go on
                failed.append((index, str(failure)))
                print(f"scene {index} failed: {failure}", flush=True)
                writer.writerow({"scene": f"{options.seed}-{index:03}.toml", "problem": failure})
                continue
            rows += of_scene
            writer.writerows(of_scene)
            file.flush()
            print_scene(of_scene, time.monotonic() - begin)
    if rows:
        print_summary(rows, failed)
        promises_plot.plot(rows, folder / "promises.svg")


if __name__ == "__main__":
    main()
