# SPDX-License-Identifier: Apache-2.0
"""What all browsers of a viewer see and change together: the scene, the camera, and the newest pictures.

Everything here runs in the thread of the server's event loop, except for what `_renderer` does in its own.
"""

from __future__ import annotations

import os
import shlex
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scrim_kit import toml_text

import scrim

from .. import _bounds
from . import _luts, _messages
from ._camera import Lens, Pose, world_up
from ._controls import Control, groups_of
from ._document import Document
from ._opened import Opened
from ._pictures import Pictures, Strengths, shape_of, strengths_of
from ._renderer import Renderer, Task, Wanted, is_exact

_STILL = 0.25  # seconds without an event after which a held mouse counts as resting
_TABLE_SECONDS = 0.5  # until the fine table of a view is made, so that the first picture has the processor


@dataclass(frozen=True)
class Lut:
    """A view's table of size^3 entries: see `_luts`."""

    size: int
    data: bytes


class Session:
    """`tell(message)`: sends a dict to all browsers. `show()`: sends them the newest pictures. `later(seconds, call)`:
    calls in the event loop's thread, and may be called from any thread.
    `serial`: number of the last event. Raises scrim.Error where the scene is bad."""

    def __init__(
        self,
        opened: Opened,
        tell: Callable[[dict], object],
        show: Callable[[], object],
        later: Callable[[float, Callable[[], object]], object],
        serial: int = 0,
    ) -> None:
        self.opened = opened
        self._tell, self._show, self._later = tell, show, later
        self.document = Document(opened.text, opened.file)
        self._reader: scrim.Shot | None = None
        self.frame = opened.frame
        self._pose: Pose | None = None  # of the free view; None: the scene's camera
        self._muted: frozenset[str] = frozenset()
        self._serial = serial
        self._moved = 0.0  # when something was last held and moved
        self._message, self._verify = "", False
        self._luts: dict[tuple[str, str], Lut] = {}
        self.pictures: Pictures | None = None
        self.serial_shown = 0
        self._read(opened.text)
        self.displays: dict[str, list[str]] = self._reader.displays
        self.display = next(iter(self.displays))
        self.view = self.displays[self.display][0]
        self._wanted = self._now(moves=False)
        self._renderer = Renderer(opened.folder, os.path.basename(opened.input), opened.ocio, self._took, self._lost)
        self._renderer.want(self._wanted)

    def close(self) -> None:
        """Ends it: browsers hear nothing more of it."""
        self._tell = self._show = lambda *_: None
        self._renderer.stop()

    # ---- what browsers ask for

    def handle(self, message: Mapping) -> None:
        """Does what a browser asks for. Raises scrim.Error where that is impossible; nothing has changed then."""
        kind = message.get("type")
        do = getattr(self, f"_on_{kind}", None) if isinstance(kind, str) and kind.isidentifier() else None
        if do is None:
            raise scrim.UsageError(f"the page asks for '{kind}', which this viewer does not know")
        self._serial = max(self._serial, _messages.whole(message.get("serial", 0)))
        self._message, self._verify = "", kind == "verify"
        do(message)

    def _on_navigate(self, message: Mapping) -> None:
        dx, dy = _messages.number(message.get("dx")), _messages.number(message.get("dy"))
        pose, mode = self._pose or self._scene_pose(), message.get("mode")
        if mode == "orbit":
            pose = pose.orbited(self._up, dx, dy)
        elif mode == "pan":
            pose = pose.panned(dx, dy)
        elif mode == "dolly":
            pose = pose.dollied(dy)
        else:
            raise scrim.UsageError(f"the page asks for the movement '{mode}'; expected orbit, pan or dolly")
        is_new = self._pose is None
        self._pose = pose
        self._update(moves=True)
        if is_new:
            self.send_state()

    def _on_rest(self, message: Mapping) -> None:
        self._moved = 0.0
        self._update(moves=False)

    def _on_view(self, message: Mapping) -> None:
        to = message.get("to")
        if to == "scene":
            self._pose = None
        elif to == "frame":
            self._frame_all()
        elif to == "keep":
            self._keep_view()
        else:
            raise scrim.UsageError(f"the page asks for the view '{to}'; expected scene, frame or keep")
        self._update(moves=False)

    def _on_set(self, message: Mapping) -> None:
        control = self._control(message.get("id"))
        value = message.get("value")
        if not control.accepts(value):
            raise scrim.UsageError(f"{control.id}: the page gives {value!r}; expected a {control.kind}")
        text = self.document.changed(control.changes(value))
        self._read(text)  # raises where the scene is bad then
        self.document.take(text, message.get("step"))
        self._update(moves=not message.get("done", True))

    def _on_muted(self, message: Mapping) -> None:
        names = message.get("names")
        known = {f"light.{name}" for name in self._wanted.shape.lights} | {"ambient", "emission"}
        if not isinstance(names, list) or not set(names) <= known:
            raise scrim.UsageError(f"the page mutes {names!r}; expected some of {', '.join(sorted(known))}")
        self._muted = frozenset(names)
        self._update(moves=False)

    def _on_frame(self, message: Mapping) -> None:
        number = _messages.whole(message.get("number"))
        before, self.frame = self.frame, number
        try:
            self._read(self.document.text)
        except scrim.Error:
            self.frame = before
            raise
        self._update(moves=not message.get("done", True))

    def _on_verify(self, message: Mapping) -> None:
        self._message = "comparing pixels with brute force"
        self._update(moves=False)

    def _on_undo(self, message: Mapping) -> None:
        self._move_in_history(self.document.undo, "there is nothing to undo")

    def _on_redo(self, message: Mapping) -> None:
        self._move_in_history(self.document.redo, "there is nothing to redo")

    def _move_in_history(self, move: Callable[[], bool], otherwise: str) -> None:
        if not move():
            self._message = otherwise
        self._read(self.document.text)
        self._update(moves=False)

    def _on_save(self, message: Mapping) -> None:
        name = _messages.file_name(message.get("name"))
        if not name and not self.document.file:
            raise scrim.UsageError("the scene has no file yet: save it under a name")
        file = os.path.join(self.opened.folder, name) if name else ""
        self.document.save(file)
        self._message = f"saved {self.document.file}"
        self._update(moves=False)

    def _on_display(self, message: Mapping) -> None:
        display, view = message.get("display"), message.get("view")
        if view not in self.displays.get(display, ()):
            raise scrim.UsageError(f"there is no view {view!r} of a display {display!r}")
        self.display, self.view = display, view
        self._show()
        self._update(moves=False)

    # ---- the state

    def _read(self, text: str) -> None:
        """Reads a scene with the engine, which says what is wrong with it."""
        reader = scrim.loads(
            text, folder=self.opened.folder, name=os.path.basename(self.opened.input), ocio=self.opened.ocio,
            sharing=self._reader, checked_frame=self.frame,
        )  # fmt: skip
        self._resolved = reader.resolved(self.frame)
        self._reader = reader

    def _control(self, name: object) -> Control:
        for group in groups_of(self.document.data, self._up):
            for control in group.controls:
                if control.id == name:
                    return control
        raise scrim.UsageError(f"the scene has no control {name!r}")

    @property
    def _up(self) -> np.ndarray:
        camera = self.document.data.get("camera", {})
        stated = camera.get("up") if isinstance(camera.get("up"), list) else None
        return world_up(np.array(self._resolved["camera"]["matrix"]), stated)

    def _lens(self) -> Lens:
        camera = self._resolved["camera"]
        width, height = camera["resolution"]
        aspect = camera["pixel_aspect"] * width / height
        is_flat = camera["type"] == "orthographic"
        return Lens(np.radians(camera["fov"]), camera["height"] if is_flat else None, aspect)

    def _scene_pose(self) -> Pose:
        matrix = np.array(self._resolved["camera"]["matrix"])
        eye, ahead = matrix[:3, 3], -matrix[:3, 2]
        target = self.document.data.get("camera", {}).get("target")
        if isinstance(target, list):
            distance = float((np.array(target, float) - eye) @ ahead)
        elif box := _bounds.of(self._resolved["volumes"]):
            distance = float((0.5 * (box[0] + box[1]) - eye) @ ahead)
        else:
            distance = float(np.linalg.norm(eye))
        return Pose(matrix, max(distance, 1e-3), self._lens())

    def _frame_all(self) -> None:
        box = _bounds.of(self._resolved["volumes"])
        if box is None:
            raise scrim.UsageError(
                "the volumes of this scene are not files, so their size is not known before a render"
            )
        self._pose = (self._pose or self._scene_pose()).framed(*box)

    def _view_overrides(self) -> dict:
        """The free view as overrides of the scene's camera."""
        if self._pose is None:
            return {}
        camera, over = self._resolved["camera"], {"camera.matrix": self._pose.matrix.tolist()}
        if self._pose.lens.height is not None:
            over["camera.height"] = self._pose.lens.height
        if "exr" in self.document.data.get("camera", {}):  # the lens came from there, too
            over |= {f"camera.{key}": camera[key] for key in ("fov", "shift", "pixel_aspect")}
        return over

    def _keep_view(self) -> None:
        """Writes the free view into the scene's camera."""
        if self._pose is None:
            raise scrim.UsageError("the view is that of the scene's camera")
        if any(isinstance(value, dict) and "keys" in str(value) for value in self.document.data["camera"].values()):
            raise scrim.UsageError("the scene's camera has keys, which a still view would replace: edit the file")
        pose, camera = self._pose, ("camera",)
        changes = [((*camera, key), None) for key in ("matrix", "orbit", "exr", "ndc")]
        places = {"position": pose.eye, "target": pose.pivot, "up": self._up}
        changes += [((*camera, key), [float(v) for v in value]) for key, value in places.items()]
        over = self._view_overrides()
        changes += [((*camera, key[7:]), value) for key, value in over.items() if key != "camera.matrix"]
        text = self.document.changed(changes)
        before, self._pose = self._pose, None
        try:
            self._read(text)
        except scrim.Error:
            self._pose = before
            raise
        self.document.take(text)

    def _now(self, moves: bool) -> Wanted:
        data = self.document.data
        view = self._view_overrides()
        return Wanted(
            self.document.text,
            shape_of(data, view, self.frame),
            strengths_of(data, self._resolved),
            view,
            self.frame,
            tuple(self._resolved["camera"]["resolution"]),
            data.get("render", {}).get("quality") == "draft",
            self._muted,
            moves,
            self._verify,
            self._serial,
            time.monotonic(),
        )

    def _update(self, moves: bool) -> None:
        """Renders and tells what follows from a change; while something is held, in few words."""
        self._wanted = self._now(moves)
        self._renderer.want(self._wanted)
        if moves:
            self._moved = time.monotonic()
            self._later(_STILL, self._rest_if_still)
            self._tell({"type": "weights", "weights": self.weights(), "serial": self._serial})
            return
        if self.exact_frame() is not None:  # no picture will come of this event: the one that is there is right
            self.serial_shown = self._serial
            self._show()
        self.send_state()

    def _rest_if_still(self) -> None:
        if self._wanted.moves and time.monotonic() - self._moved >= 0.9 * _STILL:
            self._wanted = replace(self._wanted, moves=False)
            self._renderer.want(self._wanted)
            self.send_state()

    # ---- what browsers are told

    @property
    def strengths(self) -> Strengths:
        return self._wanted.strengths

    def weights(self) -> dict[str, list[float]] | None:
        return self.pictures.weights(self._wanted.strengths, self._muted) if self.pictures else None

    def state(self) -> dict:
        """All that the page shows beside the pictures."""
        width, height = self._resolved["camera"]["resolution"]
        return {
            "type": "state",
            "title": os.path.basename(self.opened.input),
            "file": os.path.basename(self.document.file),
            "others": self.opened.others,
            "groups": [
                {"kind": g.kind, "name": g.name, "title": g.title, "controls": [c.as_data() for c in g.controls]}
                for g in groups_of(self.document.data, self._up)
            ],
            "muted": sorted(self._muted),
            "weights": self.weights(),
            "frame": self.frame,
            "frames": self.opened.frames,
            "resolution": [width, height],
            "aspect": self._resolved["camera"]["pixel_aspect"] * width / height,
            "displays": self.displays,
            "display": self.display,
            "view": self.view,
            "free": self._pose is not None,
            "undo": self.document.can_undo,
            "redo": self.document.can_redo,
            "changed": self.document.is_changed,
            "command": self.command(),
            "message": self._message,
            "serial": self._serial,
        }

    def send_state(self) -> None:
        self._tell(self.state())

    def command(self) -> str:
        """The command line that renders this picture; what it cannot say is said instead."""
        try:
            sets = self.document.assignments()
        except scrim.UsageError as error:
            return f"# {error}"
        sets += [toml_text.assignment(key, value) for key, value in self._view_overrides().items()]
        sets += [f"{name}.intensity=0.0" for name in sorted(self._muted) if name.startswith("light.")]
        sets += ["ambient.color=[0.0, 0.0, 0.0]"] if "ambient" in self._muted else []
        words = ["scrim", "render", self.document.file or self.opened.input, *self.opened.options]
        words += [word for one in sets for word in ("--set", one)]
        if self.opened.frames != [1] or self.frame != 1:
            words += ["--frames", str(self.frame)]
        return shlex.join([*words, "-o", "picture.exr"])

    def lut(self) -> Lut:
        """The table of the chosen view; first a coarse one, and `show` is called when the fine one is there."""
        chosen, reader = (self.display, self.view), self._reader

        def refine() -> None:
            self._luts[chosen] = Lut(_luts.SIZE, _luts.table(reader, *chosen))
            self._later(0.0, self._show)

        if chosen not in self._luts:
            self._luts[chosen] = Lut(_luts.FIRST_SIZE, _luts.table(reader, *chosen, _luts.FIRST_SIZE))
            thread = threading.Thread(target=refine, name="scrim-view-table", daemon=True)
            self._later(_TABLE_SECONDS, thread.start)
        return self._luts[chosen]

    def exact_frame(self) -> scrim.Frame | None:
        """The frame that the scene's file makes; None while it is not there."""
        return self.pictures.frame if is_exact(self._wanted, self.pictures) else None

    def error(self) -> dict | None:
        """What a verification of the picture found: see `verification` of `--stats`. None where there was none."""
        frame = self.exact_frame()
        return frame.stats["verification"] if frame is not None and frame.error is not None else None

    def progress(self) -> float | None:
        return self._renderer.progress

    def _took(self, pictures: Pictures, wanted: Wanted, task: Task) -> None:
        def take() -> None:
            self.pictures = pictures
            self.serial_shown = wanted.serial
            self._show()

        self._later(0.0, take)

    def _lost(self, text: str) -> None:
        self._later(0.0, lambda: self._tell({"type": "error", "text": text}))
