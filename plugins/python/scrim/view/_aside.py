# SPDX-License-Identifier: Apache-2.0
"""Work that takes long, in a thread beside the event loop, which goes on to answer browsers."""

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
    """Calls `work` in a daemon thread, then in the loop's thread `then` with the result of `work`, or `failed` with its
    exception. `later(seconds, call)`: calls in the loop's thread."""

    def do() -> None:
        try:
            call = functools.partial(then, work())
        except BaseException as problem:  # noqa: BLE001
            call = functools.partial(failed, problem)
        later(0.0, call)

    threading.Thread(target=do, name="scrim-view-aside", daemon=True).start()
