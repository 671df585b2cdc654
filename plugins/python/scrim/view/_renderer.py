# SPDX-License-Identifier: Apache-2.0
"""Renders the scene in a thread of its own: coarse while things move, then better and better.

What is wanted may change at any time. After every render, and during each, the thread chooses the most useful render
(`next_task`). It cancels a render whose picture is not wanted any more.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from .. import _scrim
from .._errors import Cancelled
from ._pictures import LAYERS, Layer, Pictures, Shape, Strengths, Texture, own_layers, pictures_of, with_region

# Dials while things move: coarse, in time that depends little on the volume. They replace the search of the dials that
# keep a preset's promise, which takes longer than such a render.
_MOTION = {
    "render.quality": "draft",
    "render.tolerance": 0.0,
    "render.sheet_thickness": 4.0,
    "render.texel": 2.0,
    "render.lod": 4.0,
    "render.antialias": 1,
    "render.light_error": 0.05,
    "render.scatter_cell": 8.0,
    "render.scatter_error": 0.05,
    "render.shutter_samples": 1,
}
_DRAFT = {"render.quality": "draft", "render.tolerance": 0.0}
_DIVISORS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # of the resolution while things move
_FIRST_SIZE = 200  # pixels of the longer side of the first picture
_SLOW, _FAST = 0.06, 0.025  # a coarse render of more seconds makes the next one coarser, one of fewer makes it finer
_PATIENCE = 0.5  # seconds after which a coarse render whose picture is not wanted is cancelled, too
_TURNS = 1.5  # times as many seconds may pass while the view turns: the page then warps what it has
_REST = 0.7  # seconds without a change after which the picture of the scene's file is made
_VERIFIED = 400  # pixels that are compared with brute force on request
_VERIFY_SECONDS = 30.0  # after which the comparison ends with the pixels that were compared so far
_POLL = 0.005
_MATTERS = ("text", "view", "frame", "muted", "region", "verify", "plays")  # whether a render fails depends on these
_LONG = 6.0  # if the picture of the file takes more seconds, a draft is rendered before it
_SOON = 1.0  # seconds of rendering it after which its whole time is estimated


@dataclass(frozen=True)
class Wanted:
    """The picture that is wanted. `text`: the scene; `view`: overrides of the camera; `muted`: layers that do not
    shine; `moves`: the user holds something; `verify`: the picture is to be compared with brute force; `plays`: other
    frames follow, so that a draft is enough; `region`: only these pixels are refined; `serial`: number of the last
    event; `since`: when it came; `camera`: the view, as the page projects by it."""

    text: str
    shape: Shape
    strengths: Strengths
    view: Mapping[str, object]
    frame: int
    resolution: tuple[int, int]
    is_draft: bool  # the scene asks for no more
    muted: frozenset[str] = frozenset()
    moves: bool = False
    verify: bool = False
    plays: bool = False
    region: tuple[int, int, int, int] | None = None
    serial: int = 0
    since: float = 0.0
    camera: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """A render. `kind`: whole (the picture alone), layers (with all of them), region (a part alone), light (one light
    alone), exact (what the scene's file says, with its own layers), or verify: the same, and some pixels by brute
    force."""

    kind: str
    stage: str
    light: str = ""


def next_task(wanted: Wanted, pictures: Pictures | None, now: float, is_slow: bool = False) -> Task | None:
    """The most useful render; None where there is nothing to do. `is_slow`: the picture of the file takes so long
    that a draft is rendered before it.

    Whatever changes is seen coarsely first. At rest the picture of the file follows, and after it, while the user
    looks, the layers that changes of strengths will need."""
    if wanted.plays:
        is_there = pictures is not None and pictures.shape == wanted.shape and _alike(pictures, wanted)
        return None if is_there and pictures.stage != "motion" else Task("whole", "draft")
    if pictures is None or pictures.shape.common != wanted.shape.common:
        return Task("whole", "motion")
    if wanted.region is not None:
        if not _alike(pictures, wanted) or pictures.muted != wanted.muted:
            return Task("whole", "motion")
        is_there = pictures.region == wanted.region and pictures.shape == wanted.shape
        return None if wanted.moves or is_there else Task("region", "region")
    if pictures.layers is None:
        if not _alike(pictures, wanted) or pictures.muted != wanted.muted:
            return Task("whole", "motion")
    elif pictures.lacks(wanted.strengths):
        return Task("whole", "motion")
    elif stale := pictures.stale_lights(wanted.shape, wanted.strengths):
        return Task("light", "motion", stale[0])
    if wanted.moves:
        return None
    coarse = [name for name, layer in (pictures.layers or {}).items() if layer.stage != "final"]
    if coarse:
        return Task("light", "final", coarse[0].removeprefix("light."))
    if wanted.muted and pictures.layers is None:
        return Task("layers", "final")
    if not is_exact(wanted, pictures):
        if is_slow and pictures.stage == "motion" and not wanted.is_draft:
            return Task("whole", "draft")
        is_good = pictures.layers is not None and pictures.shape.render == wanted.shape.render
        return None if is_good and not wanted.verify and now - wanted.since < _REST else Task("exact", "final")
    if wanted.verify and pictures.frame.error is None:
        return Task("verify", "final")
    return Task("layers", "final") if pictures.layers is None else None


def is_exact(wanted: Wanted, pictures: Pictures | None) -> bool:
    """Whether the picture is the one that the scene's file makes, apart from muted layers."""
    if pictures is None or pictures.frame is None:
        return False
    return pictures.shape == wanted.shape and _alike(pictures, wanted)


def _alike(pictures: Pictures, wanted: Wanted) -> bool:
    """Whether the picture has the lights and strengths that are wanted."""
    now, then = wanted.strengths.of, pictures.strengths.of
    return pictures.shape.lights == wanted.shape.lights and all((now[n] == then[n]).all() for n in now if n in then)


class Renderer:
    """`shown(pictures, wanted, task)` and `failed(error, wanted)` are called in this object's thread, `shown` also
    for pictures of older events that are still useful. `folder`: paths of the scene are relative to it. `grids`: grids
    made in code, by names of volumes. `loaded`: a shot whose loaded volumes are shared; only this object uses it."""

    def __init__(
        self,
        folder: str,
        name: str,
        ocio: str,
        shown: Callable[[Pictures, Wanted, Task], object],
        failed: Callable[[Exception, Wanted], object],
        grids: Mapping[str, object] | None = None,
        loaded: _scrim.Shot | None = None,
    ) -> None:
        self._given = {"folder": folder, "name": name, "ocio": ocio}
        self._shown, self._failed, self._grids = shown, failed, grids or {}
        self._shot = loaded
        self._wanted: Wanted | None = None
        self._pictures: Pictures | None = None
        self._tried: Wanted | None = None  # the picture that the thread works for
        self._bad: Wanted | None = None  # the picture that could not be rendered last
        self._level: int | None = None
        self._is_slow = False
        self._stopped = False
        self._changed = threading.Condition()
        self._job: _scrim.Job | None = None
        self._thread = threading.Thread(target=self._run, name="scrim-view-renderer", daemon=True)
        self._thread.start()

    def want(self, wanted: Wanted) -> None:
        with self._changed:
            self._wanted = wanted
            self._changed.notify()

    def adopt(self, pictures: Pictures, wanted: Wanted) -> None:
        """Takes pictures that were rendered before as those of `wanted`."""
        with self._changed:
            self._pictures, self._wanted = pictures, wanted
            self._changed.notify()

    @property
    def progress(self) -> float | None:
        """The finished part of the present render; None where nothing is rendered."""
        job = self._job
        return job.progress if job is not None else None

    def stop(self) -> None:
        """Cancels the present render, and ends the thread."""
        with self._changed:
            self._stopped = True
            self._changed.notify()
        self._thread.join()

    def _next(self) -> Task | None:
        """The next task, for `_tried`; None once this object is stopped."""
        with self._changed:
            while not self._stopped:
                wanted = self._wanted
                if wanted is not None and not self._is_bad(wanted):
                    self._tried = wanted
                    task = next_task(wanted, self._pictures, time.monotonic(), self._is_slow)
                    if task is not None:
                        return task
                    if not is_exact(wanted, self._pictures):  # a render may become due by time alone
                        self._changed.wait(0.05)
                        continue
                self._changed.wait()
        return None

    def _is_bad(self, wanted: Wanted) -> bool:
        """Whether `wanted` would fail as `_bad` did."""
        bad = self._bad
        return bad is not None and all(getattr(bad, name) == getattr(wanted, name) for name in _MATTERS)

    def _run(self) -> None:
        while not self._stopped:
            try:
                if (task := self._next()) is not None:
                    self._render(self._tried, task)
            except Cancelled:
                pass
            except Exception as error:  # noqa: BLE001  whatever it is, users see it, and the next change is rendered
                self._bad = self._tried
                self._failed(error, self._tried)
            finally:
                self._job = None
        self._shot = self._pictures = None

    def _overrides(self, wanted: Wanted, task: Task) -> tuple[dict, tuple[int, int]]:
        over: dict[str, object] = dict(wanted.view)
        size = wanted.resolution
        if task.stage == "motion":
            over |= _MOTION
            divisor = _DIVISORS[self._level_of(size)]
            size = (max(1, round(size[0] / divisor)), max(1, round(size[1] / divisor)))
        elif task.stage == "draft":
            over |= _DRAFT
        if task.kind not in ("exact", "verify"):
            over["camera.overscan"] = 0
            over["output.layers"] = LAYERS if task.kind == "layers" else []
        # Paths name lights by their numbers: the name of a light may contain a dot.
        lights = list(enumerate(wanted.shape.lights))
        if task.kind in ("layers", "light"):
            over |= own_layers(wanted.shape.lights)
        if task.kind == "light":
            over["output.layers"] = ["light"]
            over["ambient.color"] = [0.0, 0.0, 0.0]
            over |= {f"light[{index}].intensity": 0.0 for index, name in lights if name != task.light}
        elif task.kind in ("whole", "region"):
            over |= {f"light[{index}].intensity": 0.0 for index, name in lights if f"light.{name}" in wanted.muted}
            over |= {"ambient.color": [0.0, 0.0, 0.0]} if "ambient" in wanted.muted else {}
        return over, size

    def _level_of(self, size: tuple[int, int]) -> int:
        if self._level is None:
            wanted = max(size) / _FIRST_SIZE
            self._level = next((i for i, d in enumerate(_DIVISORS) if d >= wanted), len(_DIVISORS) - 1)
        return self._level

    def _render(self, wanted: Wanted, task: Task) -> None:
        over, size = self._overrides(wanted, task)
        started = time.monotonic()
        shot = _scrim.loads(
            wanted.text, over, resolution=size, sharing=self._shot, checked_frame=wanted.frame, **self._given
        )
        for name, grids in self._grids.items():
            shot.set_volume(name, grids)
        self._shot = shot
        job = self._job = shot.start(wanted.frame, crop=wanted.region if task.kind == "region" else None,
                         verify=_VERIFIED if task.kind == "verify" else 0, verify_limit=_VERIFY_SECONDS)  # fmt: skip
        while not job.wait(_POLL):
            seconds = time.monotonic() - started
            with self._changed:
                if (
                    self._stopped
                    or not self._serves(task, wanted, seconds)
                    or self._is_long(task, seconds, job.progress)
                ):
                    job.cancel()
                    break
        frame = job.result()
        seconds = time.monotonic() - started
        if task.kind == "exact":
            self._is_slow = seconds > _LONG
        if task.stage == "motion":
            self._adapt(seconds / self._slowness(wanted))
        with self._changed:
            self._take(frame, wanted, task, seconds)
            pictures, newest = self._pictures, self._wanted
        self._shown(pictures, replace(newest, serial=wanted.serial), task)

    def _serves(self, task: Task, wanted: Wanted, seconds: float) -> bool:
        """Whether the picture of the present render is still wanted."""
        newest = self._wanted
        if newest is wanted:
            return True
        if task.stage == "motion":  # if each was cancelled, no picture would appear while the mouse moves
            return seconds < _PATIENCE * self._slowness(newest) or newest.shape == wanted.shape
        if newest.shape.common != wanted.shape.common or newest.shape.render != wanted.shape.render:
            return False
        if task.kind == "light":
            return newest.shape.lights == wanted.shape.lights
        if newest.shape != wanted.shape or newest.region != wanted.region or newest.muted != wanted.muted:
            return False
        same = all((newest.strengths.of[n] == rgb).all() for n, rgb in wanted.strengths.of.items())
        return same and (task.kind != "verify" or newest.verify)

    def _slowness(self, wanted: Wanted) -> float:
        """How many times as long a coarse render may take as one that answers each event."""
        return _TURNS if self._pictures and self._pictures.differs_by_view(wanted.shape) else 1.0

    def _is_long(self, task: Task, seconds: float, part: float) -> bool:
        """Whether the picture of the file will take so long that a draft is rendered before it."""
        if task.kind != "exact" or self._is_slow or seconds < _SOON or self._pictures.stage != "motion":
            return False
        self._is_slow = seconds > part * _LONG
        return self._is_slow

    def _adapt(self, seconds: float) -> None:
        if seconds > _SLOW:
            self._level = min(self._level + (2 if seconds > 2 * _SLOW else 1), len(_DIVISORS) - 1)
        elif seconds < _FAST:
            self._level = max(self._level - 1, 0)

    def _take(self, frame: object, wanted: Wanted, task: Task, seconds: float) -> None:
        pictures, has_layers = self._pictures, task.kind in ("layers", "light")
        made = pictures_of(frame, wanted.shape, wanted.strengths, task.stage, seconds, has_layers)
        made = replace(made, camera=wanted.camera, plate=self._plate(frame, wanted))
        if task.kind == "whole":
            self._pictures = replace(made, muted=wanted.muted)
        elif task.kind in ("exact", "verify"):
            # Layers that still fit stay; the sum without them is rounded otherwise.
            fits = pictures.shape == wanted.shape and pictures.layers is not None
            self._pictures = replace(made, frame=frame, layers=pictures.layers if fits else None,
                                     rest=pictures.rest if fits else None,
                                     depth=pictures.depth if fits else None)  # fmt: skip
        elif task.kind == "layers" and is_exact(wanted, pictures):
            self._pictures = replace(pictures, layers=made.layers, rest=made.rest, depth=made.depth)
        elif task.kind == "layers":
            self._pictures = made
        elif task.kind == "region":
            beauty = with_region(pictures, frame, wanted.region, wanted.resolution)
            self._pictures = replace(made, beauty=beauty, muted=wanted.muted, region=wanted.region)
        else:
            name = f"light.{task.light}"
            layers = dict(pictures.layers)
            layers[name] = replace(made.layers[name], strength=wanted.strengths.of[name])
            shape = replace(
                pictures.shape, lights={**pictures.shape.lights, task.light: wanted.shape.lights[task.light]}
            )
            self._pictures = replace(pictures, layers=layers, shape=shape, frame=None, is_whole=False, seconds=seconds)

    def _plate(self, frame: object, wanted: Wanted) -> Texture | None:
        """The preview's backplate; that of the pictures before, where it has no fewer pixels."""
        pixels, before = frame.backplate, self._pictures
        if pixels is None:
            return None
        kept = before.plate if before and before.shape.common["frame"] == wanted.frame else None
        return kept if kept and kept.pixels.size >= pixels.size else Texture.of(pixels)


__all__ = ["Layer", "Renderer", "Task", "Wanted", "is_exact", "next_task"]
