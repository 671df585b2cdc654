# SPDX-License-Identifier: Apache-2.0
# Scenes for bpy, made from nothing, and pictures as arrays. Whoever imports this has the add-on registered.
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
import scrim  # noqa: E402
from scrim import exr  # noqa: E402

if not hasattr(bpy.types.Scene, "scrim"):
    scrim.register()


def fresh(resolution=(64, 64)):
    """An empty scene for Scrim, with a camera at (0, -4, 0.5) that looks at the origin."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return begun(resolution)


def cleared(resolution=(64, 64)):
    """The same without another file, which Blender with a window does not survive in a timer."""
    for things in (bpy.data.objects, bpy.data.volumes, bpy.data.lights, bpy.data.cameras, bpy.data.materials):
        for thing in list(things):
            things.remove(thing)
    return begun(resolution)


def begun(resolution):
    scene = bpy.context.scene
    if scene.world is None:
        scene.world = bpy.data.worlds.new("World")
    sky((0, 0, 0))
    scene.render.engine = "SCRIM"
    scene.scrim.scattering = "SINGLE"  # as Cycles with 0 volume bounces
    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Raw"
    data = bpy.data.cameras.new("camera")
    data.lens, data.sensor_width = 50, 36
    scene.camera = place("camera", data, looking((0, -4, 0.5), (0, 0, 0)))
    return scene


def sky(color):
    """The world shines with one colour."""
    world = bpy.context.scene.world
    world.use_nodes = False
    world.color = color
    if world.use_nodes:  # from Blender 5.0 on there is no other way
        node = next(n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground")
        node.inputs["Color"].default_value = (*color, 1)


def place(name, data, matrix=Matrix()):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    thing.matrix_world = matrix
    return thing


def looking(eye, target):
    """A frame at `eye` that looks along -z at `target`, as cameras and lights do."""
    turn = (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    return Matrix.Translation(eye) @ turn


def volume(path, matrix=Matrix(), name="volume", **inputs):
    """A Volume object with a Principled Volume, of which `inputs` sets sockets ("Emission_Color" for two words)."""
    data = bpy.data.volumes.new(name)
    data.filepath = str(path)
    data.render.precision, data.render.space, data.render.clipping = "FULL", "WORLD", 0
    thing = place(name, data, matrix)
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeVolumePrincipled")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Volume"])
    for key, value in inputs.items():
        socket = shader.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1) if isinstance(value, tuple) else value
    data.materials.append(material)
    return thing


def light(kind, eye, target=(0, 0, 0), name="key", **values):
    data = bpy.data.lights.new(name, kind)
    for key, value in values.items():
        setattr(data, key, value)
    return place(name, data, looking(eye, target))


def render(path):
    """Renders into a multi-layer EXR and gives its channels, "Combined.R" and so on, rows from the top."""
    settings = bpy.context.scene.render
    if hasattr(settings.image_settings, "media_type"):  # from Blender 5.0 on
        settings.image_settings.media_type = "MULTI_LAYER_IMAGE"
        settings.image_settings.use_exr_interleave = True  # one part
    settings.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.image_settings.color_depth = "32"
    settings.image_settings.exr_codec = "NONE"
    settings.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    picture = exr.read(str(path))
    left, top, right, bottom = picture.display_window
    size = (left, top, right - left + 1, bottom - top + 1)
    return {name.partition(".")[2]: picture.region(name, *size) for name in picture.channels}


def rgb(channels, name="Combined"):
    return np.stack([channels[f"{name}.{c}"] for c in "RGB"], axis=-1)


def cycles_shift(data):
    """What Cycles of Blender 4.5 adds to places of grids: half a voxel along each axis. It takes a voxel's index for
    a corner of the voxel, where OpenVDB means its middle. From 5.0 on it does not."""
    if bpy.app.version >= (5, 0):
        return Vector((0, 0, 0))
    data.grids.load()
    return data.grids[0].matrix_object.to_3x3() @ Vector((0.5, 0.5, 0.5))


def cycles(samples, seed=0):
    """The same scene for Cycles: single scattering, small steps, no filter beyond a pixel's middle."""
    scene = bpy.context.scene
    if scene.render.engine != "CYCLES":
        for thing in scene.objects:
            if thing.type == "VOLUME":
                thing.matrix_world = thing.matrix_world @ Matrix.Translation(-cycles_shift(thing.data))
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.device, settings.samples, settings.seed = "CPU", samples, seed
    settings.use_adaptive_sampling = settings.use_denoising = False
    settings.volume_bounces = settings.max_bounces = 0
    settings.volume_step_rate, settings.volume_max_steps = 0.2, 65536
    if hasattr(settings, "volume_biased"):  # from Blender 5.0 on: march by steps, as before
        settings.volume_biased = True
    settings.sample_clamp_direct = settings.sample_clamp_indirect = 0
    settings.light_sampling_threshold = 0
    settings.pixel_filter_type, settings.filter_width = "GAUSSIAN", 0.01


def means(image, size=8):
    """Means over size x size pixels."""
    height, width = image.shape[0] // size * size, image.shape[1] // size * size
    tiles = image[:height, :width].reshape(height // size, size, width // size, size, -1)
    return tiles.mean((1, 3))


def difference(image, truth):
    """Relative RMSE of means over 8 x 8 pixels."""
    a, b = means(image), means(truth)
    return float(math.sqrt(((a - b) ** 2).mean() / (b**2).mean()))
