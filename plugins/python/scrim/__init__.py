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
from .view import shown as _shown

Shot.view = _shown  # of the package in Python, which the module in C++ does not know

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
