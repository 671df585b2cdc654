# SPDX-License-Identifier: Apache-2.0
# The scene of peers.py or octaves.py in Cycles. Blender runs this, or a Python that has bpy:
#     blender -b --factory-startup -t THREADS -P peers_cycles.py -- NUMBERS.json OUT.exr SAMPLES STEP_RATE [ADAPTIVE]
#     python peers_cycles.py -- NUMBERS.json OUT.exr SAMPLES STEP_RATE [ADAPTIVE]
# STEP_RATE 0 is for Blender 5 and later: no steps, but null collisions. ADAPTIVE is the noise at which a pixel gets no
# more samples (0, the default: all get as many).
# As little as possible is asked of Cycles: a sun without a size, no clamping, no denoiser, and a pixel filter so narrow
# that all samples go through the middle of the pixel, as everybody else's do. NUMBERS may hold more than those of
# peers.py: "g" of the phase function (0), "bounces" after the first scattering (0: single scattering), "sky" (the
# radiance of an even one, 0), "denoise" (by OpenImageDenoise, False), "seed" (0),
# "threads" (0: as Blender was told), and "twice": a picture of one sample is rendered before, and what Cycles made of
# the scene is kept for the second, whose seconds are then printed: they are those of rendering alone. Where "volumes"
# is a list, each of its entries has a volume's own numbers ("asset", "grid", "voxel", "scale"), is enlarged by "size"
# (1), and then moved by "translate".
import json
import math
import os
import sys
import time

import bpy
from mathutils import Matrix, Vector

numbers_file, picture, samples, step_rate, *adaptive = sys.argv[sys.argv.index("--") + 1:]
with open(numbers_file) as file:
    numbers = json.load(file)

scene = bpy.context.scene
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)


def clocks():
    """By the clock, and of all processors."""
    return time.monotonic(), time.process_time()


def place(name, data, matrix=Matrix()):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.matrix_world = matrix
    return thing


def looking(direction):
    """A frame that looks along -z, y up, as cameras and suns do."""
    back = -Vector(direction).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    return Matrix((right, back.cross(right), back)).transposed().to_4x4()


def medium(volume):
    """A material that scatters and absorbs what the grid holds, times a scale."""
    material = bpy.data.materials.new("medium")
    material.use_nodes = True
    material.cycles.volume_sampling = "DISTANCE"
    tree = material.node_tree
    tree.nodes.clear()
    grid = tree.nodes.new("ShaderNodeAttribute")
    grid.attribute_name = volume["grid"]
    both = tree.nodes.new("ShaderNodeAddShader")
    parts = (("ShaderNodeVolumeScatter", (1, 1, 1, 1), numbers["albedo"]),
             ("ShaderNodeVolumeAbsorption", (0, 0, 0, 1), 1 - numbers["albedo"]))
    for i, (kind, colour, part) in enumerate(parts):
        node = tree.nodes.new(kind)
        node.inputs["Color"].default_value = colour
        scale = tree.nodes.new("ShaderNodeMath")
        scale.operation = "MULTIPLY"
        scale.inputs[1].default_value = part * volume["scale"]
        tree.links.new(grid.outputs["Fac"], scale.inputs[0])
        tree.links.new(scale.outputs[0], node.inputs["Density"])
        tree.links.new(node.outputs[0], both.inputs[i])
        if "Anisotropy" in node.inputs:
            node.inputs["Anisotropy"].default_value = numbers.get("g", 0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(both.outputs[0], output.inputs["Volume"])
    return material


def read_volume(volume):
    data = bpy.data.volumes.new("volume")
    data.filepath = volume["asset"]
    data.render.precision = "FULL"
    data.render.clipping = 0
    data.render.space = "WORLD"  # extinction stays what it is where a volume is scaled
    data.materials.append(medium(volume))
    return data


read = {}
for volume in numbers.get("volumes", [numbers]):
    key = volume["asset"], volume["scale"]
    if key not in read:
        read[key] = read_volume(volume)
    # Before 5.0, Cycles takes a voxel's index for a corner of it, and draws grids half a voxel too high on each axis.
    half_voxel = 0.5 * volume["voxel"] if bpy.app.version < (5, 0) else 0
    place("volume", read[key], Matrix.Translation(volume.get("translate", (0, 0, 0)))
          @ Matrix.Scale(volume.get("size", 1), 4) @ Matrix.Translation((-half_voxel,) * 3))

sun = bpy.data.lights.new("key", "SUN")
sun.energy = numbers["irradiance"]
sun.angle = 0
place("key", sun, looking(numbers["light"]))
scene.world = None
if numbers.get("sky"):
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = numbers["sky"]

camera = bpy.data.cameras.new("camera")
camera.sensor_fit = "HORIZONTAL"
camera.angle = math.radians(numbers["fov"])
camera.clip_end = 1e6
scene.camera = place("camera", camera, Matrix.Translation(numbers["eye"]) @ looking(numbers["look"]))

render = scene.render
render.engine = "CYCLES"
render.resolution_x, render.resolution_y = numbers["resolution"]
render.resolution_percentage = 100
render.film_transparent = True
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
render.image_settings.exr_codec = "NONE"
scene.view_settings.view_transform = "Raw"
scene.cycles.device = "CPU"
scene.cycles.samples = int(samples)
scene.cycles.use_adaptive_sampling = bool(adaptive) and float(adaptive[0]) > 0
if scene.cycles.use_adaptive_sampling:
    scene.cycles.adaptive_threshold = float(adaptive[0])
scene.cycles.use_denoising = numbers.get("denoise", False)
scene.cycles.seed = numbers.get("seed", 0)
scene.cycles.volume_bounces = numbers.get("bounces", 0)
if scene.cycles.volume_bounces > 0:
    scene.cycles.max_bounces = scene.cycles.volume_bounces
    scene.cycles.light_sampling_threshold = 0  # or weak light is left to chance, at every bounce
scene.cycles.volume_step_rate = float(step_rate) or 1
if hasattr(scene.cycles, "volume_biased"):
    scene.cycles.volume_biased = float(step_rate) > 0
scene.cycles.volume_max_steps = 65536
scene.cycles.transparent_max_bounces = 1024  # each gap of the volume is one, and behind too many all is dark
scene.cycles.sample_clamp_indirect = 0
scene.cycles.pixel_filter_type = "GAUSSIAN"
scene.cycles.filter_width = 0.01
if numbers.get("threads"):
    render.threads_mode, render.threads = "FIXED", numbers["threads"]
if numbers.get("twice"):
    render.use_persistent_data, scene.cycles.samples = True, 1
    bpy.ops.render.render()
    scene.cycles.samples = int(samples)
    scene.update_tag()
    bpy.context.view_layer.update()

# Cycles 5 builds an octree for each picture, whatever is kept: seconds count from the first sample on, as its status
# tells. Before 5.0 the status says so to nobody but the terminal.
status = {}
if bpy.app.version >= (5, 0):
    bpy.app.handlers.render_stats.append(lambda text, _: status.setdefault("Sample 0/" in text, clocks()))
begin = clocks()
bpy.ops.render.render()
end, begin = clocks(), status.get(True, begin)
print("render", end[0] - begin[0])
print("processor", end[1] - begin[1])
bpy.data.images["Render Result"].save_render(picture)
sys.stdout.flush()
if not bpy.app.binary_path:
    os._exit(0)  # as a module it may hang where Python takes it apart
