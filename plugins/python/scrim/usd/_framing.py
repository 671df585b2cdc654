# SPDX-License-Identifier: Apache-2.0
"""A camera for a stage that has none: the one that frames its asset, as `scrim render` frames a .vdb file.

A single volume that stands still is seen as its file is, carried along by the volume's transform. Several volumes, or
one that moves, are seen from the side from which the largest one alone would be seen, and from so far that all of them
fit into the picture.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence

import numpy as np
from pxr import UsdGeom

from .. import _bounds, _errors, _scrim
from ._reading import Reading, frames_of
from ._settings import Settings

_MARGIN = 1.05  # the size of the picture over that of what is framed

Placed = tuple[str, tuple[float, ...]]  # a file, and the matrix (4, 4) that places it, row by row


def camera(reading: Reading, settings: Settings, volumes_at: Callable[[int], list[dict]]) -> dict:
    """[camera]. `volumes_at`: tables of the volumes at a frame. The first, middle and last one are framed together, so
    that all frames have the same camera."""
    frames = frames_of(reading.stage)
    chosen = sorted({frames[0], frames[len(frames) // 2], frames[-1]})
    placed = tuple(dict.fromkeys(one for frame in chosen for one in _placed(reading, volumes_at(frame), frame)))
    up = (0.0, 0.0, 1.0) if UsdGeom.GetStageUpAxis(reading.stage) == UsdGeom.Tokens.z else (0.0, 1.0, 0.0)
    if not placed:
        raise _errors.InputError("the stage has no camera, and no volume from which one could be made")
    try:
        matrix, fov, resolution = _framed(placed, up, settings.resolution)
    except _errors.InputError as problem:
        raise _errors.InputError(f"the stage has no camera, and cannot be framed: {problem}") from problem
    eye, ahead = (", ".join(f"{v:.4g}" for v in vector) for vector in (matrix[:3, 3], -matrix[:3, 2]))
    reading.warn("/", f"the stage has no camera: one stands at ({eye}), looks along ({ahead}) and sees {fov:g} degrees")
    out: dict = {"matrix": matrix.tolist(), "fov": fov, "resolution": list(resolution)}
    if abs(settings.pixel_aspect - 1) > 1e-6:
        out["pixel_aspect"] = settings.pixel_aspect
    return out


def _placed(reading: Reading, volumes: Sequence[dict], frame: int) -> list[Placed]:
    if not volumes:
        return []
    plain = [
        {key: v for key, v in volume.items() if key in ("name", "file", "frame", "transform")} for volume in volumes
    ]
    scene = {"scene_version": 2, "camera": {"position": [0, 0, 1], "target": [0, 0, 0]}, "volume": plain}
    path = reading.stage.GetRootLayer().realPath
    shot = _scrim.loads(scene, folder=os.path.dirname(path), name=path, checked_frame=frame)
    return [(v["file"], tuple(np.ravel(v["matrix"]).tolist())) for v in shot.resolved(frame)["volumes"].values()]


@functools.lru_cache(maxsize=16)
def _framed(
    placed: tuple[Placed, ...], up: tuple[float, ...], resolution: tuple[int, int] | None
) -> tuple[np.ndarray, float, tuple[int, int]]:
    """(camera to world, horizontal degrees, resolution)"""
    boxes = [_bounds.of({"": {"file": file, "matrix": np.reshape(matrix, (4, 4))}}) for file, matrix in placed]
    sizes = [float(np.linalg.norm(box[1] - box[0])) if box else 0.0 for box in boxes]
    file, flat = placed[int(np.argmax(sizes))]
    matrix = np.reshape(flat, (4, 4))
    wanted = np.linalg.solve(matrix[:3, :3], np.array(up))
    asset = _scrim.open(file, up=(wanted / np.linalg.norm(wanted)).tolist(), resolution=resolution).resolved(1)[
        "camera"
    ]
    seen = np.array(asset["matrix"])
    turn, scale = _similar(matrix[:3, :3])
    out = np.eye(4)
    out[:3, :3] = turn @ seen[:3, :3]
    if len(placed) == 1 and scale is not None:
        out[:3, 3] = (matrix @ seen[:, 3])[:3]
    else:
        corners = np.array([corner for box in boxes if box for corner in _corners(*box)])
        out[:3, 3] = _eye(out[:3, :3], corners, asset["fov"], asset["resolution"])
    return out, asset["fov"], asset["resolution"]


def _similar(linear: np.ndarray) -> tuple[np.ndarray, float | None]:
    """(the rotation that is nearest to a matrix, the matrix's scale). The scale is None where the matrix is no rotation
    times a scale."""
    left, sizes, right = np.linalg.svd(linear)
    turn = left @ np.diag([1, 1, np.sign(np.linalg.det(left @ right))]) @ right
    is_similar = sizes[0] - sizes[2] < 1e-6 * sizes[0] and np.linalg.det(linear) > 0
    return turn, float(sizes[0]) if is_similar else None


def _corners(low: np.ndarray, high: np.ndarray) -> list[list[float]]:
    return [[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)]


def _eye(axes: np.ndarray, corners: np.ndarray, fov: float, resolution: tuple[int, int]) -> np.ndarray:
    """The nearest place from which a camera with these axes sees all corners, and has their middle straight ahead."""
    center = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    seen = (corners - center) @ axes
    across = np.tan(np.radians(0.5 * fov))
    down = across * resolution[1] / resolution[0]
    needed = seen[:, 2] + _MARGIN * np.maximum(np.abs(seen[:, 0]) / across, np.abs(seen[:, 1]) / down)
    return center + float(needed.max()) * axes[:, 2]
