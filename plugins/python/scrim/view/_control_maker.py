# SPDX-License-Identifier: Apache-2.0
"""A control of the page, as data, and the maker of the controls of one table of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from . import _code, _curves
from ._camera import angles_of, direction_of
from ._document import Change, Place
from ._keys import is_keyed
from ._messages import is_number


@dataclass(frozen=True)
class Control:
    """`id`: how the page names the control. `kind`: number, colour (three numbers from 0 up), vector, choice, switch,
    code, or one of `_curves.KINDS`. `least`, `most`: the ends of the slider. `log`: the slider goes by factors.
    `zero`: its lower end is 0. `labels`: what the page writes for the choices; empty: the choices themselves.
    `is_fixed`: only a text editor can change the value. `key`: see `_keys.mark`. `changes(value)`: the changes of the
    scene that a value from the page makes. `layer`: the layer of the picture that the value makes brighter. `law`:
    "factor", the layer goes by new value / old value; "stops": by 2 ** (new value - old value). With both, the page
    shows a change at once."""

    id: str
    label: str
    kind: str
    value: object
    changes: Callable[[object], list[Change]] = field(repr=False)
    least: float = 0.0
    most: float = 1.0
    log: bool = False
    zero: bool = False
    unit: str = ""
    choices: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    is_fixed: bool = False
    key: str = ""
    layer: str = ""
    law: str = ""

    def accepts(self, value: object) -> bool:
        """Whether `value` has the type that this kind has. Its range is checked where the scene is read."""
        if self.is_fixed:
            return False
        if self.kind in ("colour", "vector"):
            return is_triple(value)
        if self.kind == "choice":
            return value in self.choices
        if self.kind == "code":
            return isinstance(value, str) and len(value) <= _code.LONGEST
        if self.kind in _curves.KINDS:
            return _curves.accepts(self.kind, value)
        if self.kind == "switch":
            return isinstance(value, bool)
        return is_number(value)

    def as_data(self) -> dict:
        """The control as the page reads it, in JSON."""
        return {
            "id": self.id,
            "label": self.label,
            "kind": self.kind,
            "value": None if self.is_fixed else self.value,
            "least": self.least,
            "most": self.most,
            "log": self.log,
            "zero": self.zero,
            "unit": self.unit,
            "choices": list(self.choices),
            "labels": list(self.labels or self.choices),
            "fixed": self.is_fixed,
            "key": self.key,
            "layer": self.layer,
            "law": self.law,
        }


@dataclass(frozen=True)
class Group:
    """Controls under one heading. `kind`: light, volume, shading, code, ambient or render. `name`: of the light or
    volume. `folded`: the page shows the heading alone until it is opened."""

    kind: str
    name: str
    title: str
    controls: list[Control]
    folded: bool = False


def read(table: Mapping, keys: Place, default: object) -> object:
    """The value below `table` at a path of keys; `default` where there is none."""
    for key in keys:
        if not isinstance(table, Mapping) or key not in table:
            return default
        table = table[key]
    return table


class Maker:
    """Makes the controls of one table of a scene, with the values that its keys have at a frame (`_keys.at`). `place`:
    the path of the table in the scene. `path`: the ids of its controls begin with it."""

    def __init__(self, table: Mapping, place: Place, path: str) -> None:
        self._table, self.place, self.path = table, place, path
        self.controls: list[Control] = []

    def has(self, *keys: str) -> bool:
        return read(self._table, keys, None) is not None

    def value(self, *keys: str) -> object:
        return read(self._table, keys, None)

    def add(self, label: str, kind: str, keys: Place, default: object, whole: bool = False, **more: object) -> None:
        """`whole`: the key takes whole numbers alone."""
        value = read(self._table, keys, default)
        place = (*self.place, *keys)
        name = ".".join(str(key) for key in keys)
        fixed = is_keyed(value)  # by keys of another form
        if kind == "number" and not fixed and not is_number(value):
            return  # a grid, or another form of the key without a slider
        if kind in ("colour", "vector") and not fixed and not is_triple(value):
            return
        given: dict = {"is_fixed": fixed, **more}
        changes = lambda it: [(place, round(it) if whole else it)]  # noqa: E731
        self.controls.append(Control(f"{self.path}.{name}", label, kind, value, changes, **given))

    def add_pair(self, label: str, keys: Place, default: tuple[float, float], ascends: bool = True,
                 ends: tuple[str, ...] = ("low", "high")) -> None:  # fmt: skip
        """A slider for each number of a pair. `ascends`: low < high, so a slider moves the other number along where
        it would pass it. `ends`: the sliders that are made."""
        value = read(self._table, keys, list(default))
        if not (isinstance(value, list) and len(value) == 2 and all(is_number(one) for one in value)):
            return
        place, name = (*self.place, *keys), ".".join(str(key) for key in keys)
        low, high = value
        least, most = min(0.0, low), max(1.0, high)
        gap = 1e-3 * (most - least)
        changes = {
            "low": lambda v: [(place, [v, max(high, v + gap) if ascends else high])],
            "high": lambda v: [(place, [min(low, v - gap) if ascends else low, v])],
        }
        for end, one in (("low", low), ("high", high)):
            if end in ends:
                self.controls.append(
                    Control(f"{self.path}.{name}.{end}", f"{label}, {end}", "number", one, changes[end], least, most)
                )

    def add_curve(self, label: str, kind: str, keys: Place) -> None:
        """A curve; an empty one where the scene has no such key."""
        given = read(self._table, keys, None)
        points = _curves.points(kind, given) if given is not None else []
        place, name = (*self.place, *keys), ".".join(str(key) for key in keys)
        changes = lambda it: _curves.changes(kind, place, it, given)  # noqa: E731
        self.controls.append(
            Control(f"{self.path}.{name}", label, kind, points, changes, is_fixed=points is None)
        )  # fmt: skip

    def add_angles(self, label: str, key: str, up: np.ndarray) -> None:
        """Sliders for the azimuth and elevation of a direction."""
        value = read(self._table, (key,), None)
        if not is_triple(value):
            return
        azimuth, elevation = angles_of(value, up)
        place = (*self.place, key)
        self.controls += [
            Control(f"{self.path}.azimuth", f"{label} azimuth", "number", azimuth,
                    lambda a: [(place, direction_of(a, elevation, up))], -180.0, 180.0, unit="°"),
            Control(f"{self.path}.elevation", "elevation", "number", elevation,
                    lambda e: [(place, direction_of(azimuth, e, up))], -90.0, 90.0, unit="°"),
        ]  # fmt: skip


def is_triple(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(is_number(part) for part in value)
