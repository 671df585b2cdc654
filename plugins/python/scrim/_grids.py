# SPDX-License-Identifier: Apache-2.0
"""What may stand for the grids of a volume."""

from __future__ import annotations

import os
import sys
import tempfile

from . import _scrim
from ._errors import UsageError


def _of_openvdb(grid: object) -> list[_scrim.Field]:
    # OpenVDB's own module writes it, so that tree, transform and class stay what they are.
    module = sys.modules[type(grid).__module__]
    with tempfile.TemporaryDirectory(prefix="scrim-") as folder:
        path = os.path.join(folder, "grid.vdb")
        module.write(path, grids=[grid])
        return _scrim.read_vdb(path)


def fields_of(grids: object) -> list[_scrim.Field]:
    """A Field, an OpenVDB grid, the path of a .vdb file, or a list of them."""
    if isinstance(grids, _scrim.Field):
        return [grids]
    if isinstance(grids, (str, os.PathLike)):
        return _scrim.read_vdb(grids)
    module = type(grids).__module__.split(".")[0]
    if module in ("openvdb", "pyopenvdb") and hasattr(sys.modules[type(grids).__module__], "write"):
        return _of_openvdb(grids)
    if isinstance(grids, (list, tuple)):
        return [field for grid in grids for field in fields_of(grid)]
    raise UsageError(
        f"a volume's grid is of type {type(grids).__name__}; expected a scrim.Field, an OpenVDB grid, "
        "the path of a .vdb file, or a list of them"
    )
