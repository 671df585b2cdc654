# SPDX-License-Identifier: Apache-2.0
"""Lights by where they are in the picture: handles that are dragged, and the light that makes a highlight at a place.

Places in the picture are (x, y), 0 to 1 from its upper left corner. A light with a position has its handle there, and
moves in the plane through the light that is parallel to the film. The handle of a light with a direction shows where on
a ball around the view's pivot the light comes from: inside the ball's outline for its front half; outside the outline
for its back half, the farther out the farther back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ._camera import Pose
from ._document import Change, name_of
from ._messages import is_number

SUN_ELEVATION = 15.0  # of a sky that states none, degrees
RADIUS = 0.35  # of the ball around the pivot, in heights of the picture
_REACH = 0.03  # heights of the picture on each side of a place, from which the surface's normal is taken
_STEPS = 5  # places on each side


@dataclass(frozen=True)
class View:
    """A pose, and the shift of the film to the right and up, in widths of the film."""

    pose: Pose
    shift: tuple[float, float] = (0.0, 0.0)

    def as_data(self) -> dict:
        """The view as the page warps pictures by it. `matrix`: by columns. `width`: of the picture in the world, at 1
        from the eye; of a `flat` one everywhere."""
        lens = self.pose.lens
        return {
            "matrix": self.pose.matrix.T.ravel().tolist(),
            "width": lens.height_at(1.0) * lens.aspect,
            "flat": lens.height is not None,
            "aspect": lens.aspect,
            "shift": list(self.shift),
            "distance": self.pose.distance,
        }

    def seen(self, point: np.ndarray) -> tuple[float, float, float]:
        """(x, y, depth): the place of a point in the picture, and its distance along the view."""
        x, y, z = self.pose.matrix[:3, :3].T @ (point - self.pose.eye)
        across = self.pose.lens.height_at(max(-z, 1e-9)) * self.pose.lens.aspect
        aspect = self.pose.lens.aspect
        return 0.5 + x / across - self.shift[0], 0.5 - (y / across - self.shift[1]) * aspect, -z

    def point(self, x: float, y: float, ahead: float) -> np.ndarray:
        """The point of the world that is seen at a place in the picture, at the depth `ahead`."""
        lens = self.pose.lens
        across = lens.height_at(ahead) * lens.aspect
        place = ((x - 0.5 + self.shift[0]) * across, ((0.5 - y) / lens.aspect + self.shift[1]) * across, -ahead)
        return self.pose.eye + self.pose.matrix[:3, :3] @ place


def of(scene: Mapping, view: View) -> list[dict]:
    """A handle for each light whose position or direction is plain numbers: `light`, its name; `kind`, "place" or
    "way"; `x`, `y`, the handle's place in the picture."""
    out = []
    for index, light in enumerate(scene.get("light", [])):
        kind = _kind(light)
        if kind == "place":
            x, y, ahead = view.seen(np.array(light["position"], float))
        elif kind == "way":
            x, y, ahead = *_on_ball(light["direction"], view), 1.0
        elif kind == "sky":
            x, y, ahead = *_on_ball(_from_sun(light), view), 1.0
        if kind and ahead > 0:
            shown = "way" if kind == "sky" else kind
            out.append({"light": name_of("light", index, light), "kind": shown, "x": float(x), "y": float(y)})
    return out


def moved(scene: Mapping, index: int, view: View, x: float, y: float) -> list[Change]:
    """The changes that bring the handle of a light to a place in the picture. The light must have a handle."""
    light = scene["light"][index]
    if _kind(light) == "place":
        ahead = view.seen(np.array(light["position"], float))[2]
        return [(("light", index, "position"), view.point(x, y, ahead).tolist())]
    return _along(light, index, _from_ball(view, x, y))


def _along(light: Mapping, index: int, direction: np.ndarray) -> list[Change]:
    """The changes that make a light without a place shine along a direction."""
    if _kind(light) == "way":
        return [(("light", index, "direction"), direction.tolist())]
    up, front, right = _sky_axes(light)
    elevation = np.degrees(np.arcsin(np.clip(-direction @ up, -1.0, 1.0)))
    rotation = np.degrees(np.arctan2(-direction @ right, -direction @ front))
    return [
        (("light", index, "sky", "sun_elevation"), float(elevation)),
        (("light", index, "rotation"), float(rotation)),
    ]


def has_handle(light: Mapping) -> bool:
    return bool(_kind(light))


def _kind(light: Mapping) -> str:
    if "orbit" in light:
        return ""
    sky = light.get("sky")
    if isinstance(sky, Mapping):
        place = sky.get("sun_elevation", SUN_ELEVATION), light.get("rotation", 0.0)
        return "sky" if all(map(is_number, place)) else ""
    if _is_triple(light.get("position")):
        return "place"
    return "way" if _is_triple(light.get("direction")) and "target" not in light else ""


