# SPDX-License-Identifier: Apache-2.0
"""The scene of peers.py in LuxCore. Runs in a Python that has pyluxcore and NumPy:

    python peers_luxcore.py NUMBERS.json OUT.exr SAMPLES STEP

Prints the seconds that rendering took, from the start of the session to its last sample. STEP is in voxels: LuxCore
marches, and takes the medium for even within a step. It finds voxel i of n at i / n of its texture's unit cube, while
others see voxels' centres there, so the texture is placed by the centre of the first voxel.
"""
import json
import sys
import time

import numpy as np
import peers_exr
import pyluxcore


def box(low, high):
    """Vertices and triangles, which look outwards."""
    points = [tuple((low, high)[i >> a & 1][a] for a in range(3)) for i in range(8)]
    quads = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def properties(values):
    result = pyluxcore.Properties()
    for key, value in values.items():
        result.Set(pyluxcore.Property(key, value))
    return result


def medium(numbers, step):
    array, voxel = np.load(numbers["array"]), numbers["voxel"]
    size, low = [n * voxel for n in array.shape], numbers["origin"]
    x, y, z = (1 / s for s in size)
    # From the world to the unit cube, column by column.
    to_cube = [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, *(-o / s for o, s in zip(low, size)), 1]
    values = {"scene.textures.grid.type": "densitygrid", "scene.textures.grid.storage": "float",
              "scene.textures.grid.wrap": "black", "scene.textures.grid.mapping.type": "globalmapping3d",
              "scene.textures.grid.mapping.transformation": to_cube,
              "scene.textures.grid.data": array.transpose(2, 1, 0).ravel().tolist()}
    values |= {f"scene.textures.grid.n{a}": n for a, n in zip("xyz", array.shape)}
    for name, part in (("scattering", numbers["albedo"]), ("absorption", 1 - numbers["albedo"])):
        values |= {f"scene.textures.{name}.type": "scale", f"scene.textures.{name}.texture1": "grid",
                   f"scene.textures.{name}.texture2": part * numbers["scale"],
                   f"scene.volumes.medium.{name}": name}
    return values | {"scene.volumes.medium.type": "heterogeneous", "scene.volumes.medium.asymmetry": [0.0] * 3,
                     "scene.volumes.medium.multiscattering": False, "scene.volumes.medium.steps.size": step * voxel,
                     "scene.volumes.medium.steps.maxcount": 65536,
                     "scene.materials.border.type": "null", "scene.materials.border.volume.interior": "medium"}


def scene_of(numbers, step):
    scene = pyluxcore.Scene()
    size = np.load(numbers["array"], mmap_mode="r").shape
    low = numbers["origin"]
    points, triangles = box(low, [o + (n - 1) * numbers["voxel"] for o, n in zip(low, size)])
    scene.DefineMesh("box", points, triangles, None, None, None, None)
    target = [e + l for e, l in zip(numbers["eye"], numbers["look"])]
    scene.Parse(properties(medium(numbers, step) | {
        "scene.objects.box.shape": "box", "scene.objects.box.material": "border",
        "scene.lights.sun.type": "sharpdistant", "scene.lights.sun.direction": list(numbers["light"]),
        "scene.lights.sun.color": [1.0] * 3, "scene.lights.sun.gain": [float(numbers["irradiance"])] * 3,
        "scene.camera.type": "perspective", "scene.camera.lookat.orig": list(numbers["eye"]),
        "scene.camera.lookat.target": target, "scene.camera.up": [0.0, 1.0, 0.0],
        "scene.camera.fieldofview": float(numbers["fov"]), "scene.camera.lensradius": 0.0,
        "scene.camera.cliphither": 1e-3, "scene.camera.clipyon": 1e5}))
    return scene


def main():
    numbers_file, picture, samples, step = sys.argv[1:]
    with open(numbers_file) as file:
        numbers = json.load(file)
    width, height = numbers["resolution"]
    pyluxcore.Init()
    scene = scene_of(numbers, float(step))
    config = properties({
        "renderengine.type": "PATHCPU", "renderengine.seed": 1 + numbers["seed"], "sampler.type": "SOBOL",
        "native.threads.count": numbers["threads"], "film.width": width, "film.height": height,
        "film.filter.type": "NONE", "film.imagepipelines.0.0.type": "NOP", "path.pathdepth.total": 2,
        "path.pathdepth.diffuse": 2, "path.pathdepth.glossy": 2, "path.pathdepth.specular": 8,
        "path.russianroulette.depth": 100, "path.clamping.variance.maxvalue": 0.0,
        "path.hybridbackforward.enable": False,
        "lightstrategy.type": "UNIFORM", "batch.haltspp": int(samples), "batch.halttime": 0})
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(config, scene))
    begin = time.monotonic()
    session.Start()
    while not session.HasDone():
        time.sleep(0.005)
        session.UpdateStats()
    seconds = time.monotonic() - begin
    session.Stop()
    rgb = np.zeros((height, width, 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, rgb, 0)
    image = np.zeros((height, width, 4), np.float32)
    image[:-1, :, :3] = rgb[-2::-1]  # its rows begin at the bottom, and show what is one row further up
    peers_exr.write(picture, image)
    print(f"render {seconds}")


main()
