#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How renders grow: with cores, and with voxels. Whole processes, as users start them.

    tests/tools/bench/scaling.py cores [ASSET...]            two threads against two processes of one thread each
    tests/tools/bench/scaling.py voxels [RESOLUTION...]      noise of so many voxels an edge at 1920 x 1080: time, memory
    tests/tools/bench/scaling.py predict SCENE[:LAST]...     what 2, 16 and 64 cores would gain, by the tasks recorded

Needs a build (SCRIM_BUILD names another than build/). ASSETs are VDB files or scenes; without one, procedural smoke.
`predict` records the loops of the whole process on one thread (scrim_loops), and shares them among cores (see
list_schedule.py for what that leaves out); a SCENE with :LAST has the frames 1 to LAST, and then the gain is that of
the best of several --jobs, whose number stands in brackets. With --clock it also measures
`scrim render` with one and with two threads, which needs a quiet machine. -v prints what limits 64 cores.
`voxels` takes 310, 670 and 1440 by default: 1, 10 and 100 million active voxels; the last takes 0.4 GB of disk.
"""

import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

from list_schedule import read_record, seconds_of

ROOT = pathlib.Path(__file__).resolve().parents[3]
SCRIM = pathlib.Path(os.environ.get("SCRIM_BUILD", ROOT / "build")) / "bin" / "scrim"
ROUNDS, FRAMES = 7, 6


def start(asset, folder, name, threads):
    stats = folder / f"{name}.json"
    command = [SCRIM, "render", asset, "-q", "--threads", str(threads), "--frames", f"1-{FRAMES}",
               "-o", folder / f"{name}.####.exr", "--stats", stats]
    return subprocess.Popen(command), stats


def mean_seconds(process, stats):
    if process.wait():
        sys.exit(f"scrim ended with {process.returncode}")
    frames = json.loads(stats.read_text())[1:]  # the first warms up
    return statistics.median(f["seconds"]["render"] for f in frames)


def cores(assets, folder):
    for asset in assets:
        ratios, sides = [], []
        for _ in range(ROUNDS):
            two = mean_seconds(*start(asset, folder, "two", 2))
            pair = [start(asset, folder, f"one{i}", 1) for i in range(2)]
            seconds = [mean_seconds(*each) for each in pair]
            together = sum(1 / s for s in seconds)  # frames a second
            ratios.append(1 / two / together)
            sides.append((two, statistics.mean(seconds)))
        two, one = (statistics.median(side) for side in zip(*sides))
        print(f"{pathlib.Path(asset).name}: two threads {1e3 * two:.0f} ms a frame, two processes of one thread "
              f"{1e3 * one:.0f} ms; two threads reach {statistics.median(ratios):.2f} of what two processes do "
              f"({min(ratios):.2f} to {max(ratios):.2f} in {ROUNDS} rounds)")


def voxels(resolutions, folder):
    print(f"{'resolution':>10}{'voxels':>14}{'grid MB':>10}{'load s':>9}{'render s':>10}{'us a voxel':>12}"
          f"{'peak MB':>10}{'beyond grid':>13}")
    for resolution in resolutions:
        asset = folder / f"noise{resolution}.vdb"
        subprocess.run([SCRIM, "make", "noise", "-o", asset, f"resolution={resolution}"], check=True,
                       stdout=subprocess.DEVNULL)
        info = json.loads(subprocess.run([SCRIM, "info", asset, "--json"], check=True, capture_output=True,
                                         text=True).stdout)
        grid = info["grids"][0]
        stats = folder / "stats.json"
        begin = time.time()
        child = subprocess.Popen([SCRIM, "render", asset, "-q", "-o", folder / "large.exr", "--set",
                                  "camera.resolution=[1920,1080]", "--stats", stats])
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            sys.exit(f"scrim ended with {child.returncode}")
        seconds = json.loads(stats.read_text())[0]["seconds"]
        peak = usage.ru_maxrss / 1e3  # of the largest process, its children included
        count = grid["active_voxels"]
        plan = subprocess.run([SCRIM, "plan", asset], check=True, capture_output=True, text=True).stdout
        size, unit = re.search(r"memory of the fields\s+([\d.]+) (\w+)", plan).groups()
        grid_mb = float(size) * {"KB": 1e-3, "MB": 1, "GB": 1e3}[unit]
        print(f"{resolution:>10}{count:>14}{grid_mb:>10.0f}{seconds['load']:>9.2f}{seconds['render']:>10.2f}"
              f"{1e6 * seconds['render'] / count:>12.3f}{peak:>10.0f}{peak - grid_mb:>13.0f}"
              f"   ({time.time() - begin:.1f} s in all)", flush=True)
        asset.unlink()


CORES = 2, 16, 64


def recorded(scene, frames, threads, folder):
    path = folder / "record.txt"
    subprocess.run([SCRIM.parent / "scrim_loops", scene, str(threads), path, folder, str(frames[0]), str(frames[-1])],
                   check=True)
    return read_record(path)


def clock_ratio(scene, last, folder):
    """How much faster two threads are than one, by the clock."""
    times = {1: [], 2: []}
    for _ in range(3):
        for threads, all_times in times.items():
            begin = time.monotonic()
            subprocess.run([SCRIM, "render", scene, "-q", "--threads", str(threads), "--frames", f"1-{last}", "-o",
                            folder / "clock.####.exr"], check=True)
            all_times.append(time.monotonic() - begin)
    return statistics.median(times[1]) / statistics.median(times[2])


def best_of_jobs(scene, last, cores, folder):
    """The least time, and the number of jobs that reaches it. Those in the middle stand for the frames of each job."""
    jobs = [count for count in (1, 2, 4, 8, 12, 16, 24, 32, 48, 64) if count <= min(cores, last)]
    times = {}
    for count in jobs:
        threads, own = cores // count, -(-last // count)
        first = 1 + (last - own) // 2
        times[count] = recorded(scene, range(first, first + own), threads, folder).seconds(threads)
    best = min(jobs, key=times.get)
    return times[best], best


def limits(record, cores):
    """The parts of a record that take longest on so many cores."""
    print(f"    on {cores} cores {record.seconds(cores):.3f} s, of them {record.serial():.3f} s outside of loops; most:")
    parts = [(seconds_of([part], cores), i, part) for i, part in enumerate(record.parts)]
    for seconds, i, part in sorted(parts, key=lambda p: -p[0])[:12]:
        what = "between loops" if isinstance(part, float) else f"loop of {len(part.tasks)} tasks"
        print(f"    {1e3 * seconds:9.2f} ms of {1e3 * seconds_of([part], 1):9.2f}: part {i}, {what}")


def predict(arguments, folder):
    clock, verbose = "--clock" in arguments, "-v" in arguments
    print("| scene | s on one core | " + " | ".join(f"{cores} cores" for cores in CORES) +
          (" | 2 by the clock" if clock else "") + " |")
    print("| --- " * (2 + len(CORES) + clock) + "|")
    for argument in arguments:
        if argument.startswith("-"):
            continue
        scene, _, last = argument.partition(":")
        last = int(last or 1)
        alone = recorded(scene, range(1, last + 1), 1, folder).seconds(1)
        gains = []
        for cores in CORES:
            seconds, jobs = best_of_jobs(scene, last, cores, folder)
            gains.append(f"{alone / seconds:.1f}" + (f" ({jobs})" if last > 1 else ""))
        if clock:
            gains.append(f"{clock_ratio(scene, last, folder):.2f}")
        print(f"| {pathlib.Path(scene).name}{', ' + str(last) + ' frames' if last > 1 else ''} | {alone:.2f} | "
              + " | ".join(gains) + " |", flush=True)
        if verbose:
            limits(recorded(scene, range(1, last + 1), CORES[-1], folder), CORES[-1])


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in ("cores", "voxels", "predict"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if sys.argv[1] == "predict":
            return predict(sys.argv[2:], folder)
        if sys.argv[1] == "voxels":
            return voxels([int(a) for a in sys.argv[2:]] or [310, 670, 1440], folder)
        assets = sys.argv[2:]
        if not assets:
            assets = [folder / "noise.vdb"]
            subprocess.run([SCRIM, "make", "noise", "-o", assets[0], "resolution=350"], check=True,
                           stdout=subprocess.DEVNULL)
        cores(assets, folder)


if __name__ == "__main__":
    main()
