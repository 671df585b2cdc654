# SPDX-License-Identifier: Apache-2.0
"""Checks of what a page sends: it may be any program that knows the token. They raise UsageError."""

from __future__ import annotations

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
