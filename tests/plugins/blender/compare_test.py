# SPDX-License-Identifier: Apache-2.0
# Scrim's pictures of Blender's scenes beside Cycles' of the same: each law of light, medium and camera on its own.
# What is compared are means over 8 x 8 pixels; Cycles' noise in them is measured with a second seed, and has to be
# small.
#   python compare_test.py [-k CASE] [--table TABLE.md] [--pictures FOLDER]
import argparse
import math
import os
import re
import subprocess
import sys
import tempfile
import time

import graphs
import numpy as np
import scenes as s

WORK = tempfile.mkdtemp(prefix="scrim-compare-")
SMOKE, BALL, FINE = (os.path.join(WORK, f"{name}.vdb") for name in ("smoke", "ball", "fine"))
LIMIT = 0.015
MOST_NOISE = 0.007  # of a mean over two seeds, measured by their difference
SCRIM = os.environ["SCRIM"]


def make(source, *parameters, path):
    subprocess.run([SCRIM, "make", source, *parameters, "-o", path, "-q"], check=True, timeout=120)


def smoke(path=SMOKE, **inputs):
    inputs = {"Density": 4.0, "Color": (0.8, 0.8, 0.8), **inputs}
    return s.volume(path, **inputs)


def soft():
    """Sub-lights for 1 % and not for 0.5 %: a quarter of the time."""
    s.bpy.context.scene.scrim.overrides = "render.light_error=0.01"


def glowing(path=SMOKE, **inputs):
    """Black smoke: what glows is a light for Cycles, also without bounces."""
    key()
    return smoke(path, Color=(0.0, 0.0, 0.0), **inputs)


def key():
    s.light("SUN", (3, -2, 3), energy=4.0, angle=0.0)


def sun():
    smoke(), key()


def soft_sun():
    soft()
    smoke(), s.light("SUN", (3, -2, 3), energy=4.0, angle=math.radians(40))


def anisotropy():
    smoke(Anisotropy=0.6), key()


def colors():
    smoke(Color=(0.9, 0.5, 0.2), Absorption_Color=(0.1, 0.4, 0.6)), key()


def point():
    smoke(), s.light("POINT", (1.0, -1.2, 1.2), energy=60.0, shadow_soft_size=0.0)


def point_radius():
    s.bpy.context.scene.scrim.overrides = "light.key.samples=60"
    hard = {"use_soft_falloff": False} if s.bpy.app.version >= (4, 1) else {}
    smoke(), s.light("POINT", (1.5, -1.8, 1.8), energy=120.0, shadow_soft_size=0.4, **hard)


def spot():
    smoke(), s.light("SPOT", (1.5, -1.5, 1.5), energy=150.0, shadow_soft_size=0.0, spot_size=0.6, spot_blend=0.5)


def area_rectangle():
    soft()
    smoke(), s.light("AREA", (1.8, -1.5, 1.8), energy=120.0, shape="RECTANGLE", size=1.5, size_y=0.7)


def area_disk():
    soft()
    smoke(), s.light("AREA", (1.8, -1.5, 1.8), energy=120.0, shape="DISK", size=1.2)


def light_values():
    soft()
    smoke()
    s.light("AREA", (1.8, -1.5, 1.8), energy=6.0, shape="SQUARE", normalize=False, exposure=2.0, color=(1, 0.5, 0.2))
    s.light("SUN", (-3, -2, 3), name="warm", energy=2.0, angle=0.0, use_temperature=True, temperature=3500.0)


def sky():
    soft()
    smoke()
    s.sky((0.2, 0.4, 0.8))


def sky_picture():
    """Bright from one side, so that a wrong turn shows."""
    soft()
    smoke()
    image = s.bpy.data.images.new("sky", 64, 32, float_buffer=True)
    pixels = np.full((32, 64, 4), 0.05, np.float32)
    pixels[14:24, 40:52, :3] = (3.0, 2.0, 1.0)
    image.pixels.foreach_set(pixels.reshape(-1))
    world = s.bpy.context.scene.world
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    names = ("TexCoord", "Mapping", "TexEnvironment", "Background", "OutputWorld")
    nodes = [tree.nodes.new(f"ShaderNode{name}") for name in names]
    nodes[1].inputs["Rotation"].default_value = (0, 0, 0.6)
    nodes[2].image = image
    for source, target, socket in (
        (nodes[0].outputs["Generated"], 1, "Vector"),
        (nodes[1].outputs[0], 2, "Vector"),
        (nodes[2].outputs[0], 3, "Color"),
        (nodes[3].outputs[0], 4, "Surface"),
    ):
        tree.links.new(source, nodes[target].inputs[socket])


