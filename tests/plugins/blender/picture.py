# SPDX-License-Identifier: Apache-2.0
# examples/blender.jpg: one scene by Scrim and by Cycles, side by side, with the time that each took.
#   python picture.py OUT.png [SAMPLES]
import math
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
import scenes as s

SIDE = 256


def build(path):
    scene = s.fresh((SIDE, SIDE))
    s.volume(path, s.Matrix.Translation((0, 0, -0.05)), Density=9.0, Color=(0.95, 0.9, 0.85), Anisotropy=0.3)
    s.light("SUN", (3, -1.5, 3), name="sun", energy=14.0, angle=0.0, color=(1, 0.85, 0.65))
    s.light("AREA", (-2, -1.5, 0.5), name="soft", energy=180.0, shape="DISK", size=1.2, color=(0.45, 0.65, 1))
    scene.scrim.overrides = "light.soft.samples=24"
    return scene


def eight_bits(image):
    image = np.clip(image * 1.4, 0, 1)
    srgb = np.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055)
    return (255 * srgb + 0.5).astype(np.uint8)


def main():
    target, samples = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 128
    folder = tempfile.mkdtemp()
    path = os.path.join(folder, "smoke.vdb")
    subprocess.run([os.environ["SCRIM"], "make", "noise", "resolution=96", "shape=ball", "-o", path, "-q"], check=True)
    build(path)
    times, images = [], []
    for cycles in (False, True):
        if cycles:
            s.cycles(samples)
        begun = time.monotonic()
        images.append(s.rgb(s.render(os.path.join(folder, "a.exr"))))
        times.append(time.monotonic() - begun)
    error = s.difference(*images)
    print(f"PICTURE {times[0]:.1f} s, {times[1]:.0f} s at {samples} samples, {100 * error:.2f} % apart", flush=True)
    pixels = np.concatenate([eight_bits(image) for image in images], axis=1)
    out = s.bpy.data.images.new("both", pixels.shape[1], pixels.shape[0])
    rgba = np.ones((*pixels.shape[:2], 4), np.float32)
    rgba[:, :, :3] = pixels[::-1] / 255
    out.pixels.foreach_set(rgba.reshape(-1))
    out.filepath_raw, out.file_format = target, "PNG"
    out.save()
    return 0 if math.isfinite(error) else 1


status = main()
sys.stdout.flush()
os._exit(status)
