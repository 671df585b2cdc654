# SPDX-License-Identifier: Apache-2.0
"""Checks of what a page sends: it may be any program that knows the token. They raise UsageError."""

from __future__ import annotations

import math
import re

from .._errors import UsageError

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*\.toml\Z")


def number(value: object) -> float:
    """A part of a drag."""
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not abs(value) < 1e3:
        raise UsageError(f"the page gives {value!r}; expected a number")
    return float(value)


def whole(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) > 2**31:
        raise UsageError(f"the page gives {value!r}; expected a whole number")
    return value


def file_name(value: object) -> str:
    """The name of a scene in the folder of the opened one; "" where none is given."""
    if not value:
        return ""
    if not (isinstance(value, str) and _NAME.match(value)):
        raise UsageError(f"the name {value!r}: expected one such as shot.toml, without folders")
    return value


def window(value: object, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 in pixels of a picture of this size, of a box in parts of it; None where none is given."""
    if value is None:
        return None
    if not (isinstance(value, list) and len(value) == 4):
        raise UsageError(f"the page gives {value!r}; expected a box of four numbers")
    x0, y0, x1, y1 = (min(max(number(part), 0.0), 1.0) for part in value)
    out = (math.floor(x0 * size[0]), math.floor(y0 * size[1]), math.ceil(x1 * size[0]), math.ceil(y1 * size[1]))
    if not (out[0] < out[2] and out[1] < out[3]):
        raise UsageError("the region has no pixel")
    return out
