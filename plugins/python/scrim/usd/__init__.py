# SPDX-License-Identifier: Apache-2.0
"""OpenUSD stages as scenes of Scrim, read by PyPI's usd-core.

    import scrim.usd

    shot = scrim.usd.open("shot.usda", camera="/cam")
    for frame in shot.frames:
        shot.render(frame).write("plume.####.exr")
    print(*shot.warnings, sep="\\n")     # what could not be mapped, prim by prim

Frames are the stage's time codes, and world units are its units. The scene of a frame is read from the stage at the
frame's time code.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from .._errors import UsageError

if TYPE_CHECKING:
    from ._shot import Shot

__all__ = ["Shot", "cameras", "open"]

_DISTANT = ("radiance", "irradiance")
_MESHES = ("holdout", "shadows", "none")
_PURPOSES = ("default", "render", "proxy", "guide")


def __getattr__(name: str) -> object:
    # A missing OpenUSD is an error when a stage is opened, not when this package is imported.
    if name == "Shot":
        from ._shot import Shot

        return Shot
    raise AttributeError(f"module 'scrim.usd' has no attribute '{name}'")


def _need_openusd() -> None:
    try:
        import pxr.Usd  # noqa: F401
    except ImportError as missing:
        raise UsageError(
            f"OpenUSD's Python package is missing ({missing}); install it beside Scrim: pip install usd-core"
        ) from missing


def _chosen(name: str, value: str, choices: Sequence[str]) -> str:
    if value not in choices:
        raise UsageError(f"{name}='{value}': expected {', '.join(choices[:-1])} or {choices[-1]}")
    return value


def cameras(path: str | os.PathLike[str]) -> list[str]:
    """Paths of the cameras of a stage, for `open(path, camera=...)`."""
    _need_openusd()
    from . import _camera, _reading

    return _camera.paths_of(_reading.opened_stage(path))


def open(
    path: str | os.PathLike[str],
    overrides: Mapping[str, object] | Sequence[str] | None = None,
    *,
    camera: str | None = None,
    settings: str | None = None,
    purpose: str | Sequence[str] | None = None,
    sidecar: str | os.PathLike[str] | None = None,
    distant: str = "radiance",
    meshes: str = "holdout",
    resolution: tuple[int, int] | None = None,
    ocio: str | os.PathLike[str] = "",
    guarded: bool = True,
) -> Shot:
    """Opens a stage: .usd, .usda, .usdc or .usdz.

    `overrides`: values of the scenes that the stage becomes, as for `scrim.open`.  `camera`: the path of a camera, or a
    name that only one camera has; None: the camera that the settings name, else the stage's only camera, else, in a
    stage without cameras, one that frames the volumes.
    `settings`: the path of a RenderSettings; None: the RenderSettings that the stage names, else its only one.
    `purpose`: the purposes of the prims that are read; None: the includedPurposes of the settings, else default and
    render.
    `sidecar`: a TOML file of tables keyed by prim paths, for media and all else that a stage cannot say.
    `distant`: 'radiance' reads a DistantLight as UsdLux 25.05 defines it; 'irradiance' takes its intensity as the
    irradiance of a surface that faces the light, whatever the light's angle, as many renderers did before.
    `meshes`: 'holdout': meshes hide volumes and cast shadows on them; 'shadows': they cast shadows only; 'none':
    neither. `resolution`: (width, height) in place of the settings' resolution.  `ocio`, `guarded`: as for
    `scrim.open`.
    """
    _need_openusd()
    from ._reading import Options
    from ._shot import Shot

    purposes = (purpose,) if isinstance(purpose, str) else tuple(purpose) if purpose is not None else None
    for one in purposes or ():
        _chosen("purpose", one, _PURPOSES)
    options = Options(
        camera,
        settings,
        purposes,
        sidecar,
        _chosen("distant", distant, _DISTANT),
        _chosen("meshes", meshes, _MESHES),
        resolution,
    )
    return Shot(path, overrides, options, ocio, guarded)
