#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a reader of the sources must take in: for each room its lines against a budget, its types, its longest function
and file, and its share of long lines. Fails where a limit is passed.

    tests/tools/house/count.py [COMMIT]     of the working tree, or of a commit

A room is a folder. A type is a struct, class, enum or alias, wherever it is defined. A budget is raised only in the
commit that brings a feature to the room, with the reason in the commit's message. There is no limit for the number of
files or types: code is divided where a reader would divide it.
"""

import io
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[3]
LINES_OF_FUNCTION, PARAMETERS, LINES_OF_FILE, LONG, LONGEST, SHARE_OF_LONG = 60, 7, 600, 100, 120, 0.11

# Lines of each room, rounded up to a hundred when the room was last given a feature.
BUDGETS = {
    "scrim": 100, "scrim/engine": 1370, "scrim/engine/balls": 700, "scrim/engine/composite": 2000,
    "scrim/engine/light": 3250, "scrim/engine/model": 1780, "scrim/engine/plan": 3570, "scrim/engine/shade": 2550,
    "scrim/engine/splat": 3620, "scrim/engine/cells": 3100, "scrim/engine/lamps": 1620, "scrim/engine/passes": 3150,
    "scrim/engine/solve": 3100, "scrim/base": 1910, "scrim/geometry": 900, "scrim/guard": 2450, "scrim/image": 5400,
    "scrim/scene": 11100, "scrim/shot": 8260, "scrim/solid": 1030, "scrim/study": 2000, "scrim/verify": 5720,
    "scrim/volume": 9100,
    "load": 1850, "cli": 4800, "modules": 900,
}  # fmt: skip

TYPE = re.compile(
    r"^ *(?:template <.*> *)?(?:(?:enum )?(?:struct|class) [A-Za-z_]\w*[^;()]*\{|enum \w*.*\{|using [A-Za-z_]\w* =)"
)
DEFINITION = re.compile(
    r"^(?!namespace|struct|class|enum|union|extern|using|constexpr|inline constexpr|#|//|\})[A-Za-z_].*\("
)


@dataclass
class Room:
    lines: int = 0
    types: int = 0
    long: int = 0
    longest_function: int = 0
    longest_file: int = 0
    faults: list[str] = field(default_factory=list)


def parameters(signature: str) -> int:
    """The number of parameters in the first list of parameters of a signature."""
    depth, commas, empty = 0, 0, True
    for c in signature[signature.index("(") + 1 :]:
        depth += (c in "(<[{") - (c in ")>]}")
        if depth < 0:
            break
        commas += c == "," and depth == 0
        empty = empty and c.isspace()
    return 0 if empty else commas + 1


def functions(lines: list[str]):
    """The first line, the number of lines and of parameters of each function that is defined in the first column."""
    start, signature = None, ""
    for number, line in enumerate(lines, 1):
        if start is None and DEFINITION.match(line):
            start, signature = number, ""
        if start is None:
            continue
        if "{" not in signature:
            signature += line + "\n"
        if ";" in signature.split("{")[0]:
            start = None
        elif line.startswith("}") or (number == start and line.endswith("}")):
            yield start, number - start + 1, parameters(signature)
            start = None


def measured(files: list[pathlib.Path], src: pathlib.Path) -> Room:
    room = Room()
    for path in files:
        lines = path.read_text().splitlines()
        name = path.relative_to(src)
        room.lines += len(lines)
        room.types += sum(bool(TYPE.match(line)) for line in lines)
        room.long += sum(len(line) > LONG for line in lines)
        room.longest_file = max(room.longest_file, len(lines))
        if len(lines) > LINES_OF_FILE:
            room.faults.append(f"{name}: {len(lines)} lines; at most {LINES_OF_FILE}")
        room.faults += [f"{name}:{n}: over {LONGEST} columns" for n, line in enumerate(lines, 1) if len(line) > LONGEST]
        for start, length, count in functions(lines):
            room.longest_function = max(room.longest_function, length)
            if length > LINES_OF_FUNCTION:
                room.faults.append(f"{name}:{start}: a function of {length} lines; at most {LINES_OF_FUNCTION}")
            if count > PARAMETERS:
                room.faults.append(f"{name}:{start}: {count} parameters; at most {PARAMETERS}")
    return room


def report(src: pathlib.Path) -> int:
    files: dict[str, list[pathlib.Path]] = {}
    for path in sorted(src.rglob("*")):
        if path.suffix in (".h", ".cpp"):
            files.setdefault(str(path.parent.relative_to(src)), []).append(path)
    rooms = {name: measured(paths, src) for name, paths in files.items()}
    faults = []
    print(f"{'room':<24} {'lines':>6} {'budget':>6} {'types':>6} {'longest function, file':>24} {'over 100':>9}")
    for name, room in rooms.items():
        budget = BUDGETS.get(name)
        print(
            f"{name:<24} {room.lines:>6} {budget or '-':>6} {room.types:>6} {room.longest_function:>18} "
            f"{room.longest_file:>5} {room.long / room.lines:>9.1%}"
        )
        if budget is None:
            faults.append(f"{name}: a room without a budget")
        elif room.lines > budget:
            faults.append(f"{name}: {room.lines} lines; the budget is {budget}")
        faults += room.faults
    lines, long = sum(room.lines for room in rooms.values()), sum(room.long for room in rooms.values())
    print(f"{'all':<24} {lines:>6} {'':>38} {long / lines:>14.1%}")
    if long > SHARE_OF_LONG * lines:
        faults.append(f"{long / lines:.1%} of lines are over {LONG} columns; at most {SHARE_OF_LONG:.0%}")
    print("\n".join(faults))
    return 1 if faults else 0


def main() -> int:
    if len(sys.argv) < 2:
        return report(ROOT / "src")
    with tempfile.TemporaryDirectory() as folder:
        packed = subprocess.run(["git", "archive", sys.argv[1], "src"], cwd=ROOT, check=True, capture_output=True)
        tarfile.open(fileobj=io.BytesIO(packed.stdout)).extractall(folder)
        return report(pathlib.Path(folder) / "src")


if __name__ == "__main__":
    sys.exit(main())
