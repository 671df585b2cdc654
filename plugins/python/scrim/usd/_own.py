# SPDX-License-Identifier: Apache-2.0
"""What a stage says to Scrim alone: attributes `scrim:*` of its prims, and a side-car in TOML keyed by their paths.

`scrim:density:scale = 4` on a Volume is `density.scale = 4` of its [[volume]]. A first part that is no key of a
[[volume]] is one of its medium: `scrim:albedo` is `medium.albedo`. On other prims `scrim:NAME` is the key NAME of the
prim's table: [[light]], [[mesh]], [camera]; on the settings it is the table NAME of the scene: `scrim:output:layers`.

USD has no lists of tables. `classified.transfer`, a list of { value, color, extinction }, is three arrays of one
length, `scrim:classified:transfer:value` and so on.
"""

from __future__ import annotations

import copy
import functools
import os
import re
from collections.abc import Mapping

from pxr import Gf, Sdf, Usd

from .. import _scrim
from .._errors import InputError
from . import _colour
from ._reading import Reading, numbers, rows


@functools.cache
def _tables() -> dict[str, dict[str, dict]]:
    """The keys of each table of a scene, as JSON schemas."""
    return {topic: table["properties"] for topic, table in _scrim.scene_schema()["$defs"].items()}


def _topic(schema: dict) -> str | None:
    """The topic of the table that a key is; None for a key that is not always a table."""
    return schema["$ref"].rpartition("/")[2] if "$ref" in schema else None


def merge(into: dict, more: Mapping) -> None:
    """Puts the keys of `more` into `into`; those that `into` has are replaced, tables key by key. The values are
    copied: tables of a scene are changed later, and a side-car is read once for all frames."""
    for key, value in more.items():
        if isinstance(value, Mapping) and isinstance(into.get(key), dict):
            merge(into[key], value)
        else:
            into[key] = copy.deepcopy(value)


def _plain(reading: Reading, attribute: Usd.Attribute, value: object) -> object:
    """A value of USD as one of TOML. Points of ramps are vectors: (grid value, value), or (grid value, r, g, b)."""
    kind = str(attribute.GetTypeName())
    if kind in ("color3f", "color3d", "color3h"):
        return _colour.value(reading, attribute, numbers(value))
    if kind in ("color3f[]", "color3d[]", "color3h[]"):
        return [_colour.value(reading, attribute, numbers(colour)) for colour in value]
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, Gf.Matrix4d):
        return rows(value)
    if isinstance(value, Sdf.AssetPath):
        return reading.file(attribute)
    try:
        items = list(value)
    except TypeError:
        raise InputError(f"{_place(attribute)}: a value of type {kind} means nothing to Scrim") from None
    if items and hasattr(items[0], "__len__") and not isinstance(items[0], str):
        return [[v[0], v[1:]] if len(v) == 4 else v for v in map(numbers, items)]
    return [i if isinstance(i, (int, str)) else float(i) for i in items]


def _place(attribute: Usd.Attribute) -> str:
    """The layer and the path of an attribute, for messages."""
    layers = [spec.layer for spec in attribute.GetPropertyStack(Usd.TimeCode.Default())]
    return f"{layers[0].identifier}: {attribute.GetPath()}" if layers else str(attribute.GetPath())


def _at(parts: list[str], of_volume: bool) -> list[str]:
    if of_volume and parts == ["g"]:
        return ["medium", "phase", "g"]
    return parts if not of_volume or parts[0] in _tables()["volume"] else ["medium", *parts]


def _put(into: dict, path: list[str], value: object, where: str) -> None:
    """`into` gets a value at a path of keys."""
    table = into
    for number, part in enumerate(path[:-1], 1):
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise InputError(f"{where}: {'.'.join(path[:number])} has a value beside its keys, and cannot have both")
    there = table.get(path[-1])
    if isinstance(value, Mapping) and isinstance(there, dict):
        for key, inner in value.items():
            _put(into, [*path, key], inner, where)
    elif there is not None:
        both = isinstance(value, Mapping) or isinstance(there, dict)
        what = "has a value beside its keys, and cannot have both" if both else "is said twice"
        raise InputError(f"{where}: {'.'.join(path)} {what}")
    else:
        table[path[-1]] = copy.deepcopy(value)


def _check(table: Mapping, topic: str, where: str, path: str = "") -> None:
    """Raises where a table of keys has a single value in place of its keys."""
    for key, value in table.items():
        inner = _topic(_tables()[topic].get(key, {}))
        if inner is None:
            continue
        if not isinstance(value, Mapping):
            keys = ", ".join(f"{path}{key}.{name}" for name in list(_tables()[inner])[:3])
            raise InputError(f"{where}: {path}{key} is {value!r}; expected a table of keys: {keys}, ...")
        _check(value, inner, where, f"{path}{key}.")


def _points(table: dict, where: str) -> None:
    """Makes the arrays of a transfer function the list of its points."""
    classified = table.get("classified")
    arrays = classified.get("transfer") if isinstance(classified, dict) else None
    if not isinstance(arrays, dict):
        return
    if any(not isinstance(array, list) for array in arrays.values()) or len({*map(len, arrays.values())}) != 1:
        raise InputError(
            f"{where}: the parts of classified.transfer, {', '.join(arrays)}, are not arrays of one length"
        )
    classified["transfer"] = [dict(zip(arrays, point)) for point in zip(*arrays.values())]


def attributes(reading: Reading, prim: Usd.Prim, of_volume: bool = False) -> dict:
    """The attributes `scrim:*` of a prim as nested tables."""
    out: dict = {}
    where = str(prim.GetPath())
    for attribute in prim.GetAuthoredPropertiesInNamespace("scrim"):
        if not isinstance(attribute, Usd.Attribute):
            reading.warn(prim, f"{attribute.GetName()} is not an attribute, and is not read")
            continue
        value = reading.get(attribute)
        if value is None:
            continue
        path = _at(attribute.GetName().split(":")[1:], of_volume)
        where = _place(attribute)
        _put(out, path, _plain(reading, attribute, value), where)
        if of_volume:
            _check(out, "volume", where)
    if of_volume:
        _points(out, where.rpartition(".")[0])
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
            if key.startswith("/") and not isinstance(table, dict):
                raise InputError(f"{path}: '{key}' is {table!r}; expected a table of keys")
            (self.prims if key.startswith("/") else self.scene)[key] = table

    def check(self, stage: Usd.Stage) -> None:
        for path in self.prims:
            if not re.fullmatch(r"(/\w+)+", path) or not stage.GetPrimAtPath(path):
                raise InputError(f"{self.path}: '{path}' is not a prim of the stage")

    def of(self, prim: Usd.Prim, of_volume: bool = False) -> dict:
        out: dict = {}
        where = f"{self.path}: {prim.GetPath()}"
        for key, value in self.prims.get(str(prim.GetPath()), {}).items():
            _put(out, _at([key], of_volume), value, where)
        if of_volume:
            _check(out, "volume", where)
        return out
