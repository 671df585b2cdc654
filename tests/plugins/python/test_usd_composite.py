# SPDX-License-Identifier: Apache-2.0
"""examples/python/composite.py: a stage, its layers, and a card in the middle of the smoke."""

import math
import subprocess
import sys

import numpy
import pytest
from conftest import ROOT

pytest.importorskip("pxr", reason="usd-core is not installed")
oiio = pytest.importorskip("OpenImageIO", reason="openimageio is not installed")

from pxr import Gf, Sdf, UsdRender  # noqa: E402
from usd_stages import ALBEDO, TAU, Stage, write_fog  # noqa: E402

CARD = (0.2, 0.4, 0.6, 1.0)


def write_card(path, size, depth):
    """An opaque deep picture of one colour, of the right half of the frame."""
    spec = oiio.ImageSpec(size, size, 6, "float")
    spec.channelnames = ("R", "G", "B", "A", "Z", "ZBack")
    spec.deep = True
    data = oiio.DeepData()
    data.init(size * size, 6, [oiio.TypeFloat] * 6, spec.channelnames)
    for pixel in range(size * size):
        if pixel % size >= size // 2:
            data.set_samples(pixel, 1)
            for channel, value in enumerate((*CARD, depth, depth)):
                data.set_deep_value(pixel, channel, 0, value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec) and file.write_deep_image(data), file.geterror()
    file.close()


@pytest.mark.parametrize("lights", [1, 2])
def test_a_card_in_relit_fog(tmp_path, python_path, lights):
    size = 32
    write_fog(tmp_path)
    stage = Stage(tmp_path)
    stage.camera()
    stage.volume()
    stage.light("DistantLight", intensity=1.0, angle=0.0)
    if lights == 2:
        stage.light("DistantLight", "/back", intensity=3.0, angle=0.0).AddRotateYOp().Set(180.0)
    settings = UsdRender.Settings.Define(stage.stage, "/rs")
    settings.GetResolutionAttr().Set(Gf.Vec2i(size, size))
    stage.say(settings, "render:quality", Sdf.ValueTypeNames.Token, "ultra")
    stage.stage.SetMetadata("renderSettingsPrimPath", "/rs")
    stage.stage.Save()
    write_card(tmp_path / "card.exr", size, 50.0)  # in the middle of the fog
    run = [sys.executable, ROOT / "examples/python/composite.py", "shot.usda", "card.exr", "out.exr", "1"]
    gains = ["key=2,1,0.5", "back=0,0,0"][:lights]
    done = subprocess.run([*map(str, run), *gains], cwd=tmp_path, env=python_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == "out.exr\n", done.stderr
    picture = oiio.ImageBuf(str(tmp_path / "out.exr"))
    before, beside = (numpy.array(picture.getpixel(x, 16)) for x in (20, 11))

    def fog(tau):
        light = ALBEDO / (8 * math.pi) * (1 - math.exp(-2 * tau))
        return numpy.array([2 * light, light, 0.5 * light, 1 - math.exp(-tau)])

    assert beside == pytest.approx(fog(TAU), rel=0.01)
    expected = fog(TAU / 2) + math.exp(-TAU / 2) * numpy.array(CARD)
    # A second light is mixed otherwise in front of the card than behind it.
    assert before == pytest.approx(expected, rel=0.01 if lights == 1 else 0.06)
