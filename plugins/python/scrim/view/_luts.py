# SPDX-License-Identifier: Apache-2.0
"""A view of a display as a table that the browser's graphics unit looks up.

The table has N^3 entries over the cube of encoded colours: s = log2(1 + K x) / log2(1 + K M) for x from 0 to M in each
channel. So steps are even in stops where it is bright, even in x where it is dark, and 0 is exactly 0. The table is off
by less than a step of 8 bits; at colours of which a channel just leaves what the display can show, by up to 12, since
it rounds that corner off.
"""

from __future__ import annotations

import functools

import numpy as np

import scrim

SIZE = 97
KNEE = 64.0  # K
MOST = 64.0  # M: what is brighter is shown like this


@functools.lru_cache(maxsize=1)
def _nodes() -> np.ndarray:
    """Colours at the entries, red fastest, as a picture (SIZE * SIZE, SIZE, 4)."""
    line = (np.exp2(np.linspace(0.0, 1.0, SIZE) * np.log2(1 + KNEE * MOST)) - 1) / KNEE
    blue, green, red = np.meshgrid(line, line, line, indexing="ij")
    colours = np.stack([red, green, blue, np.ones_like(red)], axis=-1)
    return np.ascontiguousarray(colours.reshape(SIZE * SIZE, SIZE, 4), dtype=np.float32)


def table(shot: scrim.Shot, display: str, view: str) -> bytes:
    """The display's values from 0 to 1 as float16: SIZE^3 entries of R, G, B, red fastest."""
    shown = shot.displayed(_nodes(), display, view)[..., :3]
    return np.clip(np.nan_to_num(shown), 0.0, 1.0).astype(np.float16).tobytes()
