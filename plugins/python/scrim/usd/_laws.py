# SPDX-License-Identifier: Apache-2.0
"""What UsdLux's numbers are in Scrim's units: plain numbers in and out, each law once.

The text is UsdLux's of 25.05: intensity * 2^exposure * colour is a radiance L, and `normalize` divides it by a size.
"""

from __future__ import annotations

import math


def distant_size(angle: float) -> float:
    """Irradiance, on a card that faces it, of a sun of radiance 1 and this diameter (degrees); 1 for one without."""
    theta = math.radians(0.5 * angle)
    if theta <= 0:
        return 1.0
    sine = math.sin(theta) ** 2
    return math.pi * (sine if theta <= 0.5 * math.pi else 2 - sine)


def cap(angle: float) -> float:
    """The solid angle of a sun: 2 pi (1 - cos(angle / 2)), without the difference."""
    return 4 * math.pi * math.sin(0.25 * math.radians(angle)) ** 2


def distant(intensity: float, angle: float, normalize: bool) -> tuple[float, float]:
    """(intensity of a scene, irradiance on a card that faces it).

    A scene's intensity is what thin smoke gets from all of the sun: radiance times solid angle. A card gets less from
    the sun's rim.
    """
    if angle <= 0:
        return intensity, intensity
    radiance = intensity / distant_size(angle) if normalize else intensity
    return radiance * cap(angle), radiance * distant_size(angle)


def point(intensity: float, radius: float, normalize: bool) -> float:
    """Radiant intensity of a sphere seen from afar: pi r^2 L."""
    return 0.25 * intensity if normalize else math.pi * radius**2 * intensity


def exposure_of(scale: float) -> float:
    """Stops of a factor."""
    return math.log2(scale)


def film(aperture: tuple[float, float], aspect: float, policy: str) -> tuple[float, float, str]:
    """(width, height) of the film that the picture shows, and Scrim's word for UsdRender's policy. `aspect` is that of
    the picture as it is seen: width * pixel aspect / height."""
    width, height = aperture
    wide = aspect >= width / height
    if policy == "cropAperture":
        return (width, width / aspect, "fill") if wide else (height * aspect, height, "fill")
    if policy == "adjustApertureWidth":
        return height * aspect, height, "vertical"
    if policy == "adjustApertureHeight":
        return width, width / aspect, "horizontal"
    if policy == "adjustPixelAspectRatio":
        return width, height, "horizontal"
    return (height * aspect, height, "overscan") if wide else (width, width / aspect, "overscan")


def crop(window: tuple[float, float, float, float], width: int, height: int) -> tuple[int, int, int, int]:
    """UsdRender's dataWindowNDC, y up from the bottom, as pixels x0, y0, x1, y1 from the top: those that are wholly
    within."""
    least = 1e-4  # of a pixel, for fractions that floats cannot hold
    x0, y0, x1, y1 = window
    return (
        math.ceil(x0 * width - least),
        math.ceil((1 - y1) * height - least),
        math.floor(x1 * width + least),
        math.floor((1 - y0) * height + least),
    )
