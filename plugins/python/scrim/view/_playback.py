# SPDX-License-Identifier: Apache-2.0
"""Frames of a sequence, played one after the other from the pictures that are kept of them."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import replace

from ._pictures import Pictures

LIMIT = 512 << 20  # bytes


class FrameCache:
    """The last pictures that were shown of each frame, up to `limit` bytes; those that were asked for longest ago go
    first. They are kept without their layers."""

    def __init__(self, limit: int = LIMIT) -> None:
        self._limit, self._size = limit, 0
        self._kept: OrderedDict[tuple[Hashable, int], Pictures] = OrderedDict()

    def keep(self, look: Hashable, frame: int, pictures: Pictures) -> None:
        """`look`: everything that a picture depends on, except for its frame."""
        self._drop((look, frame))
        self._kept[look, frame] = pictures
        self._size += _bytes_of(pictures)
        while self._size > self._limit and self._kept:
            self._drop(next(iter(self._kept)))

    def find(self, look: Hashable, frame: int) -> Pictures | None:
        found = self._kept.get((look, frame))
        if found is not None:
            self._kept.move_to_end((look, frame))
        return found

    def frames(self, look: Hashable) -> list[int]:
        return sorted(frame for other, frame in self._kept if other == look)

    @property
    def size(self) -> int:
        """Bytes."""
        return self._size

    def _drop(self, key: tuple[Hashable, int]) -> None:
        pictures = self._kept.pop(key, None)
        if pictures is not None:
            self._size -= _bytes_of(pictures)


def _bytes_of(pictures: Pictures) -> int:
    return pictures.beauty.pixels.nbytes + (pictures.plate.pixels.nbytes if pictures.plate else 0)


class Player:
    """Plays the frames of a session, each as soon as its picture is there and not before its time. `session` shows a
    frame (`show_frame`), and says which there are (`frames`), and how many a second (`fps`). The session
    calls `go_on` if the picture of the frame is kept; otherwise it calls `wait`, and `took` once the picture is there.
    `tell` and `later` are those of the session."""

    def __init__(self, session: object, tell: Callable, later: Callable) -> None:
        self._session, self._tell, self._later = session, tell, later
        self._cache = FrameCache()
        self._since = 0.0  # when the frame was gone to
        self._waits = False  # for its picture
        self._run = 0  # number of the last run: what an earlier run began has no effect
        self.is_playing = False

    def play(self, on: bool) -> None:
        begins = on and not self.is_playing and len(self._session.frames) > 1
        self.is_playing = on and len(self._session.frames) > 1
        if begins:
            self._run += 1
            self._advance(self._run)

    def stop(self) -> None:
        self.is_playing = False

    def find(self, look: Hashable, frame: int) -> Pictures | None:
        return self._cache.find(look, frame)

    def took(self, look: Hashable, frame: int, pictures: Pictures) -> None:
        """Keeps a rendered picture of a frame, and goes on if it was waited for."""
        if pictures.stage not in ("draft", "final"):
            return
        self._cache.keep(look, frame, replace(pictures, frame=None, layers=None, rest=None, depth=None))
        if self.is_playing and self._waits:
            self.go_on()

    def _plays(self, run: int) -> bool:
        return self.is_playing and run == self._run

    def _advance(self, run: int) -> None:
        if not self._plays(run):
            return
        frame = next((f for f in self._session.frames if f > self._session.frame), self._session.frames[0])
        self._since, self._waits = time.monotonic(), False
        try:
            self._session.show_frame(frame, lambda: self._plays(run))
        except Exception:
            self.stop()
            raise  # `later` tells it

    def wait(self) -> None:
        """The frame was gone to, and its picture is being rendered."""
        self._waits = True

    def go_on(self) -> None:
        """The picture of the frame that was gone to is there: the next one follows in time."""
        self._waits = False
        self._tell({"type": "frame", "number": self._session.frame})
        seconds, run = max(1 / self._session.fps - (time.monotonic() - self._since), 0.001), self._run
        self._later(seconds, lambda: self._advance(run))
