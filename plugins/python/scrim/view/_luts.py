# SPDX-License-Identifier: Apache-2.0
"""A view of a display as a table that the browser's graphics unit looks up.

The table has N^3 entries over the cube of encoded colours: s = log2(1 + K x) / log2(1 + K M) for x from 0 to M in each
channel. So steps are even in stops where it is bright, even in x where it is dark, and 0 is exactly 0. The table is off
by less than a step of 8 bits; at colours of which a channel just leaves what the display can show, by up to 12, since
it rounds that corner off.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .. import _scrim

SIZE = 97
_FINE_SECONDS = 0.5  # until the fine table is made, so that the first picture has the processor
FIRST_SIZE = 33  # of the table that is shown until the fine one is there, which takes a second
KNEE = 64.0  # K
MOST = 64.0  # M: what is brighter is shown like this


@functools.lru_cache(maxsize=2)
def _nodes(size: int) -> np.ndarray:
    """Colours at the entries, red fastest, as a picture (size * size, size, 4)."""
    line = (np.exp2(np.linspace(0.0, 1.0, size) * np.log2(1 + KNEE * MOST)) - 1) / KNEE
    blue, green, red = np.meshgrid(line, line, line, indexing="ij")
    colours = np.stack([red, green, blue, np.ones_like(red)], axis=-1)
    return np.ascontiguousarray(colours.reshape(size * size, size, 4), dtype=np.float32)


def table(shot: _scrim.Shot, display: str, view: str, size: int = SIZE) -> bytes:
    """The display's values from 0 to 1: size^3 words of 32 bits, red fastest. A word holds ten bits of red from the
    lowest bit up, then green, then blue, which is a quarter of a step of 8 bits."""
    shown = shot.displayed(_nodes(size), display, view)[..., :3]
    parts = np.rint(np.clip(np.nan_to_num(shown), 0.0, 1.0) * 1023).astype(np.uint32)
    return (parts[..., 0] | parts[..., 1] << 10 | parts[..., 2] << 20).tobytes()


@dataclass(frozen=True)
class Lut:
    """A table of size^3 entries, as `table` makes them."""

    size: int
    data: bytes


class Tables:
    """The tables of views that were asked for: first a coarse one, and `show()` is called when the fine one is there.
    `later(seconds, call)` is that of the session."""

    def __init__(self, show: Callable[[], object], later: Callable[[float, Callable[[], object]], object]) -> None:
        self._show, self._later = show, later
        self._made: dict[tuple[str, str], Lut] = {}
        self._threads: list[threading.Thread] = []

    def close(self) -> None:
        """Waits until no table is being made."""
        for thread in self._threads:
            if thread.is_alive():
                thread.join()

    def of(self, shot: _scrim.Shot, display: str, view: str) -> Lut:
        def refine() -> None:
            self._made[display, view] = Lut(SIZE, table(shot, display, view))
            self._later(0.0, self._show)

        if (display, view) not in self._made:
            self._made[display, view] = Lut(FIRST_SIZE, table(shot, display, view, FIRST_SIZE))
            thread = threading.Thread(target=refine, name="scrim-view-table", daemon=True)
            self._threads.append(thread)
            self._later(_FINE_SECONDS, thread.start)
        return self._made[display, view]
