# SPDX-License-Identifier: Apache-2.0
"""`transform` of a volume or mesh: a matrix, or keys where it moves while the shutter is open."""

from __future__ import annotations

import math

from pxr import Gf

from ._reading import Item, Reading, numbers, rows


def _rotation(axes: list[Gf.Vec3d], before: list[float] | None) -> list[float]:
    """Angles in degrees about x, then y, then z, that turn the axes of the world to `axes`. Of all such angles those
    that are nearest to `before`."""
    (xx, xy, xz), (yx, yy, yz), (_, _, zz) = (numbers(a) for a in axes)
    y = math.asin(min(max(-xz, -1.0), 1.0))
    angles = [math.atan2(yz, zz), y, math.atan2(xy, xx)]
    if math.cos(y) < 1e-6:  # a turn of 90 degrees about y: x and z then turn about the same axis
        angles = [0.0, y, math.atan2(-yx, yy)]
    out = [math.degrees(a) for a in angles]
    if before is None:
        return out
    other = [out[0] + 180, 180 - out[1], out[2] + 180]
    both = [[a + 360 * round((b - a) / 360) for a, b in zip(one, before)] for one in (out, other)]
    return min(both, key=lambda one: sum((a - b) ** 2 for a, b in zip(one, before)))


def _parts(matrix: Gf.Matrix4d, before: list[float] | None) -> tuple[list[float], list[float], list[float]] | None:
    """(translate, rotate, scale) of a matrix; None where it shears or flattens. `before`: `rotate` of the last time."""
    axes = [Gf.Vec3d(matrix.GetRow3(i)) for i in range(3)]
    scale = [a.GetLength() for a in axes]
    if min(scale) <= 0:
        return None
    units = [a / s for a, s in zip(axes, scale)]
    if max(abs(Gf.Dot(units[i], units[j])) for i, j in ((0, 1), (0, 2), (1, 2))) > 1e-5:
        return None
    if Gf.Dot(Gf.Cross(units[0], units[1]), units[2]) < 0:
        units[0], scale[0] = -units[0], -scale[0]
    return numbers(matrix.ExtractTranslation()), _rotation(units, before), scale


def transform(reading: Reading, item: Item, matrix_at: object) -> dict:
    now = matrix_at(reading.frame)
    matrices = [matrix_at(time) for time in reading.times]
    if all(Gf.IsClose(m, matrices[0], 1e-9) for m in matrices):
        return {} if now == Gf.Matrix4d(1) else {"matrix": rows(now)}
    keys: list[list] = [[], [], []]
    before = None
    for time, matrix in zip(reading.times, matrices):
        parts = _parts(matrix, before)
        if parts is None:
            reading.warn(item.prim, "it is sheared, so its motion is not blurred")
            return {"matrix": rows(now)}
        before = parts[1]
        for to, value in zip(keys, parts):
            to.append([time, value])
    return {name: {"keys": k} for name, k in zip(("translate", "rotate", "scale"), keys)}
