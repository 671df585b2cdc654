# SPDX-License-Identifier: Apache-2.0
"""The scenes of shots.py: volumes of unlike voxels, alone and together. Lengths are in metres.

A scene is a function that makes its assets and gives a Shot; SHOTS names all of them. Places and
sizes of instances come from a fixed seed: the first ten plumes of forty are those of the smaller
scene.
"""

import random
import subprocess
from dataclasses import dataclass
from functools import partial
from pathlib import Path

SUN = '[[light]]\nname = "sun"\ntype = "distant"\ndirection = [-1, -1, -1]\nintensity = 10\n'
SKY = '[[light]]\nname = "sky"\ntype = "dome"\nintensity = 0.5\n'
PLUME_SIZE = 7.32  # so that 366 voxels along it are 2 cm each
HAZE_BASE = 16  # half the height of the haze of a field of plumes


@dataclass(frozen=True)
class Part:
    """A [[volume]] of a scene. Parts of one kind differ in place and size alone."""

    kind: str
    text: str


@dataclass(frozen=True)
class Shot:
    """A scene: what is rendered together, and the parts that are rendered alone."""

    view: str  # camera and lights
    volumes: list[Part]
    parts: list[Part]  # `volumes`, or what a single volume is compared with; may be empty


class Assets:
    """Makes each .vdb once."""

    def __init__(self, scrim: Path, folder: Path):
        self.scrim, self.folder = scrim, folder

    def make(self, name, source, **parameters):
        path = self.folder / f"{name}.vdb"
        if not path.exists():
            command = [self.scrim, "make", source, *(f"{k}={v}" for k, v in parameters.items())]
            done = subprocess.run([*command, "-o", path, "-q"], stderr=subprocess.PIPE, text=True)
            if done.returncode != 0:
                raise SystemExit(f"{path.name}: {done.stderr.strip()}")
        return path

    def plume(self, voxels):
        return self.make(f"plume{voxels}", "noise", shape="plume", resolution=voxels,
                         size=PLUME_SIZE)


def numbers(values):
    return "[" + ", ".join(f"{v:.10g}" for v in values) + "]"


def camera(position, target, resolution):
    return (f"[camera]\nposition = {numbers(position)}\ntarget = {numbers(target)}\n"
            f"fov = 40\nresolution = {numbers(resolution)}\n\n")


def volume(kind, file, density=1.0, translate=(0, 0, 0), scale=(1, 1, 1)):
    transform = f"{{ translate = {numbers(translate)}, scale = {numbers(scale)} }}"
    return Part(kind, f'[[volume]]\nfile = "{file}"\ndensity = {{ scale = {density:.10g} }}\n'
                f"transform = {transform}\n\n")


def whole(view, volumes):
    return Shot(view, volumes, volumes)


# ---- a ball of small voxels in haze of large ones

def ball_in_haze(voxel, distance, pixels, assets):
    """A and B. The ball's density falls from its middle to its surface: with voxels of 2 cm it is
    5 (1 - r). The ball has the same optical depth with all voxels."""
    haze = assets.make("haze", "noise", shape="box", resolution=24, size=48, density=0.02,
                       turbulence=0.3)
    ball = assets.make(f"ball{voxel:g}", "primitives", voxel=voxel, soft=30 * voxel,
                       shapes=f"sphere radius={15 * voxel:g} density={0.1 / voxel:g}")
    return whole(camera((0, 0, distance), (0, 0, 0), (pixels, pixels)) + SUN,
                 [volume("haze", haze), volume("ball", ball)])


# ---- fields of plumes

def field(count, file, behind=0):
    """`count` instances over 80 m, `behind` metres farther away than the middle of the scene."""
    lot = random.Random(2)  # of which 25 of 40 plumes are in view
    plumes = []
    for _ in range(count):
        x, z, scale = lot.uniform(-40, 40), lot.uniform(-40, 40), lot.uniform(0.5, 1.5)
        place = (x, 0.5 * PLUME_SIZE * scale, z - behind)
        plumes.append(volume("plume", file, 4, place, (scale, scale, scale)))
    return plumes


def over_field():
    """The camera of all fields, 75 m before their middle. It sees 6 of 10 plumes, and 25 of 40."""
    return camera((0, 6, 75), (0, 4, 0), (960, 540)) + SUN + SKY


