# SPDX-License-Identifier: Apache-2.0
"""Work that takes long and shares something that does one thing at a time: a stage. It is done beside the event loop,
one piece after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ._aside import aside


@dataclass(frozen=True)
class Turn:
    """A piece of work. `kind`: a turn that waits is dropped for a later one of its kind. `begin()`: gives the work as a
    function without arguments, which is called in a thread. `then(made)`: takes what the work gave. `serial`: number of
    the event that asks for it; None: it was no event. `begin` and `then` are called in the loop's thread."""

    kind: str
    begin: Callable[[], Callable[[], object]]
    then: Callable[[object], object]
    serial: int | None = None


class Turns:
    """Calls `failed(problem)` where a turn raises, in the loop's thread; the next turn follows. `later`: that of a
    session. All methods but `close` are for the loop's thread."""

    def __init__(
        self, later: Callable[[float, Callable[[], object]], object], failed: Callable[[BaseException], object]
    ) -> None:
        self._later, self._failed = later, failed
        self._now: Turn | None = None
        self._waiting: list[Turn] = []

    @property
    def is_busy(self) -> bool:
        return self._now is not None

    @property
    def first_serial(self) -> int | None:
        """Number of the first event whose turn is not over; None where all are."""
        turns = [*([self._now] if self._now else []), *self._waiting]
        return min((turn.serial for turn in turns if turn.serial is not None), default=None)

    def ask(self, turn: Turn) -> None:
        dropped = [other for other in self._waiting if other.kind == turn.kind]
        # The events of dropped turns are answered by this one.
        serials = [other.serial for other in (*dropped, turn) if other.serial is not None]
        self._waiting = [other for other in self._waiting if other not in dropped]
        self._waiting.append(replace(turn, serial=min(serials, default=None)))
        self._go_on()

    def close(self) -> None:
        """Drops all turns. The work that is being done ends without effect."""
        self._waiting, self._now = [], None

    def _go_on(self) -> None:
        if self._now is None and self._waiting:
            turn = self._now = self._waiting.pop(0)
            work = turn.begin()
            aside(work, self._later, lambda made: self._over(turn, made), lambda problem: self._lost(turn, problem))

    def _over(self, turn: Turn, made: object) -> None:
        if self._now is turn:
            self._now = None
            try:
                turn.then(made)
            except Exception as problem:  # noqa: BLE001
                self._failed(problem)
            self._go_on()

    def _lost(self, turn: Turn, problem: BaseException) -> None:
        if self._now is turn:
            self._now = None
            self._failed(problem)
            self._go_on()
