# SPDX-License-Identifier: Apache-2.0
"""New lights with usual values, placed so that their effect is seen, and the removal of lights."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from .._errors import UsageError
from ._camera import Pose
from ._document import Change, name_of

KINDS = ("distant", "point", "sphere", "rectangle", "dome")
_IRRADIANCE = 4 * math.pi  # thin white smoke is then as bright as a white card
_FROM = (0.6, 0.65, 0.45)  # to the right of the view, above, towards the eye
_FAR = 0.3  # heights of the picture between a new light and the view's pivot
_SIZE = 0.08  # of a new light, in heights of the picture


def added(scene: Mapping, kind: object, pose: Pose, shining: Mapping[str, list[float]]) -> dict:
    """The table of a new light. `shining`: what `Shot.resolved` says of the lights."""
    if kind not in KINDS:
        raise UsageError(f"the page asks for a light {kind!r}; expected {', '.join(KINDS)}")
    known = {name_of("light", index, light) for index, light in enumerate(scene.get("light", []))}
    name = next(name for name in (kind, *(f"{kind}{i}" for i in range(2, len(known) + 3))) if name not in known)
    size = pose.lens.height_at(pose.distance)
    way = pose.matrix[:3, :3] @ np.array(_FROM) / np.linalg.norm(_FROM)
    far = _FAR * size * float(np.linalg.norm(_FROM)) / max(_FROM[:2])
    irradiance = _irradiance(scene, shining)
    place = {"position": _short(pose.pivot + far * way), "target": _short(pose.pivot)}
    edge = _digits(_SIZE * size)
    shapes: dict[str, dict] = {
        "distant": {"direction": _short(-way), "intensity": irradiance},
        "point": {"position": place["position"], "intensity": irradiance * far**2},
        "sphere": {"shape": "sphere", "position": place["position"], "radius": edge, "normalize": True,
                   "intensity": 4 * irradiance * far**2},
        "rectangle": {"shape": "rectangle", **place, "width": 2 * edge, "height": 2 * edge, "normalize": True,
                      "intensity": irradiance * far**2},
        "dome": {"intensity": irradiance / (4 * math.pi)},
    }  # fmt: skip
    made = {"name": name, "type": "area" if "shape" in shapes[kind] else kind, **shapes[kind]}
    made["intensity"] = _digits(made["intensity"])
    return made


def removed(scene: Mapping, index: int) -> list[Change]:
    """The changes that remove a light. Later lights without names are known by their numbers, which change: the default
    names that they have now are written into the scene."""
    lights = scene["light"]
    gone = name_of("light", index, lights[index])
    changes: list[Change] = [
        (("light", i, "name"), name_of("light", i, light))
        for i, light in enumerate(lights)
        if i > index and "name" not in light
    ]
    for i, volume in enumerate(scene.get("volume", [])):
        for key in ("lights", "shadows"):
            names = volume.get(key)
            if isinstance(names, list) and gone in names:
                changes.append((("volume", i, key), [name for name in names if name != gone]))
    return [*changes, (("light", index), None)]


def _irradiance(scene: Mapping, shining: Mapping[str, list[float]]) -> float:
    """The irradiance of a new light: that of the scene's brightest sun, so that both are seen."""
    suns = [
        max(shining.get(name_of("light", index, light), [0.0]))
        for index, light in enumerate(scene.get("light", []))
        if light.get("type") == "distant"
    ]
    return max(suns, default=0.0) or _IRRADIANCE


def _digits(value: float) -> float:
    return float(f"{value:.3g}")


def _short(point: np.ndarray) -> list[float]:
    """The vector, rounded to a thousandth of its largest component."""
    most = float(np.abs(point).max())
    digits = 3 - math.ceil(math.log10(most)) if most > 0 else 3
    return [round(float(v), digits) + 0.0 for v in point]
