# SPDX-License-Identifier: Apache-2.0
"""From an OpenUSD stage to a finished picture: renders its smoke, relights it by its layers, and puts the deep picture
of another renderer into it. Needs usd-core and openimageio of PyPI.

    python composite.py shot.usda solids.deep.exr out.exr 12 key=2,1,0.5 rim=0.25

The deep picture has channels R, G, B, A, Z, ZBack and was taken by the same camera at the same resolution.
"""

import sys
import tempfile
from pathlib import Path

import numpy
import OpenImageIO as oiio
import scrim.usd

LAYERS = {
    "output.layers": ["light"],
    "output.deep": "smoke.deep.exr",
    "output.deep_type": "float",
    "output.deep_tolerance": 0.001,
}


def relit_part(frame, gains):
    """How much brighter each pixel becomes, in each channel: what the layers of lights add up to is the picture."""
    before = frame.image[:, :, :3]
    after = before.copy()
    for light, gain in gains.items():
        after += (numpy.array(gain) - 1) * frame[f"light.{light}"]
    return numpy.divide(after, before, out=numpy.ones_like(before), where=before > 0)


def deep_smoke(frame, gains):
    """The smoke as a deep picture. A pixel changes alike at all of its depths, as by Nuke's DeepRecolor: that is exact
    where nothing is put between them, and elsewhere as far as its lights are mixed alike along the ray."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "smoke.exr"))
        frame.write_deep(path)
        deep = oiio.ImageBuf(path)
        deep.read(0, 0, True)  # all of it, before the folder goes
    window, part = deep.roi, relit_part(frame, gains)
    for y in range(window.ybegin, window.yend):
        for x in range(window.xbegin, window.xend):
            for sample in range(deep.deep_samples(x, y)):
                for channel in range(3):
                    value = deep.deep_value(x, y, 0, channel, sample)
                    deep.set_deep_value(x, y, 0, channel, sample, value * float(part[y, x, channel]))
    return deep


def merged(smoke, solids):
    """Sample by sample, those of the smoke cut where a solid stands in it."""
    both = oiio.ImageBufAlgo.deep_merge(smoke, solids)
    flat = oiio.ImageBufAlgo.flatten(both)
    for picture in (both, flat):
        if picture.has_error:
            raise SystemExit(f"composite.py: {picture.geterror()}")
    return oiio.ImageBufAlgo.channels(flat, ("R", "G", "B", "A"))


def main():
    stage, solids, out, frame, *lights = sys.argv[1:]
    gains = {name: [float(v) for v in rgb.split(",")] for name, rgb in (light.split("=") for light in lights)}
    shot = scrim.usd.open(stage, LAYERS, meshes="none")  # the solids come from the other picture
    rendered = shot.render(int(frame))
    for warning in shot.warnings:
        print(warning, file=sys.stderr)
    picture = merged(deep_smoke(rendered, gains), oiio.ImageBuf(solids))
    if not picture.write(out):
        raise SystemExit(f"composite.py: {picture.geterror()}")
    print(out)


if __name__ == "__main__":
    main()
