# SPDX-License-Identifier: Apache-2.0
# Blender's factory scene with a volume in place of the cube: its lamp (a sphere of radius 0.1), its grey world, its
# camera. How long Scrim takes, and how long Cycles as it comes: with 64 samples and a denoiser.
#   python factory.py VOLUME.vdb [WIDTH HEIGHT] [--truth SAMPLES] [--pictures FOLDER]
# Prints seconds and the relative RMSE of means over 8 x 8 pixels against Cycles with --truth samples (512), small steps
# and no filter.
import argparse
import os
import sys
import tempfile
import time

import numpy as np
import scenes as s

bpy = s.bpy


def build(path, resolution):
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    thing = s.volume(path, Density=6.0, Color=(0.8, 0.8, 0.8))
    thing.data.grids.load()
    points = np.array(thing.bound_box)
    size = (points.max(0) - points.min(0)).max()
    middle = (points.max(0) + points.min(0)) / 2
    thing.matrix_world = s.Matrix.Scale(3.0 / size, 4) @ s.Matrix.Translation(-s.Vector(middle))
    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.render.film_transparent = True
    scene.render.engine = "SCRIM"
    return scene


def timed(path):
    begun = time.monotonic()
    picture = s.rgb(s.render(path))
    return picture, time.monotonic() - begun


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("volume")
    parser.add_argument("size", nargs="*", type=int, default=(960, 540))
    parser.add_argument("--truth", type=int, default=512)
    parser.add_argument("--pictures")
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)
    folder = args.pictures or tempfile.mkdtemp(prefix="scrim-factory-")
    scene = build(args.volume, args.size)
    pictures = {}
    pictures["Scrim"], first = timed(os.path.join(folder, "scrim.exr"))
    seconds = {"Scrim": min(first, timed(os.path.join(folder, "scrim.exr"))[1])}
    for thing in scene.objects:
        if thing.type == "VOLUME":
            thing.matrix_world = thing.matrix_world @ s.Matrix.Translation(-s.cycles_shift(thing.data))
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", 64
    cycles.use_adaptive_sampling, cycles.use_denoising, cycles.denoiser = False, True, "OPENIMAGEDENOISE"
    cycles.volume_bounces = 0
    name = "Cycles, 64 samples, denoised"
    pictures[name], seconds[name] = timed(os.path.join(folder, "denoised.exr"))
    s.cycles(args.truth)
    truth, whole = timed(os.path.join(folder, "truth.exr"))
    for name, picture in pictures.items():
        print(f"| {name} | {seconds[name]:.2f} s | {100 * s.difference(picture, truth):.2f} % |", flush=True)
    print(f"| Cycles, {args.truth} samples | {whole:.1f} s | |", flush=True)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # bpy may hang where Python takes it apart
