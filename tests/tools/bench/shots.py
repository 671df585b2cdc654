#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Does a shot cost the sum of its parts? Scenes of unlike volumes, beside each volume alone.

    tests/tools/bench/shots.py [SCENE...] [--build DIR] [--timeout SECONDS] [--verify N] [--large]
                               [--parts N] [--quality P] [--memory SIZE] [--out FOLDER] [--pictures]

Needs a build (--build or SCRIM_BUILD names another than build/), and makes its volumes with
`scrim make`. The scenes (shots_scenes.py; all, if none is named):

    a               ball of 60 voxels of 2 cm in haze of voxels of 2 m, 128 x 128 pixels
    a-1000          the same with a ball of voxels of 2 mm
    b               a from 3 m, 512 x 512 pixels
    c-10 40 400     instances of one plume of 1.6 million voxels over 80 m, sun and sky, 960 x 540
    d               the plumes of c-10, one more 8 m before the camera, all in one haze
    e               a hero plume of voxels larger than a pixel before forty far ones, in one haze
    flat-100 ...    voxels with edges of 1 : 1 : 1/100, 1/1000, 1/10000; alone: cubes
    stray-5000 ...  smoke, and in its grid one voxel 5,000, 50,000 or 10^7 voxels away
    tile-2048 4096  a constant cube of so many voxels an edge; alone: one of 64 larger voxels
    large           100 million voxels at 1920 x 1080; needs --large, a GB of disk and of memory

Prints a table in Markdown. Each row describes whole commands: processor seconds (user and system,
children included), seconds by the clock, and the peak memory of the largest process. First come
those of the scene, then those of its parts, each rendered alone with the same camera and lights:
the sums of their seconds, and their largest memory. The ratio is that of processor seconds. Of
many parts of one kind --parts N are rendered, evenly chosen, and their mean stands for the others
("~"). A command that takes longer than --timeout is killed ("> 100"). The last column says why
commands failed. `error` is what `scrim render --verify N` says (relative RMSE); it is measured
where the scene ends in time, by a second command that may take three times as long.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import shots_scenes

ROOT = Path(__file__).resolve().parents[3]
MISSED = 5  # exit status of a picture that is not as exact as was asked for
HEADER = ("| scene | s, processor | s, clock | MB | parts alone | s, processor | s, clock | MB "
          "| together / sum | error | failed |")


@dataclass
class Cost:
    """What one command takes, or the sum of several."""

    processor: float = 0
    clock: float = 0
    memory: float = 0  # MB
    killed: bool = False  # the command would take longer
    failure: str = ""
    estimated: bool = False  # some of the commands stand for others

    def add(self, other, weight):
        """Adds `weight` commands like `other`."""
        self.processor += weight * other.processor
        self.clock += weight * other.clock
        self.memory = max(self.memory, other.memory)
        self.killed |= other.killed


def last_error(log):
    """The line in which a command says why it failed."""
    lines = [line for line in log.read_text(errors="replace").splitlines() if line]
    errors = [line for line in lines if "error:" in line] or lines[-1:]
    text = errors[0] if errors else ""
    return text.removeprefix("scrim: error: ").replace("|", "\\|")


def run(command, log, timeout):
    """Runs a command in a process group of its own, which is killed after `timeout` seconds."""
    begin, late = time.monotonic(), threading.Event()
    with open(log, "w") as out:
        child = subprocess.Popen([str(c) for c in command], stdout=out, stderr=out,
                                 start_new_session=True)

    def kill():
        late.set()
        os.killpg(child.pid, signal.SIGKILL)

    timer = threading.Timer(timeout, kill)
    timer.start()
    try:
        # The child stays a zombie, and its group valid, until the timer can no longer kill it.
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
    except BaseException:  # somebody ends the bench
        kill()
        raise
    finally:
        timer.cancel()
        timer.join()
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    cost = Cost(usage.ru_utime + usage.ru_stime, time.monotonic() - begin, usage.ru_maxrss / 1024)
    cost.killed = late.is_set() and child.returncode == -signal.SIGKILL
    if cost.killed:
        cost.failure = f"killed after {timeout:g} s"
    elif child.returncode not in (0, MISSED):
        cost.failure = last_error(log) or f"exit status {child.returncode}"
    return cost


