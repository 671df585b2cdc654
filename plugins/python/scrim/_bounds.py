# SPDX-License-Identifier: Apache-2.0
"""Boxes around the volumes of a scene, from the program's description of their files. No voxels are loaded."""

from __future__ import annotations

import functools
import itertools
import json
import os
from collections.abc import Callable, Iterable, Mapping

import numpy as np
from scrim_kit import Failure, program

from .__main__ import program as program_path

_SECONDS = 20.0


Box = tuple[np.ndarray, np.ndarray]  # lowest and highest corner, in world space
State = tuple[str, int, int]  # a file, and what tells whether it is another one by now


def of(volumes: Mapping[str, Mapping]) -> Box | None:
    """The box of all volumes that are .vdb files; None where there are none, or none that can be read. `volumes`: as
    `Shot.resolved` names them. Asks the program and waits for it."""
    return _box(volumes, _asked)


class Places:
    """Boxes that are known, for whoever cannot wait: the program is asked `beside`, and `came()` is called once it has
    answered. `beside(work, then)`: does `work` in a thread, and calls `then` with what it gives in that of the caller.
    """

    def __init__(self, beside: Callable[[Callable, Callable], object], came: Callable[[], object]) -> None:
        self._beside, self._came = beside, came
        self._known: dict[State, Iterable[np.ndarray]] = {}
        self._asked: set[State] = set()

    def of(self, volumes: Mapping[str, Mapping]) -> Box | None:
        """The box of those volumes whose boxes are known."""
        return _box(volumes, self._corners)

    @property
    def waits(self) -> bool:
        """Whether the program is still being asked."""
        return bool(self._asked)

    def ask_again(self) -> None:
        """Asks anew for files that could not be read."""
        self._known = {state: corners for state, corners in self._known.items() if corners}

    def _corners(self, file: str) -> Iterable[np.ndarray]:
        state = _state(file)
        if state not in self._known and state not in self._asked:
            self._asked.add(state)
            self._beside(lambda: _asked(file), functools.partial(self._take, state))
        return self._known.get(state, ())

    def _take(self, state: State, corners: Iterable[np.ndarray]) -> None:
        self._asked.discard(state)
        self._known[state] = corners
        self._came()


def _box(volumes: Mapping[str, Mapping], corners_of: Callable[[str], Iterable[np.ndarray]]) -> Box | None:
    corners = []
    for volume in volumes.values():
        if volume["file"]:
            matrix = np.array(volume["matrix"])
            corners += [(matrix @ corner)[:3] for corner in corners_of(volume["file"])]
    return (np.min(corners, axis=0), np.max(corners, axis=0)) if corners else None


def _state(file: str) -> State:
    try:
        there = os.stat(file)
    except OSError:
        return file, 0, 0
    return file, there.st_mtime_ns, there.st_size


def _asked(file: str) -> tuple[np.ndarray, ...]:
    """The corners of a file's grids. Nothing, which is not remembered, where it cannot be read: it may be written just
    now, or lie on a disk that is slow today."""
    try:
        return _corners(*_state(file))
    except (Failure, ValueError):
        return ()


@functools.lru_cache(maxsize=64)
def _corners(file: str, *state: int) -> tuple[np.ndarray, ...]:
    told = json.loads(program.ask([program_path(), "info", "--json", os.path.abspath(file)], _SECONDS).output)
    out = []
    for grid in told.get("grids", []):
        if not {"index_lower", "index_upper", "world_from_index"} <= grid.keys():
            continue
        matrix = np.array(grid["world_from_index"], float)
        for ends in itertools.product(*zip(grid["index_lower"], grid["index_upper"])):
            out.append(matrix @ np.array([*ends, 1.0]))
    return tuple(out)
