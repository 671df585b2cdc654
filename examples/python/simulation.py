#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A small simulation, rendered from its arrays as it goes: no file in between.

    python simulation.py 'plume.####.exr' 60

Warm smoke rises from a disc: semi-Lagrangian advection, buoyancy, and a pressure solve in Fourier space (Stam, *A
Simple Fluid Solver based on the FFT*, 2001) in a periodic box.
"""

import sys

import numpy

import scrim

SCENE = {
    "scene_version": 2,
    "camera": {"position": [0, 1.0, 3.4], "target": [0, 1.0, 0], "fov": 40, "resolution": [360, 480]},
    "volume": [
        {
            "name": "plume",
            "density": {"scale": 16.0},
            "medium": {
                "albedo": [0.9, 0.9, 0.9],
                "phase": {"type": "hg", "g": 0.3},
                "blackbody": {"grid": "heat", "kelvin": [300, 1900], "intensity": 12},
            },
        }
    ],
    "light": [
        {"name": "key", "type": "distant", "direction": [-0.8, -0.6, -0.3], "intensity": 16.0},
        {"name": "rim", "type": "distant", "direction": [0.9, 0.1, 0.4], "color": [0.4, 0.6, 1.0], "intensity": 10.0},
    ],
    "output": {"layers": ["light", "emission"]},
}


def sampled(field: numpy.ndarray, at: numpy.ndarray) -> numpy.ndarray:
    """Trilinear; `at` (3, ...) in voxels, periodic."""
    low = numpy.floor(at).astype(int)
    part = at - low
    out = numpy.zeros(at.shape[1:])
    for corner in numpy.ndindex(2, 2, 2):
        weight = numpy.prod([part[a] if corner[a] else 1 - part[a] for a in range(3)], axis=0)
        out += weight * field[tuple((low[a] + corner[a]) % field.shape[a] for a in range(3))]
    return out


class Plume:
    def __init__(self, n: int):
        self.shape = (n, 2 * n, n)  # y is up
        self.cells = numpy.indices(self.shape).astype(float)
        self.velocity = numpy.zeros((3, *self.shape))  # voxels a step
        self.density, self.heat = numpy.zeros(self.shape), numpy.zeros(self.shape)
        self.waves = numpy.stack(numpy.meshgrid(*[numpy.fft.fftfreq(s) for s in self.shape], indexing="ij"))
        x, y, z = (self.cells[a] / n - (0.5, 0, 0.5)[a] for a in range(3))
        ripple = 0.03 * numpy.cos(5 * numpy.arctan2(z, x))
        self.source = (numpy.hypot(x, z) < 0.16 + ripple) & (numpy.abs(y - 0.12) < 0.05)

    def step(self) -> None:
        self.density[self.source] = self.heat[self.source] = 1
        self.velocity[1] += 0.3 * self.heat - 0.02 * self.density
        # What stays free of divergence is the part of each wave across its direction.
        spectrum = numpy.fft.fftn(self.velocity, axes=(1, 2, 3))
        length = numpy.maximum((self.waves**2).sum(0), 1e-12)
        spectrum -= self.waves * ((self.waves * spectrum).sum(0) / length)
        self.velocity = numpy.fft.ifftn(spectrum, axes=(1, 2, 3)).real
        came_from = self.cells - self.velocity
        self.velocity = numpy.stack([sampled(v, came_from) for v in self.velocity])
        self.density = 0.995 * sampled(self.density, came_from)
        self.heat = 0.96 * sampled(self.heat, came_from)


def main(out: str, frames: str = "60", n: str = "40", width: str = "360") -> None:
    size = int(n)
    plume = Plume(size)
    shot = scrim.loads(SCENE, {"camera.resolution": [int(width), int(width) * 4 // 3]})
    place = {"voxel_size": 1 / size, "origin": (0.5 / size - 0.5, 0.5 / size, 0.5 / size - 0.5)}
    for frame in range(1, int(frames) + 1):
        plume.step()
        grids = [scrim.Field(plume.density, **place), scrim.Field(plume.heat, name="heat", **place)]
        shot.set_volume("plume", grids)
        print(shot.render(frame).write(out))


if __name__ == "__main__":
    main(*sys.argv[1:])
