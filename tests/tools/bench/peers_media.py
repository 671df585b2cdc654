# SPDX-License-Identifier: Apache-2.0
"""Volumes that overlap, for Mitsuba 3: shapes and media of peers_mitsuba.py where its numbers hold "volumes".

A point of a scene of Mitsuba's is in one medium at most: where two cubes with media overlap, their densities do not
add up. So we make boxes that do not overlap, and fill each with the sum of all volumes there. A volume that holds all
others (haze) is the medium around those boxes, and part of each. Volumes whose boxes touch share one box. The sum is a
medium in Python, since Mitsuba has none: it looks up all its grids, each with its own place and its own voxels, so
nothing is resampled. Each box has a majorant of its own.
"""
import drjit as dr
import mitsuba as mi
import numpy as np

CELLS = 24  # along each axis of a box, of which each has an upper bound of the sum
# What a box has beyond its grid, in voxels. If cubes are as symmetrical as the picture, rays through the middles of
# pixels meet the diagonals of faces, and Mitsuba misses some of them there: a black pixel.
BORDER = np.array((0.3, 0.5, 0.7))


class Part:
    """A volume: what it holds, where its voxels are, and a box around them."""

    def __init__(self, volume, array, texture):
        self.scale, self.array, self.texture = volume["scale"], array, texture
        self.voxel = volume["size"] * volume["voxel"]
        middle = np.multiply(volume["size"], volume["origin"]) + volume["translate"]
        self.low = middle - 0.5 * self.voxel
        self.high = self.low + self.voxel * np.array(array.shape)
        self.box = self.low - self.voxel * BORDER, self.high + self.voxel * BORDER

    def density(self, place):
        """Trilinear, and 0 outside, since the border is."""
        low, size = self.low.tolist(), (self.high - self.low).tolist()
        return self.scale * self.texture.eval((place - mi.Point3f(low)) / mi.Vector3f(size))[0]

    def bounds(self, low, high):
        """Upper bounds of the density in CELLS^3 cells of a box."""
        found = self.array
        for axis in range(3):
            edges = (np.linspace(low[axis], high[axis], CELLS + 1) - self.low[axis]) / self.voxel - 0.5
            # A point between two voxels is below the larger of them.
            first = np.clip(np.floor(edges[:-1]), 0, found.shape[axis] - 1).astype(int)
            last = np.clip(np.ceil(edges[1:]), 0, found.shape[axis] - 1).astype(int)
            found = np.stack([found.take(range(a, b + 1), axis).max(axis) for a, b in zip(first, last)], axis)
        return self.scale * found


class Sum(mi.Medium):
    """The sum of parts in a box."""

    def __init__(self, props, numbers, parts, box):
        super().__init__(props)
        self.m_is_homogeneous = self.m_has_spectral_extinction = False
        self.albedo, self.parts = numbers["albedo"], parts
        self.box = mi.ScalarBoundingBox3f(*(c.tolist() for c in box))
        self.majorant = 1.0001 * float(sum(p.bounds(*box) for p in parts).max())

    def intersect_aabb(self, ray):
        return self.box.ray_intersect(ray)

    def get_majorant(self, _, active=True):
        return mi.Color3f(self.majorant)

    def get_scattering_coefficients(self, interaction, active=True):
        found = mi.Color3f(sum(p.density(interaction.p) for p in self.parts))
        return self.albedo * found, dr.maximum(self.majorant - found, 0), found


def overlap(a, b):
    return (a[0] <= b[1]).all() and (b[0] <= a[1]).all()


def disjoint(parts):
    """(box, parts) of boxes that do not overlap and hold all parts."""
    groups = []
    for part in parts:
        box, members = part.box, [part]
        while True:
            met = [g for g in groups if overlap(g[0], box)]
            if not met:
                break
            for other, others in met:
                box = np.minimum(box[0], other[0]), np.maximum(box[1], other[1])
                members = members + others
            groups = [g for g in groups if not any(g is m for m in met)]
        groups.append((box, members))
    return groups


def read_parts(numbers):
    read = {}
    for volume in numbers["volumes"]:
        if volume["array"] not in read:
            array = np.load(volume["array"])  # [x, y, z]
            values = np.ascontiguousarray(array.transpose(2, 1, 0))[..., None]
            read[volume["array"]] = array, mi.Texture3f(mi.TensorXf(values), wrap_mode=dr.WrapMode.Clamp)
        yield Part(volume, *read[volume["array"]])


def media(numbers):
    """({name: shape}, the medium that the eye is in, or None)."""
    parts = list(read_parts(numbers))

    def filled(name, members, box):
        mi.register_medium(name, lambda props: Sum(props, numbers, members, box))
        return mi.load_dict({"type": name, "phase": {"type": "hg", "g": numbers.get("g", 0)}})

    def cube(box, **inside_and_out):
        # A cube of Mitsuba's reaches from -1 to 1.
        middle, half = (box[0] + box[1]) / 2, (box[1] - box[0]) / 2
        to_world = mi.ScalarTransform4f().translate(middle.tolist()).scale(half.tolist())
        return {"type": "cube", "to_world": to_world, "bsdf": {"type": "null"}, **inside_and_out}

    def holds_all(part):
        return len(parts) > 1 and all((part.box[0] < p.box[0]).all() and (p.box[1] < part.box[1]).all()
                                      for p in parts if p is not part)

    around = [p for p in parts if holds_all(p)]
    boxes = disjoint([p for p in parts if p not in around])
    shapes, spaces, outside = {}, [], {}
    if around:
        medium = filled("around", around, around[0].box)
        shapes["around"], outside = cube(around[0].box, interior=medium), {"exterior": medium}
        spaces.append((around[0].box, medium))
    for i, (box, members) in enumerate(boxes):
        medium = filled(f"sum{i}", members + around, box)
        shapes[f"box{i}"] = cube(box, interior=medium, **outside)
        spaces.append((box, medium))
    eye = np.array(numbers["eye"])
    inside = [medium for box, medium in spaces if overlap(box, (eye, eye))]
    return shapes, inside[-1] if inside else None
