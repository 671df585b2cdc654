# SPDX-License-Identifier: Apache-2.0
"""Deep pictures of what moves while the shutter is open."""

import numpy
import OpenImageIO
import pytest

import scrim

TOLERANCE = 0.002
COUNT = 4  # moments
DEPTHS = (7.2, 8.2, 8.9, 9.6, 10.5, 11.5, 12.1, 14)

# A ball that passes in front of a slab.
SCENE = f"""
[camera]
type = "orthographic"
height = 4
position = [0, 0, 10]
target = [0, 0, 0]
resolution = [24, 16]

[[volume]]
name = "ball"
source = "primitives"
parameters = {{ shapes = "sphere radius=0.8", voxel = 0.1 }}
density = {{ scale = 2 }}
transform = {{ translate = PLACE }}

[[volume]]
name = "slab"
source = "primitives"
parameters = {{ shapes = "box size=4,4,1", voxel = 0.2 }}
density = {{ scale = 0.7 }}
transform = {{ translate = [0, 0, -2] }}

[[light]]
name = "key"
type = "distant"
direction = [1, 0, -1]
intensity = 8

[render]
texel = 0.7
sheet_thickness = 0.7
shutter_samples = {COUNT}

[output]
type = "float"
deep_type = "float"
deep_tolerance = {TOLERANCE}
"""


def render(tmp_path, place, shutter, name):
    """The flat picture, and the samples of each pixel from front to back: Z, ZBack, R, G, B, A."""
    path = tmp_path / f"{name}.exr"
    shot = scrim.loads(SCENE.replace("PLACE", place), {"output.deep": str(path), **shutter})
    frame = shot.render(1)
    frame.write_deep()
    file = OpenImageIO.ImageInput.open(str(path))
    spec, data = file.spec(), file.read_native_deep_image(0, 0)
    channels = [spec.channelnames.index(c) for c in ("Z", "ZBack", "R", "G", "B", "A")]
    whole = numpy.array(frame["beauty"])
    samples = {}
    for y in range(spec.height):
        for x in range(spec.width):
            pixel = y * spec.width + x
            samples[x + spec.x, y + spec.y] = [
                [data.deep_value(pixel, c, i) for c in channels] for i in range(data.samples(pixel))]
    return whole, samples


def shown_before(samples, depth):
    """R, G, B and A of what lies in front of a depth, by OpenEXR's rules for volume samples."""
    shown = numpy.zeros(4)
    for near, far, *rgba in samples:
        rgba, part = numpy.array(rgba), min(max((depth - near) / (far - near), 0), 1)
        alpha = rgba[3]
        if part < 1:
            rgba = rgba * ((1 - (1 - alpha) ** part) / alpha if alpha > 0 else part)
        shown += (1 - shown[3]) * rgba
    return shown


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("deep")
    shutter = {"camera.shutter": [-0.5, 0.5]}
    moved = render(folder, "{ keys = [[0, [-1, 0, 1]], [2, [1, 0, 1]]] }", shutter, "moved")
    places = [(i + 0.5) / COUNT - 0.5 for i in range(COUNT)]
    return moved, [render(folder, f"[{x}, 0, 1]", {}, f"still{i}") for i, x in enumerate(places)]


def test_a_cut_at_any_depth_shows_the_mean_of_the_moments(pictures):
    (_, moved), stills = pictures
    pixels = sorted(set(moved).intersection(*(samples for _, samples in stills)))
    assert len(pixels) > 100
    most = max(shown_before(moved[p], 20)[:3].max() for p in pixels)
    halves = 0
    for pixel in pixels:
        for depth in DEPTHS:
            mean = sum(shown_before(samples[pixel], depth) for _, samples in stills) / COUNT
            shown = shown_before(moved[pixel], depth)
            # Moments and their mean have half of the tolerance each; the stills have all of it.
            assert abs(shown[3] - mean[3]) <= 2 * TOLERANCE + 1e-5, (pixel, depth)
            assert abs(shown[:3] - mean[:3]).max() <= 2 * TOLERANCE * most + 1e-5, (pixel, depth)
        halves += 0.2 < shown_before(moved[pixel], 10.5)[3] < 0.6
    assert halves > 10, "the ball is there for a part of the time"


def test_it_flattens_to_the_flat_picture(pictures):
    (flat, moved), _ = pictures
    for (x, y), samples in moved.items():
        assert numpy.allclose(shown_before(samples, numpy.inf), flat[y, x], atol=2e-5), (x, y)
