# SPDX-License-Identifier: Apache-2.0
"""The viewer as `scrim.usd` sees it. The viewer opens stages, so `scrim.view` imports `scrim.usd` and not the other way
round; `scrim/__init__.py`, which imports both, sets `shown_stage`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class View(Protocol):
    """A viewer in a notebook: `scrim.view._notebook.View`."""

    @property
    def url(self) -> str: ...

    @property
    def toml(self) -> str: ...

    def close(self) -> None: ...


shown_stage: Callable[..., View]  # scrim.view.shown_stage
