# SPDX-License-Identifier: Apache-2.0
"""Python values as TOML, the language of scenes.

A bool, int, float, str, path, list and dict have a text in TOML. So do tuples, arrays and numbers of NumPy, and
vectors of Blender, which are written as lists and numbers. Everything else raises Failure, whose text names the value
by `where`: 'camera.position[1]'. Infinite numbers and those that are none are written as TOML has them (inf, nan); the
program refuses them by the name of their key.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping

from .failure import Failure

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\b": "\\b", "\f": "\\f"}


def value(it: object, where: str) -> str:
    """`it` as a TOML value in one line."""
    if hasattr(it, "tolist"):  # arrays and numbers of NumPy
        it = it.tolist()
    if isinstance(it, bool):
        return "true" if it else "false"
    if isinstance(it, int):
        return repr(int(it))
    if isinstance(it, float):
        return repr(float(it))
    if isinstance(it, os.PathLike):
        it = it.__fspath__()
    if isinstance(it, str):
        return _string(it, where)
    if isinstance(it, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {value(v, f'{where}.{k}')}" for k, v in it.items()) + " }"
    if _is_list(it):
        return "[" + ", ".join(value(v, f"{where}[{i}]") for i, v in enumerate(it)) + "]"
    raise Failure(
        f"'{where}' is of type {type(it).__name__}; expected a bool, a number, a string, a path, a list or a dict"
    )


def assignment(key: str, it: object) -> str:
    """An override as `scrim --set` and the library take it: `camera.fov=20.0`."""
    return f"{key}={value(it, key)}"


def document(scene: Mapping[str, object]) -> str:
    """A scene as TOML text. Tables and lists of tables get sections of their own: [camera], [[volume]],
    [volume.medium]. A table within a section that holds no table stays in one line."""
    return "\n".join(_section(scene, "")).strip("\n") + "\n"


def _is_list(it: object) -> bool:
    """Whether `it` has items in an order. Vectors of Blender have, though they are no Sequence of Python's."""
    return hasattr(it, "__len__") and hasattr(it, "__getitem__") and not isinstance(it, (bytes, bytearray))


def _string(text: str, where: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:  # names of files may be any bytes, scenes are UTF-8
        raise Failure(f"'{where}' is not UTF-8: {text!a}") from None
    return '"' + "".join(_ESCAPES.get(c) or (f"\\u{ord(c):04x}" if c < " " or c == "\x7f" else c) for c in text) + '"'


def _key(name: object) -> str:
    if not isinstance(name, str):
        raise Failure(f"a key of a scene is {name!r}, expected a string")
    return name if _BARE.match(name) else _string(name, name)


def _is_section(it: object, top: bool) -> bool:
    """Whether a table gets a line [section]. A table that holds no table stays in one line within its section."""
    return isinstance(it, Mapping) and (top or any(isinstance(v, Mapping) for v in it.values()))


def _is_sections(it: object) -> bool:
    return isinstance(it, (list, tuple)) and bool(it) and all(isinstance(v, Mapping) for v in it)


def _section(table: Mapping[str, object], path: str) -> list[str]:
    inner = [k for k, v in table.items() if _is_section(v, not path) or _is_sections(v)]
    lines = [f"{_key(k)} = {value(v, path + str(k))}" for k, v in table.items() if k not in inner]
    for key in inner:
        name, it = path + _key(key), table[key]
        for one in it if _is_sections(it) else [it]:
            lines += ["", f"[[{name}]]" if _is_sections(it) else f"[{name}]", *_section(one, name + ".")]
    return lines
