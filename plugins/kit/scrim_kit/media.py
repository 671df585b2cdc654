# SPDX-License-Identifier: Apache-2.0
"""What the front ends make of other renderers' media: plain numbers in, keys of a scene out."""

from __future__ import annotations

from collections.abc import Sequence

# Of the largest channel. In dense smoke of albedo 0.5, the default of Arnold and of Cycles, single scattering shows
# 0.74 of the light, and 0.67 at 0.6: half a stop is 0.71.
FULL_FROM = 0.6


def scattering_of(albedo: Sequence[float]) -> str:
    """`scattering` of a medium: "full" where single scattering would leave dense smoke more than half a stop too dark,
    as it does from an albedo of 0.6 on; otherwise "single"."""
    return "full" if max(albedo) >= FULL_FROM else "single"
