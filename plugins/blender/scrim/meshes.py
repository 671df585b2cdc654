# SPDX-License-Identifier: Apache-2.0
# A mesh of Blender as a binary PLY of triangles.
import numpy as np


def triangles_of(mesh):
    """(vertices n x 3, indices m x 3) of an evaluated mesh."""
    mesh.calc_loop_triangles()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    return points.reshape(-1, 3), corners.reshape(-1, 3)


def write_ply(path, points, corners):
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(corners), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    faces["n"], faces["v"] = 3, corners
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(np.ascontiguousarray(points, "<f4").tobytes())
        file.write(faces.tobytes())
