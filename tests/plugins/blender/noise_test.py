# SPDX-License-Identifier: Apache-2.0
# The noise that a Noise Texture becomes is that of Blender, which computes it here by geometry nodes.
import os
import sys

import numpy as np
import pytest
import scenes as s
from evaluated import numbers_of
from lookalikes import link, node

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
from scrim.expressions import Code  # noqa: E402

bpy = s.bpy
PLACES = np.array([(0.11, 0.42, -0.37), (-3.7, 2.2, 0.9), (12.3, -8.1, 4.4), (0.5, 0.5, 0.5), (-0.01, -100.7, 63.9)])


def of_blender(normalize, inputs):
    s.fresh()
    mesh = bpy.data.meshes.new("places")
    mesh.from_pydata([tuple(p) for p in PLACES], [], [])
    thing = s.place("places", mesh)
    group = bpy.data.node_groups.new("noise", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeStoreNamedAttribute", "GeometryNodeInputPosition")
    given, end, store, place = (group.nodes.new(kind) for kind in kinds)
    texture = group.nodes.new("ShaderNodeTexNoise")
    texture.normalize = normalize
    for name, value in inputs.items():
        texture.inputs[name].default_value = value
    store.data_type, store.domain = "FLOAT", "POINT"
    store.inputs["Name"].default_value = "noise"
    for source, target in (
        (given.outputs[0], store.inputs["Geometry"]),
        (place.outputs[0], texture.inputs["Vector"]),
        (texture.outputs[0], store.inputs["Value"]),
        (store.outputs[0], end.inputs[0]),
    ):
        group.links.new(source, target)
    thing.modifiers.new("noise", "NODES").node_group = group
    made = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return [value.value for value in made.attributes["noise"].data]


def of_scrim(normalize, inputs):
    grids = {f"{axis}{i}": float(v) for i, p in enumerate(PLACES) for axis, v in zip("xyz", p)}
    code = Code(list(grids))
    names = []
    for i in range(len(PLACES)):
        place = node("ShaderNodeCombineXYZ", X=0.0, Y=0.0, Z=0.0)
        for axis in "XYZ":
            values = {"attribute_type": "GEOMETRY", "attribute_name": f"{axis.lower()}{i}"}
            link(node("ShaderNodeAttribute", outputs=("Fac",), values=values), place, axis)
        values = {"noise_dimensions": "3D", "noise_type": "FBM", "normalize": normalize}
        texture = node("ShaderNodeTexNoise", outputs=("Fac",), values=values, Vector=None, Distortion=0.0, **inputs)
        end = node("end", In=None)
        link(place, texture, "Vector"), link(texture, end, "In")
        names.append(code.grid(code.of(end.inputs["In"])))
    found = numbers_of(code.text, **grids)
    return [found[name] for name in names]


@pytest.mark.parametrize("detail, normalize", [(0.0, True), (2.0, True), (4.6, True), (3.0, False), (15.0, True)])
def test_noise_is_blenders(detail, normalize):
    inputs = {"Scale": 1.7, "Detail": detail, "Roughness": 0.6, "Lacunarity": 2.1}
    # In single precision, places near 100 are known to 1e-5, and the finest octave of 15 to no more than its weight.
    tolerance = 2e-3 if detail > 10 else 2e-4
    assert of_scrim(normalize, inputs) == pytest.approx(of_blender(normalize, inputs), abs=tolerance)
