# SPDX-License-Identifier: Apache-2.0
"""The viewer, `scrim view`: a page in the browser that shows a scene, and changes it by looking.

A `Session` holds the scene and renders it in a thread of its own; a `Server` shows it to browsers. Both keep to what
`scrim.Shot` can do: they contain no law of light and no colour transform.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

from .._errors import UsageError

if TYPE_CHECKING:
    from .. import usd
    from .._scrim import Shot
    from ._notebook import View

__all__ = ["needs", "shown", "shown_stage"]

_KITS = ("tornado", "tomlkit")


def needs() -> None:
    """Raises UsageError where a package is missing that the viewer uses."""
    for name in _KITS:
        if importlib.util.find_spec(name) is None:  # finds a package without loading it
            raise UsageError(
                f"the viewer needs {' and '.join(_KITS)} (No module named '{name}'); install them beside Scrim: "
                f"pip install {' '.join(_KITS)}"
            )


def shown(
    shot: Shot,
    frame: int | None = None,
    *,
    height: int = 640,
    folder: str | os.PathLike[str] | None = None,
    volumes: Mapping[str, object] | None = None,
) -> View:
    """Shows the shot in a notebook, as `scrim view` does in a browser: the returned viewer is what the cell displays.

    `frame`: the first frame that is shown; None: the first of the shot.  `height`: of the page in the cell, in pixels.
    `folder`: paths of a scene in memory are relative to it, and the scene may be saved there; None: the folder of the
    shot's path.  `volumes`: grids made in code, by names of volumes, as `set_volume` takes them.
    The browser must reach 127.0.0.1 of the kernel's machine."""
    needs()
    from ._notebook import View, opened_of

    return View(opened_of(shot, frame, folder, volumes), height)


def shown_stage(shot: usd.Shot, frame: int, ocio: str, grids: Mapping[str, object], height: int) -> View:
    """Shows a stage in a notebook, from this frame on: `scrim.usd.Shot.view`."""
    needs()
    from ._notebook import View
    from ._opening import of_stage

    return View(of_stage(shot, frame, ocio, grids), height)