def blackbody():
    """A ball of one temperature, since the programs differ in what comes first: Scrim turns temperatures of voxels into
    light and goes between these, Cycles goes between temperatures. So hot that no colour is beyond Rec.709, where
    Cycles has negative light and Scrim none."""
    glowing(BALL, Temperature=2800.0, Temperature_Attribute="density", Blackbody_Intensity=2.0, Density=1.0)


def emission():
    thing = glowing(Emission_Color=(1.0, 0.5, 0.2))
    tree = thing.data.materials[0].node_tree
    grid, scale = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeMath")
    grid.attribute_name, scale.operation, scale.inputs[1].default_value = "density", "MULTIPLY", 3.0
    tree.links.new(grid.outputs["Fac"], scale.inputs[0])
    shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeVolumePrincipled")
    tree.links.new(scale.outputs[0], shader.inputs["Emission Strength"])


def object_space():
    """Coefficients count lengths of the object, which is scaled unevenly and turned."""
    thing = smoke()
    thing.data.render.space = "OBJECT"
    turn = s.Matrix.Rotation(0.6, 4, "X") @ s.Matrix.Rotation(0.5, 4, "Z")
    thing.matrix_world = s.Matrix.Translation((0.2, 0.1, -0.1)) @ turn @ s.Matrix.Diagonal((0.8, 0.6, 1.1, 1))
    key()


def scatter_and_absorb():
    """Volume Scatter + Volume Absorption, by a grid from an Attribute node."""
    thing = smoke()
    tree = thing.data.materials[0].node_tree
    tree.nodes.clear()
    kinds = ("Attribute", "VolumeScatter", "VolumeAbsorption", "AddShader")
    nodes = {kind: tree.nodes.new(f"ShaderNode{kind}") for kind in kinds}
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    nodes["Attribute"].attribute_name = "density"
    for i, (name, color, factor) in enumerate(
        (("VolumeScatter", (0.9, 0.6, 0.3, 1), 3.0), ("VolumeAbsorption", (0.8, 0.5, 0.2, 1), 2.0))
    ):
        scale = tree.nodes.new("ShaderNodeMath")
        scale.operation, scale.inputs[1].default_value = "MULTIPLY", factor
        tree.links.new(nodes["Attribute"].outputs["Fac"], scale.inputs[0])
        tree.links.new(scale.outputs[0], nodes[name].inputs["Density"])
        nodes[name].inputs["Color"].default_value = color
        tree.links.new(nodes[name].outputs[0], nodes["AddShader"].inputs[i])
    nodes["VolumeScatter"].inputs["Anisotropy"].default_value = -0.3
    tree.links.new(nodes["AddShader"].outputs[0], output.inputs["Volume"])
    key()


def droplets(phase, **inputs):
    """Volume Scatter with a phase function that Blender has from 4.3 on."""

    def made():
        thing = smoke()
        tree = thing.data.materials[0].node_tree
        tree.nodes.clear()
        attribute, scale, scatter, output = (
            tree.nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Math", "VolumeScatter", "OutputMaterial")
        )
        attribute.attribute_name = "density"
        scale.operation, scale.inputs[1].default_value = "MULTIPLY", 4.0
        scatter.phase = phase
        scatter.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1)
        for name, value in inputs.items():
            scatter.inputs[name].default_value = value
        tree.links.new(attribute.outputs["Fac"], scale.inputs[0])
        tree.links.new(scale.outputs[0], scatter.inputs["Density"])
        tree.links.new(scatter.outputs[0], output.inputs["Volume"])
        key()

    return made


def lens():
    """A tall picture with a shift, pixels that are not square, a sensor fitted to the height."""
    smoke(), key()
    render, camera = s.bpy.context.scene.render, s.bpy.context.scene.camera.data
    render.resolution_x, render.resolution_y, render.pixel_aspect_x = 48, 64, 1.5
    camera.sensor_fit, camera.sensor_height, camera.shift_x, camera.shift_y = "VERTICAL", 30, 0.1, -0.15


def orthographic():
    smoke(), key()
    render, camera = s.bpy.context.scene.render, s.bpy.context.scene.camera.data
    render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 128, 50
    camera.type, camera.ortho_scale, camera.shift_x = "ORTHO", 2.6, 0.1


