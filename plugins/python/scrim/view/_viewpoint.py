# SPDX-License-Identifier: Apache-2.0
"""From where the viewer looks: the scene's camera, or a free view until it is kept."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .. import _bounds
from .._errors import UsageError
from ._camera import Lens, Pose, world_up
from ._document import Change


class Viewpoint:
    """`free`: the pose of the free view; None: the scene's camera. `places`: where volumes are. `read` comes before all
    else."""

    def __init__(self, places: _bounds.Places) -> None:
        self._places = places
        self.free: Pose | None = None
        self._camera: Mapping = {}
        self._resolved: Mapping = {}

    def read(self, data: Mapping, resolved: Mapping) -> None:
        """Takes a scene. `resolved`: its `Shot.resolved`."""
        self._camera, self._resolved = data.get("camera", {}), resolved
        self._places.of(resolved["volumes"])  # asks for the boxes before they are needed

    @property
    def up(self) -> np.ndarray:
        stated = self._camera.get("up") if isinstance(self._camera.get("up"), list) else None
        return world_up(np.array(self._resolved["camera"]["matrix"]), stated)

    @property
    def pose(self) -> Pose:
        """The pose of the view: the free one, else that of the scene's camera."""
        return self.free or self._of_scene()

    @property
    def resolution(self) -> tuple[int, int]:
        return tuple(self._resolved["camera"]["resolution"])

    @property
    def shift(self) -> tuple[float, float]:
        return tuple(self._resolved["camera"]["shift"])

    @property
    def aspect(self) -> float:
        width, height = self.resolution
        return self._resolved["camera"]["pixel_aspect"] * width / height

    def _of_scene(self) -> Pose:
        camera = self._resolved["camera"]
        is_flat = camera["type"] == "orthographic"
        lens = Lens(np.radians(camera["fov"]), camera["height"] if is_flat else None, self.aspect)
        matrix = np.array(camera["matrix"])
        eye, ahead = matrix[:3, 3], -matrix[:3, 2]
        target = self._camera.get("target")
        if isinstance(target, list):
            distance = float((np.array(target, float) - eye) @ ahead)
        elif box := self._places.of(self._resolved["volumes"]):
            distance = float((0.5 * (box[0] + box[1]) - eye) @ ahead)
        else:
            distance = float(np.linalg.norm(eye))
        return Pose(matrix, max(distance, 1e-3), lens)

    def move(self, mode: object, dx: float, dy: float) -> None:
        pose = self.pose
        if mode == "orbit":
            self.free = pose.orbited(self.up, dx, dy)
        elif mode == "pan":
            self.free = pose.panned(dx, dy)
        elif mode == "dolly":
            self.free = pose.dollied(dy)
        else:
            raise UsageError(f"the page asks for the movement '{mode}'; expected orbit, pan or dolly")

    def ask_again(self) -> None:
        """Asks anew for the boxes of files that could not be read."""
        self._places.ask_again()

    def frame_all(self) -> bool:
        """Moves the view so that all volumes are seen. False: their boxes are not known yet."""
        volumes = self._resolved["volumes"]
        box = self._places.of(volumes)
        if self._places.waits:
            return False
        if box is None:
            files = [volume["file"] for volume in volumes.values() if volume["file"]]
            raise UsageError(
                f"'{files[0]}' does not say where its voxels are" if files else
                "the volumes of this scene are not files, so their size is not known before a render"
            )
        self.free = self.pose.framed(*box)
        return True

    def overrides(self) -> dict:
        """The free view as overrides of the scene's camera."""
        if self.free is None:
            return {}
        camera, over = self._resolved["camera"], {"camera.matrix": self.free.matrix.tolist()}
        if self.free.lens.height is not None:
            over["camera.height"] = self.free.lens.height
        if "exr" in self._camera:  # the picture also gave the lens
            over |= {f"camera.{key}": camera[key] for key in ("fov", "shift", "pixel_aspect")}
        return over

    def kept(self) -> list[Change]:
        """The changes that make the free view the scene's camera."""
        if self.free is None:
            raise UsageError("the view is that of the scene's camera")
        if any(isinstance(value, dict) and "keys" in str(value) for value in self._camera.values()):
            raise UsageError("the scene's camera has keys, which a still view would replace: edit the file")
        camera = ("camera",)
        changes: list[Change] = [((*camera, key), None) for key in ("matrix", "orbit", "exr", "ndc")]
        places = {"position": self.free.eye, "target": self.free.pivot, "up": self.up}
        changes += [((*camera, key), [float(v) for v in value]) for key, value in places.items()]
        over = self.overrides()
        return changes + [((*camera, key[7:]), value) for key, value in over.items() if key != "camera.matrix"]