def haze_over_field(assets):
    haze = assets.make("haze_over_field", "noise", shape="box", resolution=52, size=208,
                       proportions="208, 32, 208", density=0.004, turbulence=0.3)
    return volume("haze", haze, 1, (0, HAZE_BASE, -12))


def plumes(count, assets):
    """C."""
    return whole(over_field(), field(count, assets.plume(366)))


def plume_near_plumes(assets):
    """D: ten plumes, and one of the same voxels 8 m before the camera, in haze."""
    file = assets.plume(366)
    near = volume("near plume", file, 4, (1.5, 0.5 * PLUME_SIZE, 67))
    return whole(over_field(), [haze_over_field(assets), near, *field(10, file)])


def hero_before_plumes(assets):
    """E: the hero's voxels of 4 cm are 4.8 pixels wide, those of the far plumes less than half of
    a pixel."""
    hero = volume("hero", assets.plume(183), 4, (1, 0.5 * PLUME_SIZE + 1.3, 64))
    far = field(40, assets.plume(366), 60)
    return whole(over_field(), [haze_over_field(assets), hero, *far])


# ---- one volume

def flat_voxels(ratio, assets):
    """Voxels of 1 : 1 : 1/ratio, of the same optical depth along the short edge; alone: cubes."""
    file = assets.make("cubes", "noise", shape="ball", resolution=48, size=48)
    view = camera((30, 20, 60), (0, 0, 0), (256, 256)) + SUN
    flat = volume("flat", file, 0.15 * ratio, scale=(1, 1, 1 / ratio))
    return Shot(view, [flat], [volume("cubes", file, 0.15)])


def stray_voxel(distance, assets):
    """One grid with smoke and a voxel far out of view; alone: the smoke, and the voxel."""
    smoke = assets.make("smoke", "noise", shape="ball", resolution=100, size=100)
    x, y, z = (round(distance * way) + 0.5 for way in (0.6, -0.48, -0.64))
    stray = assets.make(f"stray{distance}", "primitives", voxel=1, soft=0.001,
                        shapes=f"box size=1,1,1 center={x},{y},{z} density=0.001")
    grids = f'{{ density = {{ max = ["{smoke}:density", "{stray}:density"] }} }}'
    both = Part("both", f"[[volume]]\ngrids = {grids}\ndensity = {{ scale = 0.1 }}\n\n")
    view = camera((20, 25, 160), (0, 0, 0), (256, 256)) + SUN
    return Shot(view, [both], [volume("smoke", smoke, 0.1), volume("stray voxel", stray, 0.1)])


def constant_tile(edge, assets):
    """A cube of `edge` voxels of one value, which its file holds as tiles of 128 voxels an edge or
    more; alone: the same cube of 64 voxels an edge."""
    middle = 3 * (edge / 2,)

    def cube(kind, voxel):
        x = edge / 2
        file = assets.make(f"cube{edge}of{voxel}", "primitives", voxel=voxel, soft=0.001 * voxel,
                           shapes=f"box size={edge},{edge},{edge} center={x},{x},{x}")
        return volume(kind, file, 2 / edge)

    view = camera((1.8 * edge, 1.4 * edge, 2.7 * edge), middle, (256, 256)) + SUN
    return Shot(view, [cube("tile", 1)], [cube("coarse cube", edge // 64)])


def many_voxels(assets):
    """100 million voxels of less than a pixel."""
    view = camera((0, 0, 16), (0, 0, 0), (1920, 1080)) + SUN
    return Shot(view, [volume("plume", assets.plume(1440), 4)], [])


LARGE = "large"
SHOTS = {
    "a": partial(ball_in_haze, 0.02, 66, 128),
    "a-1000": partial(ball_in_haze, 0.002, 66, 128),
    "b": partial(ball_in_haze, 0.02, 3, 512),
    "c-10": partial(plumes, 10),
    "c-40": partial(plumes, 40),
    "c-400": partial(plumes, 400),
    "d": plume_near_plumes,
    "e": hero_before_plumes,
    "flat-100": partial(flat_voxels, 100),
    "flat-1000": partial(flat_voxels, 1000),
    "flat-10000": partial(flat_voxels, 10000),
    "stray-5000": partial(stray_voxel, 5000),
    "stray-50000": partial(stray_voxel, 50000),
    "stray-10000000": partial(stray_voxel, 10000000),
    "tile-2048": partial(constant_tile, 2048),
    "tile-4096": partial(constant_tile, 4096),
    LARGE: many_voxels,
}