def _is_triple(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(isinstance(v, (int, float)) for v in value)


def _sky_axes(light: Mapping) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Up, and where the sun of a sky stands at the horizon with a `rotation` of 0 and of 90 degrees: +z and +x, carried
    along by the shortest turn of +y to up."""
    up = np.array(light.get("up", [0.0, 1.0, 0.0]), float)
    up /= np.linalg.norm(up)
    if up[1] < -1 + 1e-9:
        return up, np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    x, y, z = up
    front = np.array([-x * z / (1 + y), -z, 1 - z * z / (1 + y)])
    right = np.array([1 - x * x / (1 + y), -x, -x * z / (1 + y)])
    return up, front, right


def _from_sun(light: Mapping) -> list[float]:
    """The direction in which the light of a sky's sun travels."""
    up, front, right = _sky_axes(light)
    e, r = np.radians((light["sky"].get("sun_elevation", SUN_ELEVATION), light.get("rotation", 0.0)))
    return (-(np.cos(e) * (np.cos(r) * front + np.sin(r) * right) + np.sin(e) * up)).tolist()


def _on_ball(direction: list[float], view: View) -> tuple[float, float]:
    source = -np.array(direction, float)
    right, up, back = view.pose.matrix[:3, :3].T @ (source / max(float(np.linalg.norm(source)), 1e-12))
    length = float(np.hypot(right, up))
    if back < 0:  # behind: mirrored at the outline
        right, up = (v * (2 - length) / length for v in (right, up)) if length > 1e-9 else (2.0, 0.0)
    x, y, _ = view.seen(view.pose.pivot)
    return x + RADIUS * right / view.pose.lens.aspect, y - RADIUS * up


def _from_ball(view: View, x: float, y: float) -> np.ndarray:
    middle = view.seen(view.pose.pivot)
    right, up = (x - middle[0]) * view.pose.lens.aspect / RADIUS, (middle[1] - y) / RADIUS
    length = float(np.hypot(right, up))
    flat = min(length, max(2 - length, 0.0))
    scale = flat / length if length > 0 else 0.0
    back = float(np.sqrt(max(1 - flat * flat, 0.0))) * (1 if length <= 1 else -1)
    return -(view.pose.matrix[:3, :3] @ (right * scale, up * scale, back))


def highlit(scene: Mapping, index: int, view: View, depth: np.ndarray, x: float, y: float) -> list[Change] | None:
    """The changes that make a light shine brightest on the surface that is seen at a place: a medium from straight in
    front of it, a classified surface so that it reflects the light to the eye. A light with a position keeps its
    distance. None where nothing is seen. `depth`: along the view, (height, width), 0 where it is empty."""
    found = _surface(view, depth, x, y)
    if found is None:
        return None
    point, normal = found
    if any("classified" in volume for volume in scene.get("volume", [])):
        eye = view.pose.eye - point if view.pose.lens.height is None else view.pose.matrix[:3, 2]
        eye = eye / np.linalg.norm(eye)
        source = 2 * float(normal @ eye) * normal - eye
    else:
        source = normal
    light = scene["light"][index]
    if _kind(light) == "place":
        distance = float(np.linalg.norm(np.array(light["position"], float) - point))
        changes: list[Change] = [(("light", index, "position"), (point + distance * source).tolist())]
        if "target" in light:
            changes.append((("light", index, "target"), point.tolist()))
        elif "direction" in light:
            changes.append((("light", index, "direction"), (-source).tolist()))
        return changes
    return _along(light, index, -source)


def _surface(view: View, depth: np.ndarray, x: float, y: float) -> tuple[np.ndarray, np.ndarray] | None:
    """The point that is seen, and the normal of the plane that fits best to the points that are seen around it."""
    height, width = depth.shape
    column, row = min(int(x * width), width - 1), min(int(y * height), height - 1)
    if depth[row, column] <= 0:
        return None
    steps = np.unique(np.rint(np.linspace(-1, 1, 2 * _STEPS + 1) * max(_REACH * height, _STEPS)).astype(int))
    rows, columns = (at + steps for at in (row, column))
    rows, columns = rows[(rows >= 0) & (rows < height)], columns[(columns >= 0) & (columns < width)]
    near = depth[np.ix_(rows, columns)]
    places = [
        view.point((c + 0.5) / width, (r + 0.5) / height, float(near[i, j]))
        for i, r in enumerate(rows)
        for j, c in enumerate(columns)
        if near[i, j] > 0
    ]
    point = view.point(x, y, float(depth[row, column]))
    eye = view.pose.eye - point if view.pose.lens.height is None else view.pose.matrix[:3, 2]
    eye = eye / np.linalg.norm(eye)
    if len(places) < 4:
        return point, eye
    _, sizes, axes = np.linalg.svd(np.array(places) - np.mean(places, axis=0))
    normal = axes[2] if sizes[1] > 1e-9 else eye
    return point, normal if normal @ eye > 0 else -normal
