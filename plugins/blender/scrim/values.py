# SPDX-License-Identifier: Apache-2.0
# The value of a socket, if it is a constant or a constant times a grid: keys of a scene can hold no more.
from dataclasses import dataclass

from .expressions import NotMapped, constant_of, source_of

BLACK, WHITE = [0.0] * 3, [1.0] * 3


@dataclass
class Value:
    """`color` times the grid of that name; a number where there is none."""

    color: list
    grid: str = ""

    @property
    def number(self):
        return self.color[0] if len(set(self.color)) == 1 else sum(self.color) / 3

    def times(self, other):
        if self.grid and other.grid:
            raise NotMapped(f"the product of the grids '{self.grid}' and '{other.grid}'")
        return Value([a * b for a, b in zip(self.color, other.color)], self.grid or other.grid)


INFO_GRIDS = {"Density": "density", "Flame": "flame", "Temperature": "temperature", "Color": "color"}


def value_of(socket):
    node, output = source_of(socket)
    if node is None:
        return Value(constant_of(socket))
    kind = node.bl_idname
    if kind == "ShaderNodeValue":
        return Value([float(node.outputs[0].default_value)] * 3)
    if kind == "ShaderNodeRGB":
        return Value([float(v) for v in list(node.outputs[0].default_value)[:3]])
    if kind == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY" and output in ("Fac", "Factor", "Color"):
        return Value(WHITE, node.attribute_name)
    if kind == "ShaderNodeVolumeInfo":
        return Value(WHITE, INFO_GRIDS[output])
    if kind == "ShaderNodeMath" and not node.use_clamp and node.operation in ("MULTIPLY", "DIVIDE"):
        a, b = value_of(node.inputs[0]), value_of(node.inputs[1])
        if node.operation == "MULTIPLY":
            return a.times(b)
        if not b.grid and b.number != 0:
            return a.times(Value([1 / b.number] * 3))
    raise NotMapped(f"node '{node.name}' at '{socket.name}'")
