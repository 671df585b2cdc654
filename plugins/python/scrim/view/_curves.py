# SPDX-License-Identifier: Apache-2.0
"""Ramps and transfer functions as points that the page draws: [value of the grid, height, colour].

A point of a `ramp` is [value, height, None], one of `colours` [value, None, colour], one of a `transfer` has both.
"""

from __future__ import annotations

from collections.abc import Mapping

from ._document import Change, Place
from ._messages import is_number

KINDS = ("ramp", "colours", "transfer")
_WHITE = [1.0, 1.0, 1.0]


def points(kind: str, given: object) -> list[list] | None:
    """The points of a curve in a scene; None where it is no list of plain numbers and colours."""
    if not isinstance(given, list):
        return None
    out = [_point(kind, one) for one in given]
    return out if accepts(kind, out) else None


def _point(kind: str, one: object) -> list | None:
    if kind == "transfer" and isinstance(one, Mapping):
        return [one.get("value"), one.get("extinction"), one.get("color", _WHITE)]
    if kind != "transfer" and isinstance(one, list) and len(one) == 2:
        return [one[0], one[1], None] if kind == "ramp" else [one[0], None, one[1]]
    return None


def accepts(kind: str, value: object) -> bool:
    """Whether `value` has the form of a curve of this kind. The reader of scenes checks the order and the heights."""
    if not isinstance(value, list) or not (len(value) >= 2 or (not value and kind != "transfer")) or len(value) > 256:
        return False
    return all(isinstance(one, list) and len(one) == 3 and _is_point(kind, *one) for one in value)


def _is_point(kind: str, place: object, height: object, colour: object) -> bool:
    has_height, has_colour = kind != "colours", kind != "ramp"
    return (
        is_number(place)
        and (is_number(height) if has_height else height is None)
        and (_is_colour(colour) if has_colour else colour is None)
    )


def _is_colour(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(is_number(part) for part in value)


def changes(kind: str, place: Place, value: list[list], given: object) -> list[Change]:
    """The changes that write points into a scene; [] removes the key. `given`: the curve that the scene has now."""
    if kind != "transfer":
        said = [[float(x), float(y) if kind == "ramp" else [float(c) for c in colour]] for x, y, colour in value]
        return [(place, said or None)]
    new = [{"value": float(x), "color": [float(c) for c in rgb], "extinction": float(y)} for x, y, rgb in value]
    if not isinstance(given, list) or len(given) != len(new):
        return [(place, new)]
    out: list[Change] = []
    for index, (before, after) in enumerate(zip(given, new)):
        for key, one in after.items():
            if before.get(key, _WHITE if key == "color" else None) != one:
                out.append(((*place, index, key), one))
    return out
