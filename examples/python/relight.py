#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Balances lights after the render: a picture has a layer for each light, and light adds up.

python relight.py examples/scenes/layers.toml relit.npy key=1,0.5,0.2 rim=0.3
"""

import sys

import numpy

import scrim


def relit(frame: scrim.Frame, gains: dict[str, list[float]]) -> numpy.ndarray:
    """The picture (height, width, 4) with every light times its gain: one number, or one for R, G and B."""
    picture = frame.image.copy()  # the frame's own arrays cannot be written to
    for light, gain in gains.items():
        picture[:, :, :3] += (numpy.array(gain, numpy.float32) - 1) * frame[f"light.{light}"]
    return picture


def main(scene: str, out: str, *words: str) -> None:
    gains = {name: [float(x) for x in gain.split(",")] for name, gain in (word.split("=") for word in words)}
    shot = scrim.open(scene, {"output.layers": ["light", "ambient"]})
    frame = shot.render(progress=lambda part: print(f"\r{100 * part:3.0f} %", end="", file=sys.stderr))
    numpy.save(out, relit(frame, gains))
    print(f"\r{out}: {', '.join(frame.layers)} of {scene}", file=sys.stderr)


if __name__ == "__main__":
    main(*sys.argv[1:])
