# SPDX-License-Identifier: Apache-2.0
# A scene as nested dictionaries, written as TOML. Only what scenes need: tables are written inline below the first
# level, apart from [[volume]] and its tables, which errors of the program point into.
import math


def value_text(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is no number for a scene")
        return repr(value)
    if isinstance(value, str):
        return string_text(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_text(v)}" for key, v in value.items()) + " }"
    return "[" + ", ".join(value_text(v) for v in value) + "]"


def string_text(text):
    out = []
    for c in text:
        if c in '"\\':
            out.append("\\" + c)
        elif ord(c) < 0x20 or ord(c) == 0x7F:
            out.append(f"\\u{ord(c):04x}")
        else:
            out.append(c)
    return '"' + "".join(out) + '"'


def table_text(header, table):
    lines = [header] + [f"{key} = {value_text(value)}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


def scene_text(scene):
    """`scene` has tables by name, or lists of tables for volume, light and mesh."""
    parts = ["scene_version = 2\n"]
    for name, content in scene.items():
        if isinstance(content, list):
            parts += [table_text(f"[[{name}]]", table) for table in content]
        else:
            parts.append(table_text(f"[{name}]", content))
    return "\n".join(parts)
