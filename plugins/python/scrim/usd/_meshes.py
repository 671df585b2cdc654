# SPDX-License-Identifier: Apache-2.0
"""Gprims as [[mesh]]: triangles in binary PLY files, in the folder of the reading."""

from __future__ import annotations

import hashlib
import os
from array import array

from pxr import Usd, UsdGeom, UsdVol
from scrim_kit import ply
from scrim_kit.frames import pattern_of

from . import _motion, _own
from ._reading import Item, Reading

_CUBE = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def is_solid(prim: Usd.Prim) -> bool:
    return prim.IsA(UsdGeom.Gprim) and not prim.IsA(UsdVol.Volume)


def _triangles(counts: list[int], corners: list[int], holes: set[int]) -> array:
    out, start = array("i"), 0
    for face, count in enumerate(counts):
        if face not in holes:
            for k in range(1, count - 1):
                out.extend((corners[start], corners[start + k], corners[start + k + 1]))
        start += count
    return out


def _of_mesh(reading: Reading, prim: Usd.Prim) -> tuple[array, array] | None:
    mesh = UsdGeom.Mesh(prim)
    points = array("f", [c for p in reading.get(mesh.GetPointsAttr(), otherwise=[]) for c in p])
    counts = list(reading.get(mesh.GetFaceVertexCountsAttr(), otherwise=[]))
    corners = list(reading.get(mesh.GetFaceVertexIndicesAttr(), otherwise=[]))
    if sum(counts) != len(corners) or (corners and not 0 <= min(corners) <= max(corners) < len(points) // 3):
        reading.warn(prim, "its faces do not fit its points, and it is left out")
        return None
    if reading.get(mesh.GetSubdivisionSchemeAttr()) != UsdGeom.Tokens.none:
        reading.warn(prim, "it is not subdivided: its control cage hides and shadows")
    if any(count > 4 for count in counts):
        reading.warn(prim, "faces of more than four corners are cut into fans, which is right where they are convex")
    triangles = _triangles(counts, corners, set(reading.get(mesh.GetHoleIndicesAttr(), otherwise=[])))
    if reading.get(mesh.GetOrientationAttr()) == UsdGeom.Tokens.leftHanded:
        triangles.reverse()
    return points, triangles


def _of_quads(points: list[tuple[float, float, float]], quads: list[tuple[int, ...]]) -> tuple[array, array]:
    flat = array("f", [c for p in points for c in p])
    return flat, _triangles([4] * len(quads), [i for q in quads for i in q], set())


def _of_cube(reading: Reading, prim: Usd.Prim) -> tuple[array, array]:
    half = 0.5 * reading.get(UsdGeom.Cube(prim).GetSizeAttr())
    return _of_quads([(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)], _CUBE)


def _of_plane(reading: Reading, prim: Usd.Prim) -> tuple[array, array]:
    plane = UsdGeom.Plane(prim)
    w, h = 0.5 * reading.get(plane.GetWidthAttr()), 0.5 * reading.get(plane.GetLengthAttr())
    flat = [(-w, -h), (w, -h), (w, h), (-w, h)]
    turned = {
        "X": [(0.0, y, -x) for x, y in flat],
        "Y": [(x, 0.0, -y) for x, y in flat],
        "Z": [(x, y, 0.0) for x, y in flat],
    }
    return _of_quads(turned[str(reading.get(plane.GetAxisAttr()))], [(0, 1, 2, 3)])


def _shape(reading: Reading, prim: Usd.Prim) -> tuple[array, array] | None:
    """(x, y, z of point after point, three numbers of points for each triangle); None where the solid is of another
    type."""
    if prim.IsA(UsdGeom.Mesh):
        return _of_mesh(reading, prim)
    if prim.IsA(UsdGeom.Cube):
        return _of_cube(reading, prim)
    if prim.IsA(UsdGeom.Plane):
        return _of_plane(reading, prim)
    reading.warn(prim, f"solids of type {prim.GetTypeName()} neither hide volumes nor shadow them; only meshes do")
    return None


def _file(reading: Reading, prim: Usd.Prim) -> str | None:
    """The file of a solid's shape, as a scene names it. Instances and frames with the same shape share one file. None:
    there are no triangles."""
    shape = _shape(reading, prim)
    if shape is None or not len(shape[1]):
        return None
    name = hashlib.sha256(shape[0].tobytes() + shape[1].tobytes()).hexdigest()[:24] + ".ply"
    path = os.path.join(reading.folder, name)
    if not os.path.exists(path):
        ply.write(path + ".part", *shape)
        os.replace(path + ".part", path)
    return pattern_of(path)


def read(reading: Reading, item: Item, sidecar: _own.Sidecar) -> dict | None:
    """A [[mesh]]; None where the solid has no triangles."""
    path = _file(reading, item.prim)
    if path is None:
        return None
    points = UsdGeom.PointBased(item.prim).GetPointsAttr() if item.prim.IsA(UsdGeom.PointBased) else None
    if len(reading.times) > 1 and points and points.ValueMightBeTimeVarying():
        reading.warn(item.prim, "its points move: while the shutter is open those of the frame are taken")
    out = {"name": reading.name(item), "file": path}
    place = _motion.transform(reading, item, lambda time: reading.world(item, time))
    if place:
        out["transform"] = place
    if reading.options.meshes in ("shadows", "none"):  # "none": only solids that give light are read at all
        out["holdout"] = False
    if reading.options.meshes == "none":
        out["shadows"] = False
    _own.merge(out, _own.attributes(reading, item.prim))
    _own.merge(out, sidecar.of(item.prim))
    return out
