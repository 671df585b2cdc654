# SPDX-License-Identifier: Apache-2.0
"""Lights of other programs in Scrim's units: plain numbers in, numbers or tables of a scene out, each law once.

Scrim's units: the `intensity` of a distant light is what thin smoke gets from all of the sun, its radiance times its
solid angle; that of a point or spot is radiant intensity; that of an area or dome is radiance. Lengths are world units.
Angles are radians here where they are not called degrees.

`cycles_*` are laws of Cycles, each with the place in its source text where it was read. `usd_*` are those of UsdLux
25.05: intensity * 2^exposure * color is a radiance L, and `normalize` divides it by a size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

_LEAST = 1e-12  # radius of a light that counts as a sphere


def sun_solid_angle(half: float) -> float:
    """The solid angle of a sun whose disk has this angular radius: 2 pi (1 - cos(half)), without the difference."""
    return 4 * math.pi * math.sin(0.5 * half) ** 2


def sun_on_card(half: float) -> float:
    """Irradiance, on a card that faces it, of a sun of radiance 1 with this angular radius: the integral of the cosine.
    A card gets less from the sun's rim than smoke does, and nothing from behind."""
    sine = math.sin(half) ** 2
    return math.pi * (sine if half <= 0.5 * math.pi else 2 - sine)


def shining(strength: Sequence[float], factor: float) -> dict:
    """`color` with a largest part of 1 and `intensity` of a scene's light, whose product is strength * factor. Parts
    below 0 count as 0: lights do not take light away."""
    strength = [max(s, 0.0) for s in strength]
    most = max(strength)
    if most <= 0:
        return {"color": [1.0, 1.0, 1.0], "intensity": 0.0}
    return {"color": [s / most for s in strength], "intensity": most * factor}


def cycles_strength(
    color: Sequence[float],
    energy: float,
    exposure: float = 0.0,
    temperature_color: Sequence[float] = (1.0, 1.0, 1.0),
) -> list[float]:
    """What all laws of Cycles begin with: color * energy * 2^exposure * the colour of the light's temperature."""
    return [c * t * energy * 2.0**exposure for c, t in zip(color, temperature_color)]


# scene/light.cpp: eval_fac of a distant light is 1 / (pi sin^2(angle / 2)) if normalised, else 1: its radiance. Before
# 4.0 the intensity is the strength, whatever the angle (kernel/light/light.h: the factor and the density of samples are
# the same number).
def cycles_sun(strength: Sequence[float], angle: float, normalize: bool = True, before_4: bool = False) -> dict:
    """A [[light]] of type "distant". `angle`: diameter of the disk."""
    half = 0.5 * angle
    if half <= 0:
        return {"type": "distant", **shining(strength, 1.0)}
    radiance = 1 / sun_on_card(half) if normalize else 1.0
    factor = 1.0 if before_4 else radiance * sun_solid_angle(half)
    return {"type": "distant", **shining(strength, factor), "angle": math.degrees(angle)}


# scene/light.cpp: 1 / (4 pi) for points without a size; radiance 1 / (4 pi^2 r^2) on a sphere, or 1 / pi if not
# normalised.
def cycles_point(
    strength: Sequence[float], radius: float, normalize: bool = True, as_point: bool = False
) -> dict:
    """A [[light]] of type "point", or a sphere of type "area". `as_point`: what the sphere sends from its middle."""
    if radius <= _LEAST or as_point:
        intensity = 1 / (4 * math.pi) if normalize or radius <= _LEAST else radius**2
        return {"type": "point", **shining(strength, intensity)}
    radiance = 1 / (4 * math.pi**2 * radius**2) if normalize else 1 / math.pi
    return {"type": "area", "shape": "sphere", **shining(strength, radiance), "radius": radius}


# util/ies.cpp: 4 pi / 177.83 watts a candela, at the luminous efficacy of D65.
CYCLES_WATTS_OF_CANDELA = 0.0706650768394


# kernel/light/spot.h: smoothstep of (cos - cos(size / 2)) / ((1 - cos(size / 2)) * blend). Scrim's fades by the same
# law, from the cone's border to the angle at which that is 1.
def cycles_spot(
    strength: Sequence[float], size: float, blend: float, radius: float = 0.0, normalize: bool = True
) -> dict:
    """A [[light]] of type "spot". `size`: the whole angle of the cone; `blend`: 0 to 1."""
    half = 0.5 * size
    outer = math.cos(half)
    inner = math.acos(min(1.0, outer + (1 - outer) * blend))
    intensity = 1 / (4 * math.pi)
    if radius > _LEAST and not normalize:
        intensity = radius**2  # radiance 1 / pi over a disk that faces what it lights
    return {
        "type": "spot",
        **shining(strength, intensity),
        "cone": math.degrees(size),
        "blend": min(max(1 - inner / half, 0.0), 1.0),
    }


# scene/light.cpp: radiance 1 / (pi area), or 1 / pi if not normalised; one-sided. Its spread, in radians, is Scrim's.
# Before 4.0: 1 / (4 area).
def cycles_area(
    strength: Sequence[float],
    width: float,
    height: float,
    ellipse: bool,
    normalize: bool = True,
    before_4: bool = False,
    spread: float = math.pi,
) -> dict:
    """A [[light]] of type "area": a rectangle, or a disk of the mean radius of an ellipse."""
    size = width * height * (0.25 * math.pi if ellipse else 1.0)
    radiance = 1 / ((4 if before_4 else math.pi) * size) if normalize else 1 / math.pi
    narrowed = {"spread": max(math.degrees(spread), 1.0)} if spread < 3.1415 else {}
    if ellipse:
        extent = {"shape": "disk", "radius": 0.25 * (width + height)}
    else:
        extent = {"shape": "rectangle", "width": width, "height": height}
    return {"type": "area", **shining(strength, radiance), **extent, **narrowed}


def usd_distant(intensity: float, angle_degrees: float, normalize: bool) -> tuple[float, float]:
    """(`intensity` of a distant light of a scene, irradiance on a card that faces it). `intensity`: with its exposure;
    `angle_degrees`: diameter of the disk. A sun without a size has the irradiance that its intensity says."""
    half = math.radians(0.5 * angle_degrees)
    if half <= 0:
        return intensity, intensity
    radiance = intensity / sun_on_card(half) if normalize else intensity
    return radiance * sun_solid_angle(half), radiance * sun_on_card(half)


def usd_point(intensity: float, radius: float, normalize: bool) -> float:
    """Radiant intensity of a sphere seen from afar: pi r^2 L, where `normalize` divides L by 4 pi r^2. `intensity`:
    with its exposure."""
    return 0.25 * intensity if normalize else math.pi * radius**2 * intensity
