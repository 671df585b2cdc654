# SPDX-License-Identifier: Apache-2.0
"""Moving a camera with the mouse: orbit, pan, dolly, and framing a box.

A pose is a camera-to-world matrix (4, 4) of float64 for column vectors, whose columns are right, up, back and the eye,
with the distance of the point that it turns around. Drags are measured in heights of the picture, y downwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

_HALF_TURN = math.pi  # the turn of a drag over the whole height
_POLE = math.radians(1.0)  # least angle between the view and straight up or down, where left and right are undefined
_DOLLY = 2.0  # a drag over the whole height brings the eye nearer by the factor e^2


@dataclass(frozen=True)
class Lens:
    """`fov`: horizontal, radians. `height`: world units of an orthographic picture, None of a perspective one.
    `aspect`: width of the picture over its height."""

    fov: float
    height: float | None
    aspect: float

    def height_at(self, distance: float) -> float:
        """Height of the picture in world units at this distance from the eye."""
        if self.height is not None:
            return self.height
        return 2 * distance * math.tan(0.5 * self.fov) / self.aspect


@dataclass(frozen=True)
class Pose:
    matrix: np.ndarray
    distance: float
    lens: Lens

    @property
    def eye(self) -> np.ndarray:
        return self.matrix[:3, 3]

    @property
    def pivot(self) -> np.ndarray:
        return self.eye - self.distance * self.matrix[:3, 2]

    def orbited(self, up: np.ndarray, dx: float, dy: float) -> Pose:
        """Turned around the pivot: about the world's `up` by dx, and towards it by dy. A drag to the right turns what
        is in front of the pivot to the right; a drag down shows more of its top."""
        back = self.matrix[:3, 2]
        angle = math.acos(float(np.clip(back @ up, -1, 1)))  # from straight above
        wanted = float(np.clip(angle - _HALF_TURN * dy, _POLE, math.pi - _POLE))
        turn = _rotation(up, -_HALF_TURN * dx) @ _rotation(_right_of(self.matrix, up), wanted - angle)
        back = turn @ back
        right = turn @ _right_of(self.matrix, up)
        return replace(self, matrix=_matrix(right, back, self.pivot + self.distance * back))

    def panned(self, dx: float, dy: float) -> Pose:
        """Moved so that the pivot follows the pointer."""
        size = self.lens.height_at(self.distance)
        moved = self.matrix.copy()
        moved[:3, 3] += size * (dy * moved[:3, 1] - dx * moved[:3, 0])
        return replace(self, matrix=moved)

    def dollied(self, dy: float) -> Pose:
        """Brought nearer to the pivot by a drag upwards."""
        factor = math.exp(_DOLLY * dy)
        if self.lens.height is not None:
            return replace(self, lens=replace(self.lens, height=self.lens.height * factor))
        return self._at(self.pivot, self.distance * factor)

    def framed(self, low: Sequence[float], high: Sequence[float]) -> Pose:
        """Moved so that a sphere around the box fills the picture."""
        low, high = np.asarray(low, float), np.asarray(high, float)
        radius = max(0.5 * float(np.linalg.norm(high - low)), 1e-6)
        center = 0.5 * (low + high)
        if self.lens.height is not None:
            height = 2 * radius / min(1.0, self.lens.aspect)
            return replace(self, lens=replace(self.lens, height=height))._at(center, self.distance)
        slope = math.tan(0.5 * self.lens.fov) * min(1.0, 1 / self.lens.aspect)
        return self._at(center, radius / math.sin(math.atan(slope)))

    def _at(self, pivot: np.ndarray, distance: float) -> Pose:
        moved = self.matrix.copy()
        moved[:3, 3] = pivot + distance * moved[:3, 2]
        return replace(self, matrix=moved, distance=distance)


def world_up(matrix: np.ndarray, stated: Sequence[float] | None) -> np.ndarray:
    """The axis that an orbit turns about: the one that the scene's camera states, else the world's axis that is nearest
    to the picture's up."""
    if stated is not None and np.linalg.norm(stated) > 0:
        return np.asarray(stated, float) / np.linalg.norm(stated)
    up = matrix[:3, 1]
    axis = np.zeros(3)
    axis[np.argmax(np.abs(up))] = np.sign(up[np.argmax(np.abs(up))])
    return axis


def angles_of(direction: Sequence[float], up: np.ndarray) -> tuple[float, float]:
    """(azimuth, elevation) in degrees of the place that light along `direction` comes from. The azimuth is 0 on the
    axis after `up` in the order x, y, z, x, and grows against the clock for a viewer at the tip of `up`."""
    first, second = _plane(up)
    source = -np.asarray(direction, float)
    source /= max(float(np.linalg.norm(source)), 1e-12)
    elevation = math.degrees(math.asin(float(np.clip(source @ up, -1, 1))))
    return math.degrees(math.atan2(source @ second, source @ first)), elevation


def direction_of(azimuth: float, elevation: float, up: np.ndarray) -> list[float]:
    """The direction in which light travels: see `angles_of`."""
    first, second = _plane(up)
    a, e = math.radians(azimuth), math.radians(elevation)
    source = math.cos(e) * (math.cos(a) * first + math.sin(a) * second) + math.sin(e) * up
    return [float(part) for part in -source]


def _plane(up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    axis = np.roll(np.eye(3)[np.argmax(np.abs(up))], 1)
    first = axis - (axis @ up) * up
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    # Rodrigues' formula
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def _right_of(matrix: np.ndarray, up: np.ndarray) -> np.ndarray:
    """The direction to the right that is perpendicular to `up`: an orbit has no roll."""
    right = np.cross(up, matrix[:3, 2])
    length = float(np.linalg.norm(right))
    return right / length if length > 1e-6 else matrix[:3, 0]


def _matrix(right: np.ndarray, back: np.ndarray, eye: np.ndarray) -> np.ndarray:
    back = back / np.linalg.norm(back)
    right = right - (right @ back) * back
    right = right / np.linalg.norm(right)
    out = np.eye(4)
    out[:3, 0], out[:3, 1], out[:3, 2], out[:3, 3] = right, np.cross(back, right), back, eye
    return out
