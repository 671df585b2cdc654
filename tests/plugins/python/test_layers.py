# SPDX-License-Identifier: Apache-2.0
"""Who may import whom among the modules of `plugins`. Imports within functions, and those for types
alone, count like all others."""

import ast
from pathlib import Path

import pytest

PLUGINS = Path(__file__).resolve().parents[3] / "plugins"

# For each front end the folders that it consists of, by the names under which their modules are imported, and its rooms
# from the bottom up. A module imports its own room and those before it. It belongs to the longest name that its own
# name begins with; "=" before a name: only that module. A front door stands above its package, so what is within never
# imports it; `python -m` runs the modules called `__main__`, which stand above the door.
FRONT_ENDS = {
    "farm": ({"scrim_kit": "kit/scrim_kit", "scrim_farm": "farm/scrim_farm"}, ["scrim_kit", "scrim_farm"]),
    "blender": (
        {"scrim.scrim_kit": "kit/scrim_kit", "scrim": "blender/scrim"},
        ["scrim.scrim_kit", "scrim", "=scrim"],
    ),
    "python": (
        {"scrim_kit": "kit/scrim_kit", "scrim": "python/scrim"},
        ["scrim_kit", "=scrim._scrim", "scrim", "scrim.usd", "scrim.view", "=scrim", "=scrim.view.__main__"],
    ),
}
COMPILED = {"python": {"scrim._scrim"}}  # modules without a source file below `plugins`


def modules_of(front_end):
    """Source files of modules, by their names."""
    files = {}
    for package, folder in FRONT_ENDS[front_end][0].items():
        root = PLUGINS / folder
        for path in sorted(root.rglob("*.py")):
            parts = [package, *path.relative_to(root).with_suffix("").parts]
            files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return files


def imports_of(name, source, is_package, known):
    """The modules among `known` that a module imports."""
    package = name.split(".") if is_package else name.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*base, *([node.module] if node.module else [])])
            within = {alias.name: f"{base}.{alias.name}" for alias in node.names}
            found |= {inner if inner in known else base for inner in within.values()}
    return found & known - {name}


def graph_of(front_end):
    """The modules that each module imports."""
    files = modules_of(front_end)
    known = {*files, *COMPILED.get(front_end, ())}
    return {
        name: imports_of(name, path.read_text(encoding="utf-8"), path.name == "__init__.py", known)
        for name, path in files.items()
    }


def circles_in(graph):
    """For each module that imports itself by way of others, the shortest such way."""
    found = {}
    for first in graph:
        ways, seen = [[first]], set()
        while ways and first not in found:
            way = ways.pop(0)
            for after in sorted(graph.get(way[-1], ())):
                if after == first:
                    found[first] = way
                elif after not in seen:
                    seen.add(after)
                    ways.append([*way, after])
    # The same circle begins at each of its modules.
    return sorted({" -> ".join([*way, first]) for first, way in found.items() if first == min(way)})


def room_of(name, rooms):
    """The place of a module's room in the table."""
    if f"={name}" in rooms:
        return rooms.index(f"={name}")
    fitting = [room for room in rooms if f"{name}.".startswith(f"{room}.")]
    assert fitting, f"{name} is in no room"
    return rooms.index(max(fitting, key=len))


def against_the_order(graph, rooms):
    return sorted(
        f"{name} imports {other}, which stands above it"
        for name, others in graph.items()
        for other in others
        if room_of(other, rooms) > room_of(name, rooms)
    )


@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_modules_import_no_module_that_imports_them(front_end):
    circles = circles_in(graph_of(front_end))
    assert not circles, "\n".join(circles)


@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_modules_import_nothing_from_above(front_end):
    graph = graph_of(front_end)
    assert len(graph) > 10 and sum(map(len, graph.values())) > 20  # there is something to look at
    wrong = against_the_order(graph, FRONT_ENDS[front_end][1])
    assert not wrong, "\n".join(wrong)


def test_imports_are_found_wherever_they_stand():
    known = {"p", "p.a", "p.b", "p.c", "p.q", "p.q.d"}
    source = "import p.a\ndef f():\n    from . import b\n    from .c import x\n    from .q import d\n"
    assert imports_of("p.z", source, False, known) == {"p.a", "p.b", "p.c", "p.q.d"}
    assert imports_of("p.q", "from .. import a\nfrom . import d\n", True, known) == {"p.a", "p.q.d"}
    assert imports_of("p.a", "from . import absent\nimport os\n", False, known) == {"p"}


def test_circles_and_imports_from_above_would_be_found():
    graph = {"p.a": {"p.b"}, "p.b": {"p.c"}, "p.c": {"p.b"}, "p.q.d": {"p.a"}}
    assert circles_in(graph) == ["p.b -> p.c -> p.b"]
    assert against_the_order(graph, ["p", "p.q"]) == []
    assert against_the_order({"p.a": {"p.q.d"}}, ["p", "p.q"]) == ["p.a imports p.q.d, which stands above it"]
