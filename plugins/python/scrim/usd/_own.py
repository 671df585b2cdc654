# SPDX-License-Identifier: Apache-2.0
"""What a stage says to Scrim alone: attributes `scrim:*` of its prims, and a side-car in TOML keyed by their paths.

`scrim:density:scale = 4` on a Volume is `density.scale = 4` of its [[volume]]. A first part that is no key of a
[[volume]] is one of its medium: `scrim:albedo` is `medium.albedo`. On other prims `scrim:NAME` is the key NAME of the
prim's table: [[light]], [[mesh]], [camera]; on the settings it is the table NAME of the scene: `scrim:output:layers`.
"""

from __future__ import annotations

import copy
import os
import re
from collections.abc import Mapping

from pxr import Usd

from .._errors import InputError
from . import _colour
from ._reading import Reading, numbers

_OF_VOLUMES = (
    "name", "frame", "transform", "density", "velocity", "lights", "shadows", "holdout", "medium", "classified"
)  # fmt: skip


def merge(into: dict, more: Mapping) -> None:
    """Puts the keys of `more` into `into`; those that `into` has are replaced, tables key by key. The values are
    copied: tables of a scene are changed later, and a side-car is read once for all frames."""
    for key, value in more.items():
        if isinstance(value, Mapping) and isinstance(into.get(key), dict):
            merge(into[key], value)
        else:
            into[key] = copy.deepcopy(value)


def _plain(value: object) -> object:
    """A value of USD as one of TOML. Points of ramps are vectors: (grid value, value), or (grid value, r, g, b)."""
    if isinstance(value, (bool, int, float, str)):
        return value
    items = list(value)
    if items and hasattr(items[0], "__len__") and not isinstance(items[0], str):
        return [[v[0], v[1:]] if len(v) == 4 else v for v in map(numbers, items)]
    return [i if isinstance(i, (int, str)) else float(i) for i in items]


def _at(parts: list[str], of_volume: bool) -> list[str]:
    if of_volume and parts == ["g"]:
        return ["medium", "phase", "g"]
    return parts if not of_volume or parts[0] in _OF_VOLUMES else ["medium", *parts]


def attributes(reading: Reading, prim: Usd.Prim, of_volume: bool = False) -> dict:
    """The attributes `scrim:*` of a prim as nested tables."""
    out: dict = {}
    for attribute in prim.GetAuthoredPropertiesInNamespace("scrim"):
        if not isinstance(attribute, Usd.Attribute):
            reading.warn(prim, f"{attribute.GetName()} is not an attribute, and is not read")
            continue
        value = reading.get(attribute)
        if value is None:
            continue
        if str(attribute.GetTypeName()) in ("color3f", "color3d", "color3h"):
            value = _colour.value(reading, attribute, numbers(value))
        else:
            value = _plain(value)
        path = _at(attribute.GetName().split(":")[1:], of_volume)
        table = out
        for part in path[:-1]:
            table = table.setdefault(part, {})
        table[path[-1]] = value
    return out


class Sidecar:
    """A side-car: `prims`, the tables of prims by path, [/World/Smoke]; `scene`, all other tables: [render],
    [output]."""

    def __init__(self, path: str | os.PathLike[str] | None) -> None:
        self.path, self.prims, self.scene = path, {}, {}
        if path is None:
            return
        try:
            import tomllib
        except ImportError as missing:
            raise InputError(f"{path}: a side-car needs Python 3.11 or later") from missing
        try:
            with open(path, "rb") as file:
                whole = tomllib.load(file)
        except (OSError, tomllib.TOMLDecodeError) as problem:
            raise InputError(f"{path}: {problem}") from problem
        for key, table in whole.items():
            (self.prims if key.startswith("/") else self.scene)[key] = table

    def check(self, stage: Usd.Stage) -> None:
        for path in self.prims:
            if not re.fullmatch(r"(/\w+)+", path) or not stage.GetPrimAtPath(path):
                raise InputError(f"{self.path}: '{path}' is not a prim of the stage")

    def of(self, prim: Usd.Prim, of_volume: bool = False) -> dict:
        out: dict = {}
        for key, value in self.prims.get(str(prim.GetPath()), {}).items():
            path = _at([key], of_volume)
            table = out
            for part in path[:-1]:
                table = table.setdefault(part, {})
            merge(table, {path[-1]: value})
        return out
