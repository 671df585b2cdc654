# SPDX-License-Identifier: Apache-2.0
"""The viewer, `scrim view`: a page in the browser that shows a scene, and changes it by looking.

A `Session` holds the scene and renders it in a thread of its own; a `Server` shows it to browsers. Both keep to what
`scrim.Shot` can do: they contain no law of light and no colour transform.
"""

from __future__ import annotations

import importlib.util

from .._errors import UsageError

__all__ = ["needs"]

_KITS = ("tornado", "tomlkit")


def needs() -> None:
    """Raises UsageError where a package is missing that the viewer uses."""
    for name in _KITS:
        if importlib.util.find_spec(name) is None:  # without loading it
            raise UsageError(
                f"the viewer needs {' and '.join(_KITS)} (No module named '{name}'); install them beside Scrim: "
                f"pip install {' '.join(_KITS)}"
            )
