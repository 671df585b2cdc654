# SPDX-License-Identifier: Apache-2.0
"""The numbers of UsdRender as those of Scrim: plain numbers in and out. The laws of light are in the kit."""

from __future__ import annotations

import math


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
    """UsdRender's dataWindowNDC, whose y goes up from the bottom, as pixels x0, y0, x1, y1 from the top: the pixels
    that lie wholly within the window."""
    least = 1e-4  # of a pixel, for fractions that floats cannot hold
    x0, y0, x1, y1 = window
    return (
        math.ceil(x0 * width - least),
        math.ceil((1 - y1) * height - least),
        math.floor(x1 * width + least),
        math.floor((1 - y0) * height + least),
    )
