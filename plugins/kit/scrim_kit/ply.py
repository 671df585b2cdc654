# SPDX-License-Identifier: Apache-2.0
"""Meshes as binary PLY files, which the `file` of a [[mesh]] names."""

from __future__ import annotations

import os
import sys

_FACE = 13  # bytes: the number of corners, and three indices


def write(path: str | os.PathLike[str], points: object, triangles: object) -> None:
    """Writes a mesh. `points` are x, y, z of one vertex after the other, 32-bit floats; `triangles` are three numbers
    of vertices each, 32-bit integers. Both are buffers of any shape, such as arrays of Python or of NumPy. Raises
    TypeError where they hold other numbers, and OSError where the file cannot be written."""
    xyz, corners = _words(points, "f"), _words(triangles, "i")
    count = len(corners) // 12
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(xyz) // 12}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    # One byte of all faces at a time: a loop over faces takes fifty times as long.
    faces = bytearray(_FACE * count)
    faces[::_FACE] = b"\x03" * count
    for i in range(12):
        faces[i + 1 :: _FACE] = corners[i::12]
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(xyz)
        file.write(faces)


def _words(buffer: object, kind: str) -> bytes:
    """The bytes of 32-bit words, the lowest byte first."""
    view = memoryview(buffer)
    if view.format.lstrip("<=@") != kind:
        raise TypeError(f"a mesh has a buffer of format '{view.format}', expected '{kind}'")
    words = bytearray(view.tobytes())
    if sys.byteorder == "big":
        for i in range(2):
            words[i::4], words[3 - i :: 4] = words[3 - i :: 4], words[i::4]
    return bytes(words)
