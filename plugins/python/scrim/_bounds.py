# SPDX-License-Identifier: Apache-2.0
"""Where the volumes of a scene are, as the program describes their files: nothing is loaded for it."""

from __future__ import annotations

import functools
import itertools
import json
import os
from collections.abc import Mapping

import numpy as np
from scrim_kit import Failure, program

from .__main__ import program as program_path

_SECONDS = 20.0


def of(volumes: Mapping[str, Mapping]) -> tuple[np.ndarray, np.ndarray] | None:
    """Lowest and highest corner, in world space, of all volumes that are .vdb files; None where there are none.
    `volumes`: as `Shot.resolved` names them."""
    corners = []
    for volume in volumes.values():
        if volume["file"]:
            matrix = np.array(volume["matrix"])
            corners += [(matrix @ corner)[:3] for corner in _corners(volume["file"])]
    return (np.min(corners, axis=0), np.max(corners, axis=0)) if corners else None


@functools.lru_cache(maxsize=64)
def _corners(file: str) -> tuple[np.ndarray, ...]:
    try:
        told = json.loads(program.ask([program_path(), "info", "--json", os.path.abspath(file)], _SECONDS).output)
    except (Failure, ValueError):
        return ()
    out = []
    for grid in told.get("grids", []):
        if not {"index_lower", "index_upper", "world_from_index"} <= grid.keys():
            continue
        matrix = np.array(grid["world_from_index"], float)
        for ends in itertools.product(*zip(grid["index_lower"], grid["index_upper"])):
            out.append(matrix @ np.array([*ends, 1.0]))
    return tuple(out)
