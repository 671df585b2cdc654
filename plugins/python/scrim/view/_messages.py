# SPDX-License-Identifier: Apache-2.0
"""Checks of messages from a page, which may be any program that knows the token. They raise UsageError."""

from __future__ import annotations

import logging
import math
import re

from .._errors import Error, UsageError

_LARGEST_FRAME = 1_000_000_000  # of the program
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*\.toml\Z")


def is_number(value: object) -> bool:
    """Whether a scene can hold `value` as a number. Python's whole numbers may be too long for a float: those are
    none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300


def number(value: object) -> float:
    """A component of a drag."""
    if not (is_number(value) and abs(value) < 1e3):
        raise UsageError(f"the page gives {shortened(value)}; expected a number")
    return float(value)


def whole(value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= 2**53:  # what a page counts to
        raise UsageError(f"the page gives {shortened(value)}; expected a whole number")
    return value


def frame(value: object) -> int:
    if abs(whole(value)) > _LARGEST_FRAME:
        raise UsageError(f"the page asks for frame {value}; expected one up to {_LARGEST_FRAME}")
    return value


def names(value: object) -> list[str]:
    if not (isinstance(value, list) and all(isinstance(one, str) for one in value)):
        raise UsageError(f"the page gives {shortened(value)}; expected a list of names")
    return value


def told(error: Exception) -> str:
    """The text of an error for users. An error of a class that is not Scrim's is a mistake of the viewer: the log
    gets its traceback."""
    if isinstance(error, Error):
        return str(error)
    logging.getLogger("scrim").error("the viewer failed", exc_info=error)
    return f"the viewer failed: {type(error).__name__}: {error}"


def shortened(value: object) -> str:
    """A value as messages show it. Python may refuse to write whole numbers of many digits."""
    try:
        text = repr(value)
    except ValueError:
        text = f"a {type(value).__name__} of many digits"
    return text if len(text) <= 80 else text[:77] + "..."


def file_name(value: object) -> str:
    """The name of a scene in the folder of the opened one; "" where none is given."""
    if not value:
        return ""
    if not (isinstance(value, str) and _NAME.match(value)):
        raise UsageError(f"the name {shortened(value)}: expected one such as shot.toml, without folders")
    return value


def window(value: object, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 in pixels, of a box in parts of a picture of this size; None where no box is given."""
    if value is None:
        return None
    if not (isinstance(value, list) and len(value) == 4):
        raise UsageError(f"the page gives {shortened(value)}; expected a box of four numbers")
    x0, y0, x1, y1 = (min(max(number(part), 0.0), 1.0) for part in value)
    out = (math.floor(x0 * size[0]), math.floor(y0 * size[1]), math.ceil(x1 * size[0]), math.ceil(y1 * size[1]))
    if not (out[0] < out[2] and out[1] < out[3]):
        raise UsageError("the region has no pixel")
    return out
