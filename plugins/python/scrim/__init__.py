# SPDX-License-Identifier: Apache-2.0
"""Scrim renders OpenVDB volumes with volumetric shadows.

    import scrim

    shot = scrim.open("shot.toml", {"camera.fov": 20})
    frame = shot.render(7, progress=print)
    frame["light.key"]                   # float32 (height, width, channels)
    frame.write("plume.####.exr")

Pictures are premultiplied and scene-linear, rows from top to bottom. Lengths are world units, angles degrees. Warnings
and notes go to `logging.getLogger("scrim")`.
"""

from ._errors import (
    AccuracyError,
    Cancelled,
    Error,
    InputError,
    OutOfMemoryError,
    OutputError,
    RenderError,
    UsageError,
)

try:
    from ._scrim import Field, Frame, Job, Plan, Shot, __version__, loads, open, read_vdb
except ModuleNotFoundError as error:
    if error.name != f"{__name__}._scrim":
        raise
    from ._other_python import advice

    raise ImportError(advice()) from None
from . import _viewing
from .view import shown as _shown
from .view import shown_stage as _shown_stage

# The viewer stands above the shots that it shows: neither the module in C++ nor `scrim.usd` can import it.
Shot.view = _shown
_viewing.shown_stage = _shown_stage

__all__ = [
    "AccuracyError",
    "Cancelled",
    "Error",
    "Field",
    "Frame",
    "InputError",
    "Job",
    "OutOfMemoryError",
    "OutputError",
    "Plan",
    "RenderError",
    "Shot",
    "UsageError",
    "__version__",
    "loads",
    "open",
    "read_vdb",
]
