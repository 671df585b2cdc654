# SPDX-License-Identifier: Apache-2.0
# Blender and Scrim's Python module in one process: together.py FIRST SECOND, which are bpy and scrim. Both have OpenVDB,
# OpenEXR, TBB, OpenColorIO and Embree, in versions of their own. Each reads the other's volume, and each renders.
import importlib
import os
import sys
import tempfile

for name in sys.argv[1:]:
    importlib.import_module(name)

import bpy  # noqa: E402
import numpy  # noqa: E402
import scrim  # noqa: E402

SCENE = {
    "camera": {"position": [0, 0, 5], "target": [0, 0, 0], "resolution": [48, 48]},
    "volume": [{"source": "noise", "parameters": {"resolution": 32}, "density": {"scale": 25}}],
    "light": [{"type": "distant", "direction": [0.6, -0.5, -0.6], "intensity": 4.5}],
}


def by_scrim(folder):
    frame = scrim.loads(SCENE).render(verify=50)
    assert frame.image[:, :, 3].max() > 0.3 and frame.error < 0.02, frame.error
    frame.write(os.path.join(folder, "scrim.exr"))
    return numpy.array(frame.image)


def by_blender(folder, vdb):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    data = bpy.data.volumes.new("smoke")
    data.filepath = vdb
    assert data.grids.load() and [grid.name for grid in data.grids] == ["density"]
    scene.collection.objects.link(bpy.data.objects.new("smoke", data))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (1, 1, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.join(folder, "blender.exr")
    bpy.ops.render.render(write_still=True)
    assert os.path.getsize(scene.render.filepath) > 0
    picture = bpy.data.images.load(os.path.join(folder, "scrim.exr"))
    assert max(picture.pixels[:]) > 0.3


with tempfile.TemporaryDirectory() as work:
    smoke = os.path.join(work, "smoke.vdb")
    os.spawnv(os.P_WAIT, os.environ["SCRIM"], ["scrim", "make", "noise", "resolution=32", "-q", "-o", smoke])
    first = by_scrim(work)
    by_blender(work, smoke)
    field = scrim.read_vdb(smoke)
    assert field is not None
    assert (by_scrim(work) == first).all()  # and Blender's libraries changed nothing of it
print("together", *sys.argv[1:])
