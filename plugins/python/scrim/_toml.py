# SPDX-License-Identifier: Apache-2.0
"""From Python values to TOML, the language of scenes."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence

from ._errors import UsageError

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\b": "\\b", "\f": "\\f"}


def _string(text: str) -> str:
    return '"' + "".join(_ESCAPES.get(c) or (f"\\u{ord(c):04x}" if c < " " or c == "\x7f" else c) for c in text) + '"'


def _key(name: object) -> str:
    if not isinstance(name, str):
        raise UsageError(f"a key of a scene is {name!r}, expected a string")
    return name if _BARE.match(name) else _string(name)


def value(it: object, where: str) -> str:
    """`it` as a TOML value in one line. `where` is what a message calls it."""
    if hasattr(it, "tolist"):  # arrays and scalars of NumPy
        it = it.tolist()
    if isinstance(it, bool):
        return "true" if it else "false"
    if isinstance(it, (int, float)):
        return repr(it)
    if isinstance(it, (str, os.PathLike)):
        path = os.fspath(it)
        if isinstance(path, str):
            return _string(path)
    if isinstance(it, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {value(v, f'{where}.{k}')}" for k, v in it.items()) + " }"
    if isinstance(it, Sequence) and not isinstance(it, (str, bytes, bytearray)):
        return "[" + ", ".join(value(v, f"{where}[{i}]") for i, v in enumerate(it)) + "]"
    raise UsageError(
        f"'{where}' is of type {type(it).__name__}; expected a bool, a number, a string, a path, a list or a dict"
    )


def assignments(overrides: Mapping[str, object] | Sequence[str] | None) -> list[str]:
    """Overrides as the library takes them: "camera.fov=20.0"."""
    if overrides is None:
        return []
    if isinstance(overrides, Mapping):
        for key in overrides:
            if not isinstance(key, str):
                raise UsageError(f"an override is called {key!r}, expected a string such as 'camera.fov'")
        return [f"{key}={value(it, key)}" for key, it in overrides.items()]
    if isinstance(overrides, (str, bytes)) or not all(isinstance(it, str) for it in overrides):
        raise UsageError("overrides: expected a dict such as {'camera.fov': 20}, or a list of 'camera.fov=20'")
    return list(overrides)


def _is_section(it: object, top: bool) -> bool:
    """Whether it gets a line [section]: small tables within sections stay in one line."""
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


def document(scene: Mapping[str, object] | str) -> str:
    """A scene as TOML text: in sections, since a picture's header shows it."""
    if isinstance(scene, str):
        return scene
    if not isinstance(scene, Mapping):
        raise UsageError(f"a scene is of type {type(scene).__name__}; expected TOML text or a dict")
    return "\n".join(_section(scene, "")).strip("\n") + "\n"
