# SPDX-License-Identifier: Apache-2.0
"""The scene of peers.py in Mitsuba 3. Runs in a Python that has Mitsuba and NumPy:

    python peers_mitsuba.py NUMBERS.json OUT.exr SAMPLES [VARIANT [INTEGRATOR]]

Prints the seconds that rendering took. If NUMBERS say "twice", a picture of one sample is rendered before, for the
compiler of variants that compile (llvm_ad_rgb, the default), and not counted: its code serves any number of samples.
Depth 2 is single scattering; NUMBERS may have "bounces" after it, "g" of the phase function, and the radiance of an even
"sky". Where "volumes" is a list, peers_media.py makes media of it, in variants that compile. A pixel is the mean of its
own samples (a box filter), and in variants that compile they all go through its middle, as everybody else's do. Where
DrJit finds no LLVM that it can use, DRJIT_LIBLLVM_PATH names one: 15 is too old for Mitsuba 3.9, that of Debian's
libllvm19 serves.
"""
import json
import sys
import time

import drjit as dr
import mitsuba as mi
import numpy as np
import peers_exr

PASS = 64  # samples of one pass: memory grows with them


def transform(numbers, shape):
    """From the unit cube, which the voxels fill, to the world: a voxel ends half a voxel from its centre."""
    size = [numbers["voxel"] * n for n in shape]
    corner = [o - 0.5 * numbers["voxel"] for o in numbers["origin"]]
    return mi.ScalarTransform4f().translate(corner).scale(size)


def medium(numbers):
    array = np.load(numbers["array"])  # [x, y, z]
    data = mi.VolumeGrid(np.ascontiguousarray(array.transpose(2, 1, 0))[..., None])
    to_world = transform(numbers, array.shape)
    density = {"type": "gridvolume", "grid": data, "raw": True, "filter_type": "trilinear", "wrap_mode": "clamp",
               "to_world": to_world}
    interior = {"type": "heterogeneous", "albedo": {"type": "constvolume", "value": numbers["albedo"]},
                "sigma_t": density, "scale": numbers["scale"], "phase": {"type": "hg", "g": numbers.get("g", 0)}}
    # A cube of Mitsuba's reaches from -1 to 1.
    return {"type": "cube", "to_world": to_world @ mi.ScalarTransform4f().translate([0.5] * 3).scale([0.5] * 3),
            "bsdf": {"type": "null"}, "interior": interior}


def camera_to_world(numbers):
    target = [e + l for e, l in zip(numbers["eye"], numbers["look"])]
    return mi.ScalarTransform4f().look_at(origin=numbers["eye"], target=target, up=[0, 1, 0])


def perspective(numbers, film):
    return {"type": "perspective", "fov": numbers["fov"], "fov_axis": "x", "near_clip": 1e-3, "far_clip": 1e5,
            "to_world": camera_to_world(numbers), "film": film}


def through_middles(numbers, film):
    """A camera that rounds each sample's place to the middle of its pixel."""
    class Middles(mi.Sensor):
        def __init__(self, props):
            self.inner = mi.load_dict(perspective(numbers, film))
            super().__init__(props)

        def middle(self, place):
            size = mi.Vector2f(numbers["resolution"])
            return (dr.floor(place * size) + 0.5) / size

        def sample_ray(self, when, wavelength, place, aperture, active=True):
            return self.inner.sample_ray(when, wavelength, self.middle(place), aperture, active)

        def sample_ray_differential(self, when, wavelength, place, aperture, active=True):
            return self.inner.sample_ray_differential(when, wavelength, self.middle(place), aperture, active)

        def bbox(self):
            return self.inner.bbox()

    mi.register_sensor("middles", Middles)
    return {"type": "middles", "film": film}


def scene_of(numbers, integrator):
    width, height = numbers["resolution"]
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgba", "component_format": "float32",
            "rfilter": {"type": "box"}}
    # A camera in Python works on whole arrays of rays, which the scalar variants do not have.
    sensor = (perspective if "scalar" in mi.variant() else through_middles)(numbers, film)
    if "volumes" in numbers:
        import peers_media  # its class of media needs a variant
        shapes, around_eye = peers_media.media(numbers)
    else:
        shapes, around_eye = {"volume": medium(numbers)}, None
    return mi.load_dict({
        "type": "scene", **shapes,
        "integrator": {"type": integrator, "max_depth": 2 + numbers.get("bounces", 0), "rr_depth": 1000,
                       "hide_emitters": True},
        "sun": {"type": "directional", "direction": numbers["light"],
                "irradiance": {"type": "rgb", "value": [numbers["irradiance"]] * 3}},
        **({"sky": {"type": "constant", "radiance": {"type": "rgb", "value": [numbers["sky"]] * 3}}}
           if numbers.get("sky") else {}),
        "sensor": sensor | {"sampler": {"type": "independent"}} | ({"medium": around_eye} if around_eye else {})})


def render(scene, samples, seed):
    """The mean of as many passes as it takes, and the seconds by the clock and of all processors."""
    begin, begin_processor, total = time.monotonic(), time.process_time(), None
    for i in range(max(1, samples // PASS)):
        image = mi.render(scene, spp=min(samples, PASS), seed=seed + i)
        part = np.array(image)
        total = part if total is None else total + part
    return total / max(1, samples // PASS), time.monotonic() - begin, time.process_time() - begin_processor


def main():
    numbers_file, picture, samples, *more = sys.argv[1:]
    variant, integrator = (*more, *("llvm_ad_rgb", "volpath")[len(more):])
    with open(numbers_file) as file:
        numbers = json.load(file)
    mi.set_variant(variant)
    dr.set_thread_count(numbers["threads"])
    scene = scene_of(numbers, integrator)
    samples, seed = int(samples), 100000 * numbers["seed"]
    if numbers["twice"] and "scalar" not in variant:
        _, seconds, _ = render(scene, 1, seed)
        print(f"compile and first sample {seconds}")
    image, seconds, processor = render(scene, samples, seed)
    peers_exr.write(picture, image)
    print(f"render {seconds}\nprocessor {processor}")


main()
