#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How fast Scrim loads .vdb files, beside OpenVDB's own read of the same files, and the memory that both take.

    tests/tools/bench/loading.py [FOLDER] [RESOLUTION...]

Noise of so many voxels an edge is saved with every compression, as float and as half; 310, 670 and 1440 by default: 1,
10 and 100 million active voxels. The files are made in FOLDER (a temporary one by default), where they stay and are
used again; all of them take 2 GB. All reads find their file in the system's cache. Needs a build with benchmarks
(SCRIM_BUILD names another than build/).

The peak is the largest sum over Scrim's processes of their memory, pages that they share counted once, against the
bytes of OpenVDB's grid; it is taken from a load of its own, which is not timed. The last column leaves out what a load
of next to nothing takes, which is mostly libraries.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
BIN = pathlib.Path(os.environ.get("SCRIM_BUILD", ROOT / "build")) / "bin"
SCRIM, LOADING = BIN / "scrim", BIN / "scrim_loading"
CODECS, KINDS = ("none", "zip", "blosc"), ("float", "half")


def make_files(folder, resolution):
    noise = folder / f"noise{resolution}.vdb"
    if not noise.exists():
        subprocess.run([SCRIM, "make", "noise", "-o", noise, f"resolution={resolution}"], check=True,
                       stdout=subprocess.DEVNULL)
    for kind in KINDS:
        for codec in CODECS:
            path = folder / f"noise{resolution}_{codec}_{kind}.vdb"
            if not path.exists():
                subprocess.run([LOADING, "convert", noise, path, codec, kind], check=True)
            yield codec, kind, path


def read(way, path, rounds):
    """The shortest time in seconds, and the bytes in memory."""
    words = subprocess.run([LOADING, way, path, str(rounds)], check=True, capture_output=True, text=True).stdout.split()
    return float(words[0]), int(words[1])


def memory_of(pid):
    """The bytes of a process and those below it."""
    total = 0
    try:
        for line in open(f"/proc/{pid}/smaps_rollup"):
            if line.startswith("Pss:"):
                total += 1024 * int(line.split()[1])
        for task in os.listdir(f"/proc/{pid}/task"):
            for child in open(f"/proc/{pid}/task/{task}/children").read().split():
                total += memory_of(child)
    except (FileNotFoundError, ProcessLookupError):
        pass  # it has just ended
    return total


def peak_of_load(path):
    process = subprocess.Popen([LOADING, "scrim", path, "1"], stdout=subprocess.DEVNULL)
    peak, ended = [0], threading.Event()

    def watch():
        while not ended.is_set():
            peak[0] = max(peak[0], memory_of(process.pid))
            time.sleep(0.002)

    watcher = threading.Thread(target=watch)
    watcher.start()
    code = process.wait()
    ended.set()
    watcher.join()
    if code:
        sys.exit(f"scrim_loading ended with {code}")
    return peak[0]


def main():
    arguments = sys.argv[1:]
    if arguments and arguments[0] in ("-h", "--help"):
        sys.exit(__doc__)
    temporary = None
    if arguments and not arguments[0].isdigit():
        folder = pathlib.Path(arguments.pop(0))
        folder.mkdir(parents=True, exist_ok=True)
    else:
        temporary = tempfile.TemporaryDirectory()
        folder = pathlib.Path(temporary.name)
    print(f"{'resolution':>10} {'codec':>6} {'kind':>6}{'file MB':>9}{'grid MB':>9}{'OpenVDB s':>11}{'Scrim s':>9}"
          f"{'ratio':>7}{'peak MB':>9}{'ratio':>7}{'beyond':>8}")
    idle = peak_of_load(next(path for _, _, path in make_files(folder, 16)))
    for resolution in [int(a) for a in arguments] or [310, 670, 1440]:
        rounds = 15 if resolution < 500 else 5 if resolution < 1000 else 3
        for codec, kind, path in make_files(folder, resolution):
            theirs, grid = read("openvdb", path, rounds)
            ours, _ = read("scrim", path, rounds)
            peak = peak_of_load(path)
            print(f"{resolution:>10} {codec:>6} {kind:>6}{path.stat().st_size / 1e6:>9.0f}{grid / 1e6:>9.0f}"
                  f"{theirs:>11.3f}{ours:>9.3f}{ours / theirs:>7.2f}{peak / 1e6:>9.0f}{peak / grid:>7.2f}"
                  f"{(peak - idle) / grid:>8.2f}", flush=True)


if __name__ == "__main__":
    main()
