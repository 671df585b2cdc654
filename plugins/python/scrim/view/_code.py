# SPDX-License-Identifier: Apache-2.0
"""Expressions in OpenVDB AX as the page edits them: the parameters that they need, and the places of their errors."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping

import tomlkit
from tomlkit.items import String

from ._document import Change, Place, name_of

LONGEST = 50_000  # characters of an expression from the page
_OWN = ("frame", "time", "seed")  # variables that every expression has
_VARIABLE = re.compile(r"(\w*)\$([A-Za-z_]\w*)")  # in comments, too, as Scrim itself counts them
_VECTORS = ("v", "vec3f", "vec3d", "vec3i")
_PLACE = re.compile(r":(\d+):(\d+): (.*)", re.DOTALL)


def variables(code: str) -> dict[str, bool]:
    """Names of the variables that an expression takes from outside, each with whether it is a vector."""
    found: dict[str, bool] = {}
    for kind, name in _VARIABLE.findall(code):
        found[name] = found.get(name, False) or kind in _VECTORS
    return found


def changes(volume: Mapping, place: Place, code: str) -> list[Change]:
    """The changes that make `code` the expression of a volume at `place`. New variables get a parameter: 1, or a vector
    of zeros. Parameters that only the former expression used are removed."""
    code = code.replace("\r\n", "\n")
    if code.strip() and "\n" in code and not code.endswith("\n"):
        code += "\n"
    given = volume.get("parameters", {})
    before, now = variables(volume.get("ax", "")), variables(code)
    gone = [name for name in given if name not in now and (name in before or "source" not in volume)]
    out: list[Change] = [((*place, "ax"), code if code.strip() else None)]
    if gone and len(gone) == len(given) and not now:
        return [*out, ((*place, "parameters"), None)]
    out += [((*place, "parameters", name), None) for name in gone]
    new = {name: [0.0, 0.0, 0.0] if is_vector else 1.0 for name, is_vector in now.items() if name not in _OWN}
    return out + [((*place, "parameters", name), value) for name, value in new.items() if name not in given]


def parameters(volume: Mapping) -> Iterator[tuple[str, object]]:
    """(name, value) of the parameters that the expression uses. The page does not show those that only the source
    uses."""
    given, used = volume.get("parameters", {}), variables(volume.get("ax", ""))
    return ((name, given[name]) for name in used if name in given)


def range_of(value: float) -> tuple[float, float]:
    """Ends of a slider for a parameter: 0 and the next power of ten; of a negative value, that power to both sides."""
    most = 10.0 ** math.ceil(math.log10(abs(value))) if value else 1.0
    return (0.0 if value >= 0 else -most), most


def mistake(text: str, name: str, error: str) -> dict | None:
    """The place of an error in an expression: `volume`, `line` and `column` in the volume's expression, and the `text`.
    `error`: a message of the library with the place in the scene, "NAME:LINE:COLUMN: ...". `text`: the scene. `name`:
    NAME. None: the place is in no expression."""
    found = _PLACE.match(error.removeprefix(name)) if error.startswith(name) else None
    if not found:
        return None
    line, column, what = int(found[1]), int(found[2]), found[3]
    at = 0
    for index, volume in enumerate(tomlkit.parse(text).get("volume", [])):
        code = volume.get("ax")
        if not isinstance(code, String):
            continue
        raw = code.as_string()
        start = text.index(raw, at)
        at = start + len(raw)
        start += 3 if raw[:3] in ("'''", '"""') else 1
        if raw[3:4] == "\n" and raw[:3] in ("'''", '"""'):
            start += 1
        first = text.count("\n", 0, start) + 1
        inside = line - first + 1
        if 1 <= inside <= code.count("\n") + 1:
            before = start - (text.rfind("\n", 0, start) + 1) if inside == 1 else 0
            volume_name = name_of("volume", index, volume)
            return {"volume": volume_name, "line": inside, "column": max(column - before, 1), "text": what}
    return None
