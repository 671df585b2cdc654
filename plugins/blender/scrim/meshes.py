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


def materials_of(mesh):
    """The index of each triangle's material (m), after triangles_of."""
    slots = np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("material_index", slots)
    return slots


def shining(corners, opaque):
    """Triangles that shine as Cycles' do, to both sides: twice, once either way round. What a closed surface sends
    inwards does not leave it if it is opaque."""
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    closed = np.array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    return corners if closed and opaque else np.concatenate([corners, corners[:, ::-1]])
