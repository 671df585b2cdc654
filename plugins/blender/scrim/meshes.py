# SPDX-License-Identifier: Apache-2.0
# The triangles of a mesh of Blender.
import numpy as np


def triangles_of(mesh):
    """(vertices n x 3, indices m x 3) of an evaluated mesh."""
    mesh.calc_loop_triangles()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    return points.reshape(-1, 3), corners.reshape(-1, 3)