class Bench:
    """Renders scenes in a folder."""

    def __init__(self, scrim, folder, options):
        self.scrim, self.folder, self.options = scrim, folder, options
        self.assets = shots_scenes.Assets(scrim, folder)

    def render(self, name, view, volumes, *more, timeout=None):
        scene = self.folder / f"{name}.toml"
        scene.write_text(view + "\n" + "".join(v.text for v in volumes))
        command = [self.scrim, "render", scene, "-o", scene.with_suffix(".exr"), "-q", *more]
        if self.options.quality:
            command += ["--quality", self.options.quality]
        if self.options.memory:
            command += ["--memory", self.options.memory]
        return run(command, scene.with_suffix(".log"), timeout or self.options.timeout)

    def together(self, name, shot):
        picture = ["--preview", self.folder / f"{name}.png"] if self.options.pictures else []
        return self.render(name, shot.view, shot.volumes, *picture)

    def alone(self, name, shot):
        """The sum of the parts, and words for them."""
        total, words = Cost(), []
        for kind in dict.fromkeys(p.kind for p in shot.parts):
            parts = [p for p in shot.parts if p.kind == kind]
            some = parts
            if len(parts) > self.options.parts:
                step = len(parts) / self.options.parts
                some = [parts[int(step * (i + 0.5))] for i in range(self.options.parts)]
            total.estimated |= len(some) < len(parts)
            words.append(kind if len(parts) == 1 else f"{len(parts)} of {kind}")
            for part in some:
                cost = self.render(f"{name}-alone", shot.view, [part])
                total.add(cost, len(parts) / len(some))
                total.failure = total.failure or (cost.failure and f"alone, {kind}: {cost.failure}")
        return total, ", ".join(words)

    def error(self, name, shot):
        """What a second render of the scene measures, or why it fails."""
        stats, limit = self.folder / f"{name}.json", self.options.timeout
        stats.unlink(missing_ok=True)
        verify = ["--verify", self.options.verify, "--verify-limit", limit, "--stats", stats]
        cost = self.render(f"{name}-verified", shot.view, shot.volumes, *verify, timeout=3 * limit)
        if cost.failure:
            return cost.failure
        found = json.loads(stats.read_text())[0]["verification"]
        if not found["pixels"]:
            return f"no pixel in {limit:g} s"
        return f"{100 * found['error']:.2f} % of {found['pixels']} pixels"


def seconds(cost, value):
    return f"{'> ' if cost.killed else '~ ' if cost.estimated else ''}{value:.3g}"


def cells(cost):
    """Processor, clock and memory; a command that failed by itself has no costs to show."""
    if cost.failure and not cost.killed:
        return ["-", "-", "-"]
    return [seconds(cost, cost.processor), seconds(cost, cost.clock), f"{cost.memory:.0f}"]


def ratio(together, alone):
    """Of processor seconds; "" where one of the two is not known."""
    if alone.failure or (together.failure and not together.killed) or alone.processor == 0:
        return ""
    sign = "> " if together.killed else "~ " if alone.estimated else ""
    return f"{sign}{together.processor / alone.processor:.3g}"


def row(bench, name):
    shot = shots_scenes.SHOTS[name](bench.assets)
    together = bench.together(name, shot)
    error = bench.error(name, shot) if bench.options.verify and not together.failure else ""
    alone, words = bench.alone(name, shot)
    failures = "; ".join(filter(None, (together.failure, alone.failure)))
    return [name, *cells(together), words, *(cells(alone) if shot.parts else [""] * 3),
            ratio(together, alone), error, failures]


def parse():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("scene", nargs="*", help="names of scenes; all, if none is given")
    add("--build", type=Path, default=os.environ.get("SCRIM_BUILD", ROOT / "build"))
    add("--timeout", type=float, default=100, help="seconds of a command by the clock")
    add("--verify", type=int, default=0, help="pixels that are held against brute force")
    add("--large", action="store_true", help="also the scene of 100 million voxels")
    add("--parts", type=int, default=10, help="parts of one kind that are rendered alone, at most")
    add("--quality", help="preset of all scenes")
    add("--memory", help="limit of each command, as of scrim render")
    add("--out", type=Path, help="folder for volumes and pictures, which stay there")
    add("--pictures", action="store_true", help="also write a PNG of each scene; needs --out")
    options = parser.parse_args()
    unknown = [s for s in options.scene if s not in shots_scenes.SHOTS]
    if unknown:
        parser.error(f"no scene {unknown[0]!r}; there is {', '.join(shots_scenes.SHOTS)}")
    if shots_scenes.LARGE in options.scene and not options.large:
        parser.error(f"{shots_scenes.LARGE!r} needs --large")
    if options.pictures and not options.out:
        parser.error("--pictures needs --out")
    if options.parts < 1 or options.timeout <= 0:
        parser.error("--parts and --timeout must be above 0")
    return options


def main():
    options = parse()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("terminated"))
    scrim = Path(options.build).resolve() / "bin" / "scrim"
    if not scrim.exists():
        sys.exit(f"{scrim}: not found; build first, or name a build with --build")
    names = options.scene or list(shots_scenes.SHOTS)
    if not options.large:
        names = [n for n in names if n != shots_scenes.LARGE]
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.out or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        bench = Bench(scrim, folder, options)
        print(HEADER + "\n|" + " --- |" * HEADER.count(" |"), flush=True)
        for name in names:
            print("| " + " | ".join(row(bench, name)) + " |", flush=True)


if __name__ == "__main__":
    main()
