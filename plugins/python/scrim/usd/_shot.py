# SPDX-License-Identifier: Apache-2.0
"""A stage as a shot: a scene for each frame. A frame shares the volumes that the frame before loaded."""

from __future__ import annotations

import logging
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from .. import _grids, _scrim, _toml, _viewing
from .._errors import UsageError
from .._volumes import Volumes
from . import _camera, _own, _reading
from ._scene import FrameScene, scene_at


class Shot:
    """A stage of OpenUSD, with all that its frames need: `scrim.usd.open`. Like a `scrim.Shot` it does one thing
    at a time."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        overrides: Mapping[str, object] | Sequence[str] | None,
        options: _reading.Options,
        ocio: str | os.PathLike[str],
        guarded: bool,
    ) -> None:
        self.path: str = os.fspath(path)
        self._options = options
        self._given: dict = {"ocio": ocio, "guarded": guarded}
        self._overrides = _toml.assignments(overrides)
        self._stage = _reading.opened_stage(self.path)
        self._sidecar = _own.Sidecar(options.sidecar)
        self._sidecar.check(self._stage)
        self._messages = _reading.Messages()
        self._said = 0
        self._folder = tempfile.TemporaryDirectory(prefix="scrim-usd-")
        self._shot: _scrim.Shot | None = None
        self._text = ""
        self._job: _scrim.Job | None = None
        self._read: tuple[int, FrameScene] | None = None
        self._grids: dict[str, list[_scrim.Field]] = {}

    @property
    def frames(self) -> list[int]:
        """The whole time codes of the stage's range; [1] where it has none."""
        return _reading.frames_of(self._stage)

    @property
    def warnings(self) -> list[str]:
        """What could not be mapped, in the frames that were read so far: "PRIM: what, and what is done instead"."""
        return list(self._messages.warnings)

    @property
    def notes(self) -> list[str]:
        """What may be checked, in the frames that were read so far: the irradiance of distant lights."""
        return list(self._messages.notes)

    @property
    def volumes(self) -> Volumes:
        """Names of the volumes of the first frame; see `scrim.Shot.volumes`."""
        return Volumes(self, [volume["name"] for volume in self.scene(self.frames[0])["volume"]])

    def set(self, overrides: Mapping[str, object] | Sequence[str]) -> None:
        """Overrides more values, in all frames from now on: see `scrim.Shot.set`."""
        more = _toml.assignments(overrides)
        self._now().set(more)
        self._overrides += more

    def _code(self, name: str) -> tuple[str, dict]:
        return self._now()._code(name)

    def _grids_of(self, name: str) -> dict[str, object]:
        return self._now()._grids_of(name)

    def _now(self) -> _scrim.Shot:
        """The shot of the frame that was read last, else of the first."""
        return self.opened(self.frames[0] if self._read is None else self._read[0])

    @property
    def folder(self) -> str:
        """The folder of the meshes that scenes name. It is removed with the shot."""
        return self._folder.name

    @property
    def cameras(self) -> list[str]:
        """Paths of the stage's cameras."""
        return _camera.paths_of(self._stage)

    def through(self, camera: str) -> Shot:
        """The stage through another of its cameras, by path or by a unique name: a shot of its own."""
        options = replace(self._options, camera=camera)
        other = Shot(self.path, self._overrides, options, self._given["ocio"], self._given["guarded"])
        other._grids = dict(self._grids)
        other.scene(self.frames[0])  # raises here if there is no such camera
        return other

    def _at(self, frame: int) -> FrameScene:
        if self._read is None or self._read[0] != frame:
            folder = self._folder.name
            made = scene_at(self._stage, frame, self._options, self._sidecar, self._messages, folder)
            self._read = (frame, made)
            log = logging.getLogger("scrim")
            for line in self._messages.warnings[self._said :]:
                log.warning("%s", line)
            self._said = len(self._messages.warnings)
        return self._read[1]

    def scene(self, frame: int = 1) -> dict[str, Any]:
        """The scene of a frame as a dict, without the overrides: for `scrim.loads`."""
        return self._at(frame).scene

    def crop(self, frame: int = 1) -> tuple[int, int, int, int] | None:
        """x0, y0, x1, y1: the pixels that UsdRender's dataWindowNDC asks for; None for all."""
        return self._at(frame).crop

    def opened(self, frame: int = 1) -> _scrim.Shot:
        """The `scrim.Shot` of a frame: that of the last frame if both frames have the same scene."""
        text = _toml.document(self._at(frame).scene)
        if self._job is not None and not self._job.done:
            raise UsageError(f"{self.path}: the shot is at work; wait for it, or open the stage once more")
        if self._shot is None or text != self._text:
            self._shot = _scrim.loads(
                text,
                self._overrides,
                folder=os.path.dirname(os.path.abspath(self.path)),
                name=self.path,
                checked_frame=frame,
                sharing=self._shot,
                **self._given,
            )
            self._text = text
            for name, grids in self._grids.items():
                if name in self._shot.volumes:
                    self._shot.set_volume(name, grids)
        return self._shot

    def _keywords(self, frame: int, keywords: dict) -> dict:
        crop = self.crop(frame)
        return {**({"crop": crop} if crop else {}), **keywords}

    def render(
        self, frame: int = 1, progress: Callable[[float], object] | None = None, **keywords: object
    ) -> _scrim.Frame | None:
        """Renders a frame: see `scrim.Shot.render`, whose keywords these are."""
        return self.opened(frame).render(frame, progress, **self._keywords(frame, keywords))

    def start(self, frame: int = 1, **keywords: object) -> _scrim.Job:
        """Starts to render a frame, and returns at once: see `scrim.Shot.start`."""
        self._job = self.opened(frame).start(frame, **self._keywords(frame, keywords))
        return self._job

    def plan(self, frame: int = 1, **keywords: object) -> _scrim.Plan:
        """What rendering the frame would do: see `scrim.Shot.plan`."""
        return self.opened(frame).plan(frame, **keywords)

    def set_volume(self, name: str, grids: object) -> None:
        """Gives a volume grids that were made in code, in all frames: see `scrim.Shot.set_volume`."""
        fields = _grids.fields_of(grids)
        self._now().set_volume(name, fields)
        self._grids[name] = fields

    def study(
        self,
        frame: int = 1,
        folder: str | os.PathLike[str] | None = None,
        *,
        budget: float = 0.0,
        threads: int = 0,
        progress: Callable[[float], object] | None = None,
    ) -> dict[str, Any]:
        """Accuracy against time at a frame: see `scrim.Shot.study`."""
        return self.opened(frame).study(frame, folder, budget=budget, threads=threads, progress=progress)

    def view(self, frame: int | None = None, *, height: int = 640) -> _viewing.View:
        """Shows a frame in a notebook: see `scrim.Shot.view`. The page lets the user choose among the stage's
        cameras."""
        number = self.frames[0] if frame is None else frame
        return _viewing.shown_stage(self, number, self._given["ocio"], self._grids, height)

    def resolved(self, frame: int = 1) -> dict[str, Any]:
        """The scene of a frame in plain numbers: see `scrim.Shot.resolved`."""
        return self.opened(frame).resolved(frame)

    def toml(self, frame: int = 1, overrides: Mapping[str, object] | Sequence[str] | None = None) -> str:
        """The scene of a frame as TOML, with the overrides of the shot and `overrides`."""
        return self.opened(frame).toml(overrides)

    def __repr__(self) -> str:
        return f"<scrim.usd.Shot '{self.path}'>"
