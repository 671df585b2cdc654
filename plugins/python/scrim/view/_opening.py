# SPDX-License-Identifier: Apache-2.0
"""Opens what the viewer is given: a scene, an asset, a scan, a stage, or a folder of them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

from .. import _scrim, usd
from .._errors import Error, InputError, UsageError
from ._opened import Opened

_STAGES = (".usd", ".usda", ".usdc", ".usdz")
_ASSETS = (".vdb", ".nvdb", ".nrrd", ".nhdr", ".nii", ".gz", ".hdr", ".mha", ".mhd", ".npy", ".mrc")  # .nii.gz


def listed(folder: str) -> list[str]:
    """The names of scenes, stages, volumes and scans in a folder; scenes come first. Raises InputError."""
    try:
        names = sorted(entry.name for entry in os.scandir(folder) if entry.is_file())
    except OSError as error:
        raise InputError(f"{folder}: {error.strerror}") from error
    kinds = ((".toml",), _STAGES, _ASSETS)
    found = [name for kind in kinds for name in names if os.path.splitext(name)[1].lower() in kind]
    if not found:
        raise InputError(f"{folder}: there is nothing to show; expected .toml, .usd, .vdb, .nrrd or .nii")
    return found


def takes_long(path: str) -> bool:
    """Whether opening `path` takes long: an asset is read whole to be framed."""
    return os.path.isfile(path) and os.path.splitext(path)[1].lower() in _ASSETS


def may_load_usd(path: str) -> bool:
    """Whether `path` is a stage, or a folder, which may hold one."""
    return os.path.isdir(path) or os.path.splitext(path)[1].lower() in _STAGES


def opened(
    path: str,
    *,
    frame: int | None = None,
    ocio: str = "",
    up: tuple[float, float, float] | None = None,
    resolution: tuple[int, int] | None = None,
) -> Opened:
    """Opens a scene, an asset, a stage, or the first file of a folder that opens. An asset becomes the scene that
    `scrim render` makes of it; a stage becomes a scene for each frame; neither has a file until it is saved. `up` and
    `resolution` are for assets. Raises scrim.Error where `path` cannot be opened."""
    if os.path.isdir(path):
        return _first_of(path, listed(path), frame, ocio)
    folder = os.path.dirname(os.path.abspath(path))
    options = ["--ocio", ocio] if ocio else []
    if os.path.splitext(path)[1].lower() in _STAGES:
        return _stage(path, frame, ocio)
    shot = _scrim.open(path, ocio=ocio, up=up, resolution=resolution, checked_frame=frame or 1)
    frames = shot.frames
    number = frame if frame is not None else frames[0]
    if shot.is_asset:
        return Opened(shot.toml(), "", folder, path, frames, number, ocio, options, loaded=shot)
    if up or resolution:
        raise UsageError(f"{path}: --up and --res are for assets; this scene says both itself")
    with open(path, encoding="utf-8", newline="") as file:
        text = file.read()
    return Opened(text, path, folder, path, frames, number, ocio, options)


def _first_of(folder: str, names: list[str], frame: int | None, ocio: str) -> Opened:
    """The first file that opens, since one bad file shall not hide the others."""
    problem: Error | None = None
    for name in names:
        try:
            return replace(opened(os.path.join(folder, name), frame=frame, ocio=ocio), others=names)
        except Error as error:
            problem = problem or error
    raise problem


def of_stage(shot: usd.Shot, frame: int, ocio: str = "", grids: Mapping[str, object] | None = None) -> Opened:
    """The `Opened` of a stage, which begins with `frame`, with the overrides of the shot."""
    text, frames = shot.toml(frame), sorted({*shot.frames, frame})
    # Files that the scene names are in the shot's temporary folder, which is removed with the shot.
    return Opened(
        text, "", os.path.dirname(os.path.abspath(shot.path)), shot.path, frames, frame, os.fspath(ocio),
        ["--ocio", os.fspath(ocio)] if ocio else [], text_at=shot.toml, keeps=shot, temporary=shot.folder,
        cameras=shot.cameras, grids=grids or {},
    )  # fmt: skip


def _stage(path: str, frame: int | None, ocio: str) -> Opened:
    shot = usd.open(path, ocio=ocio)
    return of_stage(shot, shot.frames[0] if frame is None else frame, ocio)
