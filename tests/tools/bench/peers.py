#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Error against time: Scrim beside other renderers, on the same scene, against the same brute-force reference.

    tests/tools/bench/peers.py [--rounds N] [--pixels N] [--skip TOOL]... [--csv FILE] [--svg FILE] [ASSET]...

An ASSET is a .vdb or noise:RESOLUTION (the default is noise:350). Needs a build (SCRIM_BUILD names it), vdb_render
(Debian: libopenvdb-tools), and for Mitsuba, LuxCore and Cycles what peers_tools.py says; what is not there is skipped
with a line that says so. Writes a table to stdout, peers.csv, and with --svg a plot of it. peers_check.py tells whether
those that draw at random render the same scene, peers_ratios.py at what time each has the same error.

All tools render 512 x 512 pixels of one volume with single, isotropic scattering under one distant light, on all
processors. All settings are measured in turn, round after round, so that a machine whose speed drifts favours none;
medians count. Settings that take longer than --slow seconds are measured once. cpu_seconds of the CSV are those of the
whole process, on all processors: where others kept the machine busy, they are less than they could be.

Two times stand in the table. `process` is that of the whole program, from its start over loading to the written
picture. `render` is what each tool itself says that rendering took, without start, loading and writing: Scrim's
statistics (plan and render), the seconds between ray-tracing and its end that vdb_render -v prints, and the time that
Mitsuba, LuxCore and Cycles take for a picture whose scene is loaded, and whose code is compiled (no process time: they
have rendered for the compiler, too). The dense marchers exist for this comparison only: the scaffold around them is no
product, so only their render times count (to copy the grid into a dense array counts as loading), and they have no
process time. There are three: with a shadow ray from every sample; with a light volume filled by such rays; and with
one filled by a sweep of planes along the axis that the sun is nearest to (sweep_marcher.h), with vectors, in cells of
one voxel or more and with bilinear or cubic look-ups. peers_suns.py compares the last one to Scrim under other suns.
"""
import argparse
import csv
import json
import math
import os
import re
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import peers_plot
import peers_tools

HERE = Path(__file__).resolve().parent
BIN = Path(os.environ.get("SCRIM_BUILD", HERE.parents[2] / "build")) / "bin"
COLUMNS = ["asset", "voxels", "tool", "setting", "error", "lower", "upper", "bias", "process_seconds", "render_seconds",
           "cpu_seconds", "memory_mb", "rounds"]


class Setting:
    """One tool at one setting: its command, how to read its render time, and what was measured."""

    def __init__(self, tool, label, command, render_seconds, process=True):
        self.tool, self.label, self.command, self.render_seconds = tool, label, command, render_seconds
        self.process = process  # whether the time of the whole program says anything
        self.process_times, self.render_times, self.cpu_times, self.memory = [], [], [], []

    def measure(self, picture):
        log = picture.with_suffix(".log")
        with open(log, "w") as out:
            begin = time.monotonic()
            child = subprocess.Popen([*self.command(picture)], stdout=out, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(child.pid, 0)
            seconds = time.monotonic() - begin
        child.returncode = os.waitstatus_to_exitcode(status)
        text = log.read_text()
        if child.returncode != 0 or not picture.exists():
            raise SystemExit(f"{self.tool} ({self.label}) failed:\n{text[-2000:]}")
        self.process_times.append(seconds)
        self.render_times.append(self.render_seconds(text))
        self.cpu_times.append(usage.ru_utime + usage.ru_stime)
        self.memory.append(usage.ru_maxrss / 1024)  # of the largest process, its children included


def scrim_settings(work, threads):
    stats = work / "stats.json"

    def seconds(_):
        frame = json.loads(stats.read_text())[0]["seconds"]
        return frame["plan"] + frame["render"]

    def setting(label, *options):
        return Setting("scrim", label,
                       lambda picture: [BIN / "scrim", "render", work / "scene.toml", "-o", picture, "--stats", stats,
                                        "--threads", str(threads), "-q", *options], seconds)

    for quality in ("draft", "standard", "high", "ultra"):
        yield setting(f"quality {quality}", "--quality", quality)
    for texel, sheets in ((1.4, 3), (1, 3), (1, 2), (0.7, 2), (0.5, 1.5), (0.5, 1), (0.35, 1), (0.25, 1), (0.25, 0.5)):
        yield setting(f"texel {texel} sheets {sheets}", "--set", f"render.texel={texel}", "--set",
                      f"render.sheet_thickness={sheets}", "--set", f"render.footprint_steps={8 if texel >= 1 else 16}")


def vdb_render_settings(n, threads):
    def text(values):
        return ",".join(repr(float(v)) for v in values)

    # Its coefficients are per voxel, its light is a radiance: irradiance / 4 pi.
    extinction = n["scale"] * n["voxel"]
    colour = n["irradiance"] / (4 * math.pi)
    scene = ["-name", n["grid"], "-res", "{}x{}".format(*n["resolution"]), "-translate", text(n["eye"]),
             "-lookat", text(e + l for e, l in zip(n["eye"], n["look"])), "-up", "0,1,0", "-focal", "50",
             "-aperture", repr(100 * math.tan(math.radians(n["fov"] / 2))),
             "-light", text([-c for c in n["light"]] + 3 * [colour]), "-scatter", text(3 * [extinction * n["albedo"]]),
             "-absorb", text(3 * [extinction * (1 - n["albedo"])]), "-gain", "0", "-cutoff", "1e-5", "-v",
             "-cpus", str(threads)]

    def seconds(log):
        return float(re.search(r"ray-tracing.*\n.*completed in ([\d.e+-]+) sec", log).group(1))

    # Its shadow rays begin with a whole step of where they start, an error of first order: that step matters most.
    for step, shadow in ((4, 4), (4, 2), (4, 1), (3, 0.5), (2, 0.5), (2, 0.25)):
        yield Setting("vdb_render", f"step {step} shadow {shadow}",
                      lambda picture, step=step, shadow=shadow: ["vdb_render", n["asset"], picture, *scene, "-step",
                                                                 str(step), "-shadowstep", str(shadow)], seconds)


# What is asked of those that draw at random: how, and how many samples.
RANDOM = {"mitsuba": [(("llvm_ad_rgb", "volpath"), (4, 16, 64)), (("scalar_rgb", "volpath"), (4,))],
          "luxcore": [((4,), (4,)), ((1,), (4, 16))],
          "cycles 3": [((2,), (4,)), ((1,), (4, 16)), ((0.5,), (32,))],
          "cycles 4": [((1,), (4, 16, 32)), ((1, 0.05), (32,)), ((0.5,), (16,))],
          "cycles 5": [((0,), (4, 16, 64)), ((1,), (16,))]}


def random_settings(tool, start, work, numbers, options):
    numbers_file = peers_tools.write_numbers(numbers, work, "timed", threads=options.threads)
    for how, counts in RANDOM.get(tool, [((1,), (4, 16, 64))]):
        for samples in counts:
            yield Setting(tool, f"samples {samples} {peers_tools.describe(tool, how)}",
                          lambda picture, how=how, samples=samples: peers_tools.command(
                              tool, start, numbers_file, picture, samples, *how), peers_tools.seconds, process=False)


def marcher(tool, label, work, *values):
    return Setting(tool, label, lambda picture: [BIN / "scrim_peers", "march", work / "scene.toml", picture,
                                                 *map(str, values)],
                   lambda log: float(log.split()[-1]), process=False)


def marcher_settings(work):
    for step, cell, ray in ((1.5, 3, 2), (1.5, 2, 2), (1.5, 1, 2), (1, 1, 1), (0.75, 1, 1)):
        yield marcher("light volume", f"step {step} cell {cell} ray {ray}", work, "volume", step, cell, ray)
    for step, shadow in ((3, 4), (1.5, 3), (1.5, 2), (1, 1), (0.75, 1), (0.5, 0.5)):
        yield marcher("shadow rays", f"step {step} shadow {shadow}", work, "rays", step, shadow)


def sweep_settings(work, steps=(4, 3, 2, 1.5, 1, 0.5), cells=(1, 2, 3)):
    for order, name in ((1, "bilinear"), (3, "cubic")):
        for cell in cells:
            for step in steps:
                if step >= cell / 2:
                    yield marcher("sweep", f"step {step} cell {cell} {name}", work, "sweep", step, cell, order)


def settings_of(work, numbers, options):
    """All that can and shall be measured."""
    tools = {"scrim": lambda: scrim_settings(work, options.threads),
             "vdb_render": lambda: vdb_render_settings(numbers, options.threads),
             "light volume": lambda: (s for s in marcher_settings(work) if s.tool == "light volume"),
             "shadow rays": lambda: (s for s in marcher_settings(work) if s.tool == "shadow rays"),
             "sweep": lambda: sweep_settings(work)}
    found = peers_tools.found()
    peers_tools.say_missing(found)
    dense = peers_tools.add_array(numbers, work)
    for tool, (start, version) in found.items():
        print(f"{tool}: version {version}")
        tools[tool] = lambda tool=tool, start=start: random_settings(tool, start, work, numbers, options)
    for tool, settings in tools.items():
        if tool in options.skip or tool.split()[0] in options.skip:
            print(f"{tool}: skipped, as asked")
        elif tool == "vdb_render" and not shutil.which(tool):
            print(f"{tool}: skipped, since there is no program '{tool}' (Debian package libopenvdb-tools)")
        elif tool in ("mitsuba", "luxcore") and not dense:
            print(f"{tool}: skipped, since there is no module 'pyopenvdb' (Debian package python3-openvdb)")
        else:
            yield from settings()


def asset_file(asset, work):
    """The .vdb of an asset, made where it is none."""
    if not asset.startswith("noise:"):
        return asset
    vdb = work / "noise.vdb"
    subprocess.run([BIN / "scrim", "make", "noise", f"resolution={asset[6:]}", "-o", vdb], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return vdb


def compare(asset, work, options):
    """Measures all settings on `asset`; a row of COLUMNS for each."""
    vdb, label = asset_file(asset, work), asset if asset.startswith("noise:") else Path(asset).name
    pixels = work / "pixels.txt"
    made = subprocess.run([BIN / "scrim_peers", "scene", vdb, work / "scene.toml", pixels, str(options.pixels)],
                          check=True, stdout=subprocess.PIPE, text=True).stdout
    (work / "numbers.json").write_text(made)
    numbers = json.loads(made)

    settings = list(settings_of(work, numbers, options))
    pictures = [work / f"{i}.exr" for i in range(len(settings))]
    for _ in range(options.rounds):
        for setting, picture in zip(settings, pictures):
            if not setting.process_times or setting.process_times[0] <= options.slow:
                setting.measure(picture)
    errors = subprocess.run([BIN / "scrim_peers", "error", pixels, *pictures], check=True, stdout=subprocess.PIPE,
                            text=True).stdout.splitlines()
    for setting, line in zip(settings, errors):
        process = f"{statistics.median(setting.process_times):.4g}" if setting.process else ""
        yield dict(zip(COLUMNS, [label, numbers["voxels"], setting.tool, setting.label, *line.split(), process,
                                 f"{statistics.median(setting.render_times):.4g}",
                                 f"{statistics.median(setting.cpu_times):.4g}",
                                 f"{statistics.median(setting.memory):.0f}", len(setting.process_times)]))


def print_table(rows, options):
    print(f"\n{rows[0]['asset']}: {rows[0]['voxels']} voxels, {options.threads} threads, {options.pixels} reference "
          f"pixels, median of up to {options.rounds} rounds")
    print(f"  {'tool':<14}{'setting':<34}{'error %':>9}{'95 % interval':>17}{'process s':>11}{'render s':>10}"
          f"{'peak MB':>9}{'rounds':>8}")
    for r in rows:
        interval = f"{100 * float(r['lower']):.2f} to {100 * float(r['upper']):.2f}"
        print(f"  {r['tool']:<14}{r['setting']:<34}{100 * float(r['error']):>9.2f}{interval:>17}"
              f"{r['process_seconds'] or '-':>11}{r['render_seconds']:>10}{r['memory_mb']:>9}{r['rounds']:>8}")
    print("  process: start, loading, render and writing. render: as the tool itself says. '-': the dense marchers\n"
          "  (light volume, shadow rays, sweep) are no programs, and those that draw at random render a first picture\n"
          "  that does not count; the marchers' memory is that of their copies, too. Memory is what was resident at "
          "most.", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("assets", nargs="*", metavar="ASSET")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--pixels", type=int, default=400, help="of the reference")
    parser.add_argument("--skip", action="append", default=[], metavar="TOOL",
                        help="scrim, vdb_render, mitsuba, luxcore, cycles, 'cycles 4', 'light volume', 'shadow rays', "
                             "sweep")
    parser.add_argument("--slow", type=float, default=10, help="seconds of a setting that is measured once")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--csv", default="peers.csv")
    parser.add_argument("--svg", help="a plot of the table")
    options = parser.parse_args()
    rows = []
    for asset in options.assets or ["noise:350"]:
        with tempfile.TemporaryDirectory() as work:
            rows.append(list(compare(asset, Path(work), options)))
        print_table(rows[-1], options)
    with open(options.csv, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for table in rows:
            writer.writerows(table)
    if options.svg:
        peers_plot.plot(options.csv, options.svg)


if __name__ == "__main__":
    main()
