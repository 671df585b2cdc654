# SPDX-License-Identifier: Apache-2.0
"""Shaders of UsdShade: the values of their inputs at a frame, and warnings of inputs that are not mapped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from pxr import Usd, UsdShade

from . import _colour
from ._reading import Reading, numbers

_GREY = 1 / 3
# Nodes that read a grid, with the input that names it.
_READERS = {"geompropvalue": "geomprop", "volume_sample": "channel", "UsdPrimvarReader": "varname"}


@dataclass
class Value:
    """`color` times the grid of that name; a constant where there is none."""

    color: list[float]
    grid: str = ""

    @property
    def number(self) -> float:
        return self.color[0] if len(set(self.color)) == 1 else _GREY * sum(self.color)

    def times(self, other: Value) -> Value | None:
        """The product; None where both have grids: a scene has no key for a product of grids."""
        if self.grid and other.grid:
            return None
        return Value([a * b for a, b in zip(self.color, other.color)], self.grid or other.grid)


def kind_of(prim: Usd.Prim) -> str:
    """The kind of a shader without its renderer and version: "arnold:standard_volume" is "standard_volume"."""
    name = UsdShade.Shader(prim).GetIdAttr().Get() or ""
    return re.sub(r"(::|_)\d+(\.\d+)*$", "", re.sub(r"^(arnold|karma|kma|houdini):+", "", str(name)))


class Shader:
    """A shader's inputs at the frame. An input counts as mapped once it was asked for."""

    def __init__(self, reading: Reading, prim: Usd.Prim) -> None:
        self.reading, self.prim, self.kind = reading, prim, kind_of(prim)
        self._shader = UsdShade.Shader(prim)
        self._asked: set[str] = set()

    def has(self, name: str) -> bool:
        source = self._shader.GetInput(name)
        return bool(source) and (source.HasConnectedSource() or source.GetAttr().HasAuthoredValue())

    def value(self, name: str, default: Sequence[float] | float) -> Value:
        found = self._found(name)
        if isinstance(found, Usd.Prim):
            value = self._of_node(name, found)
            if value is not None:
                return value
            found = self._shader.GetInput(name).GetAttr().Get()  # beside its connection
        return Value(triple(default if found is None else found))

    def number(self, name: str, default: float) -> float:
        value = self.value(name, default)
        if value.grid:
            self._say_grid(name, value)
        return value.number

    def colour(self, name: str, default: Sequence[float]) -> list[float]:
        value = self.value(name, default)
        if value.grid:
            self._say_grid(name, value)
        return value.color

    def text(self, name: str, default: str) -> str:
        found = self._found(name)
        return default if found is None or isinstance(found, Usd.Prim) else str(found)

    def array(self, name: str) -> list:
        found = self._found(name)
        return [] if found is None or isinstance(found, Usd.Prim) else list(found)

    def node(self, name: str) -> Usd.Prim | None:
        """The shader that the input is connected to."""
        found = self._found(name)
        return found if isinstance(found, Usd.Prim) else None

    def scene_colour(self, rgb: Sequence[float]) -> object:
        """Scene-linear numbers in the colour space of this prim as a scene says them."""
        return _colour.value(self.reading, self._shader.GetIdAttr(), [float(c) for c in rgb])

    def warn(self, text: str) -> None:
        self.reading.warn(self.prim, text)

    def say_what_is_not(self) -> None:
        left = [i.GetBaseName() for i in self._shader.GetInputs() if i.GetBaseName() not in self._asked]
        left = sorted(name for name in left if self.has(name))
        if left:
            self.warn(f"{self.kind}: not mapped: {', '.join(left)}")

    def _found(self, name: str) -> object:
        """The value of an input, or the prim of the shader that it is connected to; None where nothing is authored."""
        self._asked.add(name)
        source = self._shader.GetInput(name)
        made = UsdShade.Utils.GetValueProducingAttributes(source) if source else []
        if not made:
            return None
        if UsdShade.Output.IsOutput(made[0]):
            return made[0].GetPrim()
        return self.reading.get(made[0])

    def _of_node(self, name: str, prim: Usd.Prim) -> Value | None:
        value = _node_value(Shader(self.reading, prim))
        if value is None:
            self.warn(f"{self.kind}: {name} comes from {prim.GetPath()} ({kind_of(prim) or 'no shader'}), which is not "
                      "mapped")  # fmt: skip
        return value

    def _say_grid(self, name: str, value: Value) -> None:
        self.warn(f"{self.kind}: {name} has the grid '{value.grid}', where a number or a colour is expected")


def triple(value: object) -> list[float]:
    if hasattr(value, "__len__"):
        some = numbers(value)
        return some[:3] if len(some) > 2 else [some[0]] * 3
    return [float(value)] * 3


def _node_value(node: Shader) -> Value | None:
    """The value of a node that reads a grid, holds a constant, or multiplies two such values; None for other nodes."""
    kind = re.sub(r"_(float|color3|color4|vector3|integer|string|rgb)(F[AC]?)?$", "", node.kind.removeprefix("ND_"))
    if kind in _READERS:
        name = node.text(_READERS[kind], "")
        return Value([1.0] * 3, name) if name else None
    if kind == "constant":
        return node.value("value", 0.0)
    if kind == "multiply":
        return node.value("in1", 0.0).times(node.value("in2", 1.0))
    return None
