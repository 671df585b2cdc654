# SPDX-License-Identifier: Apache-2.0
"""Work that takes long, beside the event loop: what browsers ask for meanwhile is answered."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import TypeVar

Made = TypeVar("Made")


def aside(
    work: Callable[[], Made],
    later: Callable[[float, Callable[[], object]], object],
    then: Callable[[Made], object],
    failed: Callable[[BaseException], object],
) -> None:
    """Does `work` in a thread that keeps nobody from ending, and calls `then` with what it gave, or `failed` with what
    it raised, in the loop's thread. `later`: that of a session."""

    def do() -> None:
        try:
            call = functools.partial(then, work())
        except BaseException as problem:  # noqa: BLE001
            call = functools.partial(failed, problem)
        later(0.0, call)

    threading.Thread(target=do, name="scrim-view-aside", daemon=True).start()
