#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Scrim beside dense marchers under several suns: what speed they have at the same error.

    tests/tools/bench/peers_suns.py [--rounds N] [--pixels N] [--csv FILE] [ASSET]

The ASSET (default noise:350), its camera and its density are those of peers.py; the sun shines obliquely to the grid
(as there), from behind the volume, from the eye's side, and along an axis of the grid. The light volume of the sweep
marcher (sweep_marcher.h) has an error of its own that finer steps of eye rays do not take away: its floor. Printed are,
for each sun and look-up (bilinear, cubic), the coarsest step whose error is within 5 % of the floor, its time and
error, the time that Scrim and the marcher with shadow rays take for the same error and for 1 %, and ratios to the sweep
marcher's time.

Times are render times as in peers.py, medians of interleaved rounds. Those of an error are interpolated between the
measured settings that no other one beats, straight in the logarithms; '-' where no setting is as good.
"""
import argparse
import csv
import json
import math
import os
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

import peers
import peers_plot

STEPS = (4, 3, 2, 1.5, 1, 0.75, 0.5)


def suns(numbers):
    """Directions in which light travels."""
    look, oblique = numbers["look"], numbers["light"]
    behind = [-c for c in look]
    behind[1] -= 0.3  # a little from above, or the camera would look into it
    front = [look[0] + 0.2, look[1] - 0.3, look[2]]
    return {"oblique": oblique, "behind": behind, "front": front, "along an axis": [0, -1, 0]}


def time_at(rows, tool, error):
    """Seconds that a tool takes for an error, None if no setting is as good."""
    front = peers_plot.front([(r["seconds"], r["error"]) for r in rows if r["tool"] == tool])
    if not front or front[-1][1] > error:
        return None
    for (t0, e0), (t1, e1) in zip(front, front[1:]):
        if e0 > error >= e1:
            part = math.log(e0 / error) / math.log(e0 / e1)
            return t0 * (t1 / t0) ** part
    return front[0][0]


def measure(work, options):
    settings = [s for s in peers.scrim_settings(work, options.threads) if not s.label.startswith("quality")]
    settings += [s for s in peers.marcher_settings(work) if s.tool == "shadow rays"]
    settings += peers.sweep_settings(work, STEPS, (1, 2))
    pictures = [work / f"{i}.exr" for i in range(len(settings))]
    for _ in range(options.rounds):
        for setting, picture in zip(settings, pictures):
            if not setting.render_times or setting.render_times[0] <= options.slow:
                setting.measure(picture)
    errors = subprocess.run([peers.BIN / "scrim_peers", "error", work / "pixels.txt", *pictures], check=True,
                            stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return [{"tool": s.tool, "setting": s.label, "error": float(line.split()[0]),
             "seconds": statistics.median(s.render_times)} for s, line in zip(settings, errors)]


def summarise(sun, rows):
    def cell(seconds, base):
        ratio = f" ({seconds / base:.1f}x)" if seconds and base else ""
        return f"{seconds:.3f}{ratio}" if seconds else "-"

    def step(row):
        return float(row["setting"].split()[1])

    for name in ("bilinear", "cubic"):
        of_kind = [r for r in rows if r["setting"].endswith(f"cell 1 {name}")]
        floor = min(r["error"] for r in of_kind)
        best = max((r for r in of_kind if r["error"] <= 1.05 * floor), key=step)
        sweep_at_1 = time_at(rows, "sweep", 0.01)
        equal = [time_at(rows, tool, best["error"]) for tool in ("scrim", "shadow rays")]
        at_1 = [time_at(rows, tool, 0.01) for tool in ("scrim", "shadow rays")]
        print(f"  {sun:<15}{name:<10}{step(best):>5g}{100 * best['error']:>8.2f}{best['seconds']:>9.3f}"
              f"{cell(equal[0], best['seconds']):>18}{cell(equal[1], best['seconds']):>18}"
              f"{f'{sweep_at_1:.3f}' if sweep_at_1 else '-':>10}"
              f"{cell(at_1[0], sweep_at_1):>18}{cell(at_1[1], sweep_at_1):>18}",
              flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", nargs="?", default="noise:350", metavar="ASSET")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--pixels", type=int, default=400, help="of the reference")
    parser.add_argument("--slow", type=float, default=2, help="seconds of a setting that is measured once")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--csv", default="peers_suns.csv")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, open(options.csv, "w", newline="") as file:
        work = Path(folder)
        vdb = peers.asset_file(options.asset, work)
        made = subprocess.run([peers.BIN / "scrim_peers", "scene", vdb, work / "scene.toml", work / "pixels.txt", "1"],
                              check=True, stdout=subprocess.PIPE, text=True).stdout
        text = (work / "scene.toml").read_text()
        table = csv.DictWriter(file, ["sun", "tool", "setting", "error", "seconds"])
        table.writeheader()
        print(f"{options.asset}: sweep marcher at its floor; others at its error, and all at 1 %; seconds, and times "
              f"as many as the sweep marcher\n  {'sun':<15}{'look-up':<10}{'step':>5}{'error %':>8}{'sweep s':>9}"
              f"{'Scrim':>18}{'shadow rays':>18}{'1 %: sweep':>10}{'Scrim':>18}{'shadow rays':>18}")
        for sun, way in suns(json.loads(made)).items():
            (work / "scene.toml").write_text(re.sub(r"direction = \[.*\]", f"direction = {way}", text))
            subprocess.run([peers.BIN / "scrim_peers", "pixels", work / "scene.toml", work / "pixels.txt",
                            str(options.pixels)], check=True)
            rows = measure(work, options)
            table.writerows({"sun": sun, **row} for row in rows)
            summarise(sun, rows)


if __name__ == "__main__":
    main()
