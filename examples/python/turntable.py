#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Turns the camera once around an asset, several renders at a time.

python turntable.py smoke.vdb 'turn.####.exr' 24
"""

import os
import sys
from concurrent.futures import ThreadPoolExecutor

import scrim


def main(asset: str, out: str, frames: str = "24", width: str = "640") -> None:
    count, size = int(frames), (int(width), int(width) * 9 // 16)

    def render(first: int) -> list[str]:
        # A shot does one thing at a time; each thread has one of its own, on one core.
        shot = scrim.open(asset, turntable=count, resolution=size)
        return [shot.render(frame, threads=1).write(out) for frame in range(first, count + 1, workers)]

    workers = min(os.cpu_count() or 1, count)
    with ThreadPoolExecutor(workers) as pool:
        for paths in pool.map(render, range(1, workers + 1)):
            print("\n".join(paths))


if __name__ == "__main__":
    main(*sys.argv[1:])
