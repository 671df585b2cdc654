# SPDX-License-Identifier: Apache-2.0
# Graphs of nodes as artists build them for Principled Volume, for compare_test.py: made in bpy, from nothing.
import scenes as s


def add(tree, kind, values=(), **inputs):
    """A node with these settings. An input is a value or the socket that feeds it; "i2" is the third one."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for key, value in dict(values).items():
        setattr(node, key, value)
    for key, value in inputs.items():
        socket = node.inputs[int(key[1:]) if key[1:].isdigit() else key.replace("_", " ")]
        if isinstance(value, s.bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def parts_of(thing):
    """(the tree, its Principled Volume, the density, the place in the object)"""
    tree = thing.data.materials[0].node_tree
    shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeVolumePrincipled")
    grid = add(tree, "Attribute", {"attribute_name": "density"}).outputs["Fac"]
    return tree, shader, grid, add(tree, "TexCoord").outputs["Object"]


def ramp(tree, fac, points, interpolation="LINEAR"):
    node = add(tree, "ValToRGB", i0=fac)
    elements = node.color_ramp.elements
    while len(elements) < len(points):
        elements.new(1.0)
    for element, (position, color) in zip(elements, points):
        element.position, element.color = position, (*color, 1)
    node.color_ramp.interpolation = interpolation
    return node.outputs["Color"]


def remapped(thing):
    """Smoke with a harder edge: Map Range, and a factor."""
    tree, shader, grid, _ = parts_of(thing)
    settings = {"interpolation_type": "SMOOTHSTEP"}
    edge = add(tree, "MapRange", settings, From_Min=0.1, From_Max=0.6, To_Min=0.0, To_Max=1.0, Value=grid)
    scaled = add(tree, "Math", {"operation": "MULTIPLY"}, i0=edge.outputs[0], i1=5.0)
    tree.links.new(scaled.outputs[0], shader.inputs["Density"])
    shader.inputs["Density Attribute"].default_value = ""


def ramped(thing):
    """A layer of the density, by a ramp from black over white to grey."""
    tree, shader, grid, _ = parts_of(thing)
    points = [(0.05, (0, 0, 0)), (0.4, (1, 1, 1)), (0.8, (0.3, 0.3, 0.3))]
    scaled = add(tree, "Math", {"operation": "MULTIPLY"}, i0=ramp(tree, grid, points, "EASE"), i1=4.0)
    tree.links.new(scaled.outputs[0], shader.inputs["Density"])
    shader.inputs["Density Attribute"].default_value = ""


def noise(tree, place, **inputs):
    made = add(tree, "TexNoise", {"noise_dimensions": "3D"}, **{"Vector": place, "Detail": 1.0, **inputs})
    return made.outputs[0]


def eroded(thing):
    """Noise eats holes into the smoke: what is left is where noise is above a limit."""
    tree, shader, grid, place = parts_of(thing)
    moved = add(tree, "Mapping", Vector=place, Location=(0.3, 0.1, 0.7), Rotation=(0, 0, 0.4), Scale=(1, 1, 1.2))
    pattern = noise(tree, moved.outputs[0], Scale=1.5, Roughness=0.6)
    settings = {"interpolation_type": "LINEAR", "clamp": True}
    holes = add(tree, "MapRange", settings, From_Min=0.35, From_Max=0.65, To_Min=0.0, To_Max=6.0, Value=pattern)
    tree.links.new(holes.outputs[0], shader.inputs["Density"])  # times the attribute 'density'


def coloured(thing):
    """The colour follows the density, from brown to white, through a mix with a blue one."""
    tree, shader, grid, _ = parts_of(thing)
    colours = ramp(tree, grid, [(0.1, (0.25, 0.1, 0.05)), (0.7, (0.9, 0.9, 0.85))])
    mixed = add(tree, "MixRGB", {"blend_type": "MIX"}, i0=0.3, i1=colours, i2=(0.2, 0.4, 0.9, 1))
    tree.links.new(mixed.outputs[0], shader.inputs["Color"])


def layered(thing):
    """Thinner away from the middle by Vector Math, and mixed from two powers of the density by noise."""
    tree, shader, grid, place = parts_of(thing)
    away = add(tree, "VectorMath", {"operation": "LENGTH"}, i0=place).outputs["Value"]
    fade = add(tree, "MapRange", {"clamp": True}, From_Min=0.2, From_Max=1.0, To_Min=1.0, To_Max=0.0, Value=away)
    square = add(tree, "Math", {"operation": "POWER"}, i0=grid, i1=2.0)
    mixed = add(tree, "Mix", {"data_type": "FLOAT"}, i0=noise(tree, place, Scale=1.2), i2=grid, i3=square.outputs[0])
    scaled = add(tree, "Math", {"operation": "MULTIPLY"}, i0=mixed.outputs[0], i1=8.0)
    product = add(tree, "Math", {"operation": "MULTIPLY"}, i0=scaled.outputs[0], i1=fade.outputs[0])
    tree.links.new(product.outputs[0], shader.inputs["Density"])
    shader.inputs["Density Attribute"].default_value = ""