def motion_blur():
    """The camera and the sun move while the shutter is open."""
    smoke(), key()
    scene = s.bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    settings = scene.render if hasattr(scene.render, "motion_blur_position") else scene.cycles
    settings.motion_blur_position = "START"
    camera = scene.camera
    for frame, x in ((1, 0.0), (3, 1.2)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
    curves = camera.animation_data.action.fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    scene.frame_set(1)


def solid():
    """A plane that hides the lower half, and shadows: a holdout in Cycles, too."""
    smoke(), key()
    mesh = s.bpy.data.meshes.new("plane")
    mesh.from_pydata([(-2, -0.1, -0.3), (2, -0.1, -0.3), (2, 0.3, 0.4), (-2, 0.3, 0.4)], [], [(0, 1, 2, 3)])
    s.place("plane", mesh).is_holdout = True


def shining(points, faces, strength):
    """A mesh that shines, and is not itself in the picture."""
    mesh = s.bpy.data.meshes.new("shining")
    mesh.from_pydata(points, [], faces)
    material = s.bpy.data.materials.new("shining")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
    shader.inputs["Strength"].default_value = strength
    shader.inputs["Color"].default_value = (1.0, 0.7, 0.4, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    thing = s.place("shining", mesh)
    thing.visible_camera = False


def shining_plane():
    smoke()
    shining([(1.4, -1.2, -0.4), (1.8, 0.2, -0.3), (1.6, 0.3, 0.8), (1.2, -1.0, 0.9)], [(0, 1, 2, 3)], 8.0)


def shining_wedge():
    """Closed, and outside of the smoke."""
    smoke()
    points = [(1.2, -1.4, 0.2), (1.9, -1.0, 0.0), (1.4, -0.6, 0.1), (1.5, -1.0, 1.0)]
    shining(points, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], 12.0)


def ies():
    """A luminaire that shines to one side, turned and tilted. Its angles are close, since Cycles has cubic curves
    between them. Candelas count times the factors of the ballast."""
    smoke()
    path = os.path.join(WORK, "side.ies")
    vertical, horizontal = range(0, 181, 5), range(0, 361, 5)
    with open(path, "w", encoding="ascii") as file:
        file.write(f"IESNA91\nTILT=NONE\n1 1000 2 {len(vertical)} {len(horizontal)} 1 2 0.1 0.1 0\n0.8 0.7 10\n")
        for angles in (vertical, horizontal):
            file.write(" ".join(map(str, angles)) + "\n")
        for h in map(math.radians, horizontal):
            # To its right, and less straight down.
            row = (110 + 60 * math.cos(v) + 45 * math.sin(v) * math.sin(h) for v in map(math.radians, vertical))
            file.write(" ".join(f"{candela:.2f}" for candela in row) + "\n")
    thing = s.light("POINT", (0.9, -1.2, 1.1), target=(0.3, 0.4, -0.8), energy=4.0, shadow_soft_size=0.0)
    thing.data.use_nodes = True
    tree = thing.data.node_tree
    texture = tree.nodes.new("ShaderNodeTexIES")
    texture.mode, texture.filepath = "EXTERNAL", path
    shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeEmission")
    tree.links.new(texture.outputs[0], shader.inputs["Strength"])


def graph(build):
    """A scene whose volume has that graph of nodes."""

    def made():
        # Scrim shades voxels and then interpolates, Cycles does it the other way round. Finer voxels make them alike.
        s.bpy.context.scene.scrim.overrides = "volume.volume.resample=2"
        build(smoke(Density=1.0, path=FINE))
        key()

    return made


# Each with samples of Cycles.
CASES = {
    "sun": (sun, 48),
    "sun of 40 degrees": (soft_sun, 72),
    "Henyey-Greenstein, g = 0.6": (anisotropy, 48),
    "colours, coloured absorption": (colors, 72),
    "point": (point, 72),
    "sphere, radius 0.4": (point_radius, 72),
    "spot, blend 0.5": (spot, 72),
    "area, rectangle": (area_rectangle, 160),
    "area, disk": (area_disk, 160),
    "area not normalised, exposure; sun of 3500 K": (light_values, 96),
    "world of one colour": (sky, 96),
    "world with a turned picture": (sky_picture, 144),
    "black body": (blackbody, 8),
    "emission by a grid": (emission, 16),
    "object space, uneven scale": (object_space, 72),
    "Volume Scatter + Absorption, g = -0.3": (scatter_and_absorb, 72),
    "Mie, droplets of 12 micrometres": (droplets("MIE", Diameter=12.0), 72),
    "Mie, droplets of 3 micrometres": (droplets("MIE", Diameter=3.0), 72),
    "Draine, g = 0.4, alpha = 5": (droplets("DRAINE", Anisotropy=0.4, Alpha=5.0), 72),
    "lens: shift, pixel aspect, fit": (lens, 48),
    "orthographic": (orthographic, 48),
    "motion blur of the camera": (motion_blur, 288),
    "a solid, held out": (solid, 72),
    "a mesh that shines": (shining_plane, 160),
    "a closed mesh that shines": (shining_wedge, 160),
    "IES texture": (ies, 96),
    "nodes: Map Range": (graph(graphs.remapped), 72),
    "nodes: ColorRamp": (graph(graphs.ramped), 72),
    "nodes: Noise Texture": (graph(graphs.eroded), 72),
    "nodes: colours, Mix": (graph(graphs.coloured), 192),
    "nodes: Vector Math, Mix, noise": (graph(graphs.layered), 72),
}
# Cycles before 5.0 draws grids half a voxel too far, and patterns by place where they belong.
LIMITS = {"nodes: Noise Texture": 0.02}
if s.bpy.app.version < (4, 3):
    for name in [name for name in CASES if name.startswith(("Mie", "Draine"))]:
        del CASES[name]
if s.bpy.app.version < (4, 5):
    del CASES["area not normalised, exposure; sun of 3500 K"]  # lights had none of these
if s.bpy.app.version < (4, 0):
    for name in [name for name in CASES if name.startswith("nodes")]:
        del CASES[name]
    # Cycles had a disk that faces what it lights, not a sphere; spots that fall off by the cosine, too; and coloured
    # extinction that is some percent too dark, whatever its samples.
    LIMITS = {"sphere, radius 0.4": 0.035, "colours, coloured absorption": 0.035}
    CASES["colours, coloured absorption"] = (colors, 144)


def one(name, build, samples):
    """(difference, noise of Cycles, seconds of Scrim, seconds of Cycles, pictures)"""
    s.fresh()
    build()
    begun = time.monotonic()
    ours = s.render(os.path.join(WORK, "ours.exr"))
    seconds = time.monotonic() - begun
    begun = time.monotonic()
    runs = []
    for seed in (0, 1):
        s.cycles(samples, seed)
        runs.append(s.render(os.path.join(WORK, "cycles.exr")))
    theirs = time.monotonic() - begun
    image = s.rgb(ours)
    a, b = (s.rgb(run) for run in runs)
    truth = 0.5 * (a + b)
    noise = 0.5 * s.difference(a, b)
    return s.difference(image, truth), noise, seconds, theirs, (image, truth)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("-k", default="", help="only cases whose name holds this regular expression")
    parser.add_argument("--table", help="a file for the figures, in Markdown")
    parser.add_argument("--pictures", help="a folder for arrays of the pictures")
    # Of a program's own words, those behind "--" are ours.
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)
    make("noise", "resolution=48", "shape=ball", "softness=0.6", path=SMOKE)
    make("noise", "resolution=128", "shape=ball", "softness=0.6", path=FINE)
    make("primitives", "resolution=224", path=BALL)
    rows, failed = [], []
    for name, (build, samples) in CASES.items():
        if not re.search(args.k, name):
            continue
        try:
            error, noise, ours, theirs, pictures = one(name, build, samples)
        except Exception as what:
            print(f"{name}: {what}", flush=True)
            failed.append(name)
            rows.append(f"| {name} | {what} |")
            continue
        rows.append(f"| {name} | {100 * error:.2f} % | {100 * noise:.2f} % | {ours:.1f} s | {theirs:.0f} s |")
        print(rows[-1], "ratio", pictures[0].mean((0, 1)) / np.maximum(pictures[1].mean((0, 1)), 1e-9), flush=True)
        if not (error <= LIMITS.get(name, LIMIT) and noise <= MOST_NOISE) or pictures[1].max() <= 0:
            failed.append(name)
        if args.pictures:
            np.save(os.path.join(args.pictures, f"{build.__name__}.npy"), np.stack(pictures))
    if args.table:
        with open(args.table, "w", encoding="utf-8") as file:
            file.write("\n".join(rows) + "\n")
    print(f"compare_test: {len(rows) - len(failed)} passed, {len(failed)} failed", *failed, sep="\n  ", flush=True)
    return 1 if failed or not rows else 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # bpy may hang where Python takes it apart
