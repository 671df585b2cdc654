# SPDX-License-Identifier: Apache-2.0
# Where things are while the shutter is open: the matrices of all instances at a few times, and keys of a scene where
# they differ.
import math


def key_of(instance):
    """The same thing at another time. Full names have that of a library, since what is linked may be called as
    something of this file is."""
    parent = instance.parent.name_full if instance.parent else ""
    return (instance.object.name_full, parent, tuple(instance.persistent_id) if instance.is_instance else ())


def matrices(depsgraph, camera_matrix):
    out = {key_of(i): i.matrix_world.copy() for i in depsgraph.object_instances}
    out["camera"] = camera_matrix.copy()
    return out


def _near(a, b):
    return all(math.isclose(x, y, rel_tol=1e-6, abs_tol=1e-7) for r, s in zip(a, b) for x, y in zip(r, s))


class Moves:
    def __init__(self, now, frame, samples=(), shutter=None):
        """`now`: matrices of the frame. `samples`: [time about the frame, matrices] in order; `shutter`:
        [opens, closes] or None."""
        self.now, self.frame, self.samples, self.shutter = now, frame, samples, shutter

    def matrix(self, key):
        return self.now[key]

    def _seen(self, key):
        """[(time, matrix)] of a thing that moves; [] where it stands still."""
        seen = [(self.frame + time, there[key]) for time, there in self.samples if key in there]
        return seen if len(seen) > 1 and any(not _near(m, seen[0][1]) for _, m in seen) else []

    def keyed(self, key, value):
        """`value(matrix)`; keyed where it changes."""
        seen = self._seen(key)
        if not seen:
            return value(self.now[key])
        return {"keys": [[time, value(matrix)] for time, matrix in seen]}

    def transform(self, key, warn, name):
        seen = self._seen(key)
        rows = [[float(v) for v in row] for row in self.now[key]]
        if not seen:
            return {"matrix": rows}
        places = [(time, *matrix.decompose()) for time, matrix in seen]
        for (_, place, turn, scale), (_, matrix) in zip(places, seen):
            if not _near(type(matrix).LocRotScale(place, turn, scale), matrix):
                warn(f"{name}: is sheared, so its motion is not blurred")
                return {"matrix": rows}
        angles, before = [], None
        for _, _, turn, _ in places:
            before = turn.to_euler("XYZ", before) if before else turn.to_euler("XYZ")
            angles.append([math.degrees(a) for a in before])

        def keys(values):
            return {"keys": [[time, [float(c) for c in v]] for (time, *_), v in zip(places, values)]}

        return {
            "translate": keys([p[1] for p in places]),
            "rotate": keys(angles),
            "scale": keys([p[3] for p in places]),
        }
