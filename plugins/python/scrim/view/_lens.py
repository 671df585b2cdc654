# SPDX-License-Identifier: Apache-2.0
"""Controls of the camera: its angle, and what its lens blurs (examples/guide/cameras.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .._errors import UsageError
from ._control_maker import Control, Group, Maker
from ._document import Change

_CAMERA = ("camera",)
_FSTOP = 2.8  # of a new lens
_LENS = ("fstop", "lens_radius", "focus_distance", "world_unit")


def group_of(scene: Mapping, distance: float) -> Group:
    """`distance`: where a new lens focuses."""
    make = Maker(scene, (), "scene")
    if make.has("camera", "focal_length"):
        make.add("focal length", "number", ("camera", "focal_length"), 50.0, least=8.0, most=400.0, log=True, unit="mm")
    elif not make.has("camera", "exr") and not make.has("camera", "height"):
        make.add("field of view", "number", ("camera", "fov"), 35.0, least=5.0, most=120.0, log=True, unit="°")
    if _takes_lens(scene):
        _add_lens(make, distance)
    return Group("camera", "camera", "Camera", make.controls)


def _takes_lens(scene: Mapping) -> bool:
    camera = scene.get("camera", {})
    return camera.get("type") != "orthographic" and "exr" not in camera


def _add_lens(make: Maker, distance: float) -> None:
    is_there = make.has("camera", "fstop") or make.has("camera", "lens_radius")

    def changes(on: bool) -> list[Change]:
        return _new_lens(distance) if on else [((*_CAMERA, key), None) for key in _LENS]

    make.controls.append(Control("scene.camera.lens", "depth of field", "switch", is_there, changes))
    if make.has("camera", "lens_radius"):
        make.add("lens radius", "number", ("camera", "lens_radius"), 0.0, least=1e-4 * distance, most=distance,
                 log=True, zero=True, unit="units")  # fmt: skip
    elif is_there:
        make.add("f-stop", "number", ("camera", "fstop"), _FSTOP, least=0.5, most=64.0, log=True)
        make.add("world unit", "number", ("camera", "world_unit"), 1000.0, least=1.0, most=1e6, log=True, unit="mm")
    if is_there:
        make.add("focus distance", "number", ("camera", "focus_distance"), distance, least=0.05 * distance,
                 most=20 * distance, log=True, unit="units")  # fmt: skip


def _new_lens(distance: float) -> list[Change]:
    return [((*_CAMERA, "fstop"), _FSTOP), ((*_CAMERA, "focus_distance"), distance)]


def focused(scene: Mapping, depth: np.ndarray, x: float, y: float) -> list[Change]:
    """The changes that make the lens sharp at what is seen at a place of the picture, 0 to 1 from its upper left
    corner; a camera without a lens gets one. `depth`: along the view, (height, width), 0 where nothing is."""
    if not _takes_lens(scene):
        raise UsageError("only a perspective camera that the scene itself describes has a lens that can focus")
    height, width = depth.shape
    ahead = float(depth[min(max(int(y * height), 0), height - 1), min(max(int(x * width), 0), width - 1)])
    if ahead <= 0:
        raise UsageError("there is nothing to focus on at this place")
    has_lens = any(key in scene.get("camera", {}) for key in ("fstop", "lens_radius"))
    return [((*_CAMERA, "focus_distance"), ahead)] if has_lens else _new_lens(ahead)
