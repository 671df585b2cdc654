# SPDX-License-Identifier: Apache-2.0
"""What all browsers of a viewer see and change together: the scene, the camera, and the newest pictures.

Everything here runs in the thread of the server's event loop. The exceptions: `_renderer` has a thread of its own, and
what `_aside` and `_turns` are given, such as reading a stage, is done in threads that they make.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from .. import _scrim
from .._bounds import Places
from .._errors import UsageError
from . import _code, _handles, _keys, _messages
from ._aside import Made, aside
from ._controls import Control, Group, groups_of
from ._document import Change, Document, name_of, path_of, rounded
from ._luts import Lut, Tables
from ._opened import Opened, renamed_files
from ._pictures import Pictures, Strengths, shape_of, strengths_of
from ._placing import Placing
from ._playback import Player
from ._renderer import Renderer, Task, Wanted, is_exact
from ._stage import Stage
from ._verified import verified
from ._viewpoint import Viewpoint

_STILL = 0.25  # seconds without an event after which a held mouse counts as resting
_MOST_FRAMES = 10_000  # between keys
_SLOW = 0.3  # seconds of reading a stage after which the page says that it is read


class Session(Placing):
    """`tell(message)`: sends a dict to all browsers. `show()`: sends them the newest pictures. `later(seconds, call)`:
    calls in the event loop's thread, and may be called from any thread. `serial`: number of the last event. Raises
    scrim.Error where the scene is bad."""

    def __init__(
        self,
        opened: Opened,
        tell: Callable[[dict], object],
        show: Callable[[], object],
        later: Callable[[float, Callable[[], object]], object],
        serial: int = 0,
    ) -> None:
        self.opened = replace(opened, loaded=None)  # the renderer takes the shot that is loaded
        self._tell, self._show = tell, show
        self._later = lambda seconds, call: later(seconds, lambda: self._careful(call))
        self.document = Document(opened.text, opened.file)
        self._reader: _scrim.Shot | None = None
        self.frame = opened.frame
        self._viewpoint = Viewpoint(Places(self._beside, self._knows_more))
        self._frames_all = False  # the user wants to see all volumes, once it is known where they are
        self._muted: frozenset[str] = frozenset()
        self._serial = self._changed_by = serial
        self._moved = 0.0  # when something was last held and moved
        self._message, self._verify = "", False
        self._stage = Stage(opened, lambda: self.document.data.get("camera"), self._later, self._lost_stage)
        self._failed = ("", "")  # the scene that could not be rendered last, and why
        self.player = Player(self, tell, self._later)
        self._tables = Tables(lambda: self._show(), self._later)
        self._region: tuple[int, int, int, int] | None = None
        self.pictures: Pictures | None = None
        self.serial_shown = 0
        self._read(opened.text)
        self.displays: dict[str, list[str]] = self._reader.displays
        self.display = next(iter(self.displays))
        self.view = self.displays[self.display][0]
        self._wanted, self._subject = self._now(moves=False), self._subject_now()
        self._renderer = Renderer(
            opened.folder, self._name, opened.ocio, self._took, self._lost, opened.grids,
            opened.loaded,
        )
        self._renderer.want(self._wanted)

    def close(self) -> None:
        """Ends the session. Browsers hear nothing more of it."""
        self._tell = self._show = lambda *_: None
        self._renderer.stop()
        self._tables.close()
        self._stage.turns.close()

    @property
    def serial(self) -> int:
        """Number of the last event."""
        return self._serial

    def _beside(self, work: Callable[[], Made], then: Callable[[Made], object]) -> None:
        """Calls `work` in a thread, and `then` with its result."""
        aside(work, self._later, then, lambda problem: self._tell({"type": "error", "text": _messages.told(problem)}))

    def _careful(self, call: Callable[[], object]) -> None:
        """Shows browsers an exception of `call`, which the event loop would only log."""
        try:
            call()
        except Exception as error:  # noqa: BLE001
            self._tell({"type": "error", "text": _messages.told(error)})

    # ---- what browsers ask for

    def handle(self, message: Mapping) -> None:
        """Does what a browser asks for. Raises scrim.Error where that is impossible, and any exception for a mistake
        of the viewer; the scene stays as it was."""
        kind = message.get("type")
        do = getattr(self, f"_on_{kind}", None) if isinstance(kind, str) and kind.isidentifier() else None
        if do is None:
            raise UsageError(f"the page asks for '{kind}', which this viewer does not know")
        self._serial = max(self._serial, _messages.whole(message.get("serial", 0)))
        self._message, self._verify = "", kind == "verify"
        try:
            do(message)
        except Exception:
            self.refuse(self._serial)
            raise

    def refuse(self, serial: int) -> None:
        """Answers an event that changed nothing: the pictures that are there count as those of the event."""
        self._serial = max(self._serial, serial)
        self._update(moves=False)

    def _on_navigate(self, message: Mapping) -> None:
        dx, dy = _messages.number(message.get("dx")), _messages.number(message.get("dy"))
        is_new = self._viewpoint.free is None
        self._viewpoint.move(message.get("mode"), dx, dy)
        self._update(moves=True)
        if is_new:
            self.send_state()

    def _on_rest(self, message: Mapping) -> None:
        self._moved = 0.0
        self._update(moves=False)

    def _on_view(self, message: Mapping) -> None:
        to = message.get("to")
        if to == "scene":
            self._viewpoint.free = None
        elif to == "frame":
            self._viewpoint.ask_again()
            self._frame_all()
        elif to == "keep":
            kept, free = self._viewpoint.kept(), self._viewpoint.free
            self._viewpoint.free = None
            try:
                self._change(kept, message)
            except Exception:
                self._viewpoint.free = free
                raise
            return
        else:
            raise UsageError(f"the page asks for the view '{to}'; expected scene, frame or keep")
        self._update(moves=False)

    def _frame_all(self) -> None:
        self._frames_all = not self._viewpoint.frame_all()
        if self._frames_all:
            self._message = "reading where the volumes are"

    def _knows_more(self) -> None:
        """Hears that the places of more volumes are known."""
        if self._frames_all:
            self._message = ""
            self._frame_all()
            self._update(moves=False)
        else:
            self.send_state()  # the places of handles depend on the point that the view turns about

    def _on_set(self, message: Mapping) -> None:
        control = self._control(message.get("id"))
        value = message.get("value")
        if not control.accepts(value):
            raise UsageError(f"{control.id}: the page gives {value!r}; expected a {control.kind}")
        self._change(control.changes(value), message)

    def _change(self, changes: Iterable[Change], message: Mapping) -> None:
        text = self.document.changed(_keys.kept(self.document.data, changes, self.frame))
        self._read(text)  # raises where the scene is bad then
        self.document.take(text, message.get("step"))
        self._update(moves=not message.get("done", True))

    def _on_camera(self, message: Mapping) -> None:
        """Looks through another camera of the stage."""
        name = message.get("name")
        if name not in self.opened.cameras:
            raise UsageError(f"the stage has no camera {name!r}")

        def take(camera: Mapping) -> None:
            self._message = ""
            self._viewpoint.free = None
            self._change([(("camera",), None), (("camera",), camera)], message)

        self._message = f"reading the camera {name}"
        self._stage.read_camera(name, lambda: self.frame, take, self._serial)
        self.send_state()

    def _on_muted(self, message: Mapping) -> None:
        names = _messages.names(message.get("names"))
        known = {f"light.{name}" for name in self._wanted.shape.lights} | {"ambient", "emission"}
        if not set(names) <= known:
            raise UsageError(f"the page mutes {names!r}; expected some of {', '.join(sorted(known))}")
        self._muted = frozenset(names)
        self._update(moves=False)

    def _on_frame(self, message: Mapping) -> None:
        number, moves = _messages.frame(message.get("number")), not message.get("done", True)
        self._go_to(number, lambda: self._update(moves), self._serial)

    def _on_play(self, message: Mapping) -> None:
        self.player.play(bool(message.get("on")))
        self._update(moves=False)

    def _go_to(
        self,
        number: int,
        then: Callable[[], object],
        serial: int | None = None,
        is_wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        """Reads the scene of a frame, and calls `then`. Where the scene is bad, the frame stays: a scene of a file
        raises scrim.Error; a stage is read beside, so `_lost_stage` hears of the error. `serial`: number of the event
        that asks for the frame. `is_wanted()`: False: the frame stays, because it is not wanted any more."""
        if not self._stage.has_frames:
            self._read_at(number, self.document.text)
            then()
            return

        def take(base: str, camera: Mapping | None) -> None:
            self._message = ""
            if not is_wanted():
                self.send_state()
                return
            text = self.document.on_base(base, {} if camera is None else {"camera": rounded(camera)})
            self._read_at(number, text)
            self.document.take_base(base, text)
            then()

        self._stage.read_frame(number, take, serial)
        self._later(_SLOW, self._say_that_the_stage_is_read)

    def _read_at(self, number: int, text: str) -> None:
        before, self.frame = self.frame, number
        try:
            self._read(text)
        except Exception:
            self.frame = before
            raise

    def _say_that_the_stage_is_read(self) -> None:
        if self._stage.turns.is_busy and not self._message:
            self._message = "reading the stage"
            self.send_state()

    def _lost_stage(self, problem: BaseException) -> None:
        """The stage could not be read."""
        self.player.stop()
        self._message = ""
        self._tell({"type": "error", "text": _messages.told(problem)})
        self._update(moves=False)

    def show_frame(self, number: int, is_wanted: Callable[[], bool]) -> None:
        """Goes to a frame while frames are played. Its picture is shown if it is kept; otherwise it is rendered."""
        self._go_to(number, lambda: self._show_played(number), is_wanted=is_wanted)

    def _show_played(self, number: int) -> None:
        self._wanted = self._now(moves=False)
        kept = self.player.find(self._look(), number)
        if kept is None:
            self._renderer.want(self._wanted)
            self.player.wait()
            return
        self._renderer.adopt(kept, self._wanted)
        self.pictures = kept
        self._show()
        self.player.go_on()

    @property
    def _name(self) -> str:
        """What messages call the scene."""
        return os.path.basename(self.opened.input)

    @property
    def frames(self) -> list[int]:
        """The frames that the page offers: those of sequences and stages, else those between the scene's keys."""
        keys = _keys.frames(self.document.data) if len(self.opened.frames) < 2 else []
        if not keys or max(keys) - min(keys) > _MOST_FRAMES:
            return self.opened.frames
        return list(range(min(math.floor(min(keys)), self.frame), max(math.ceil(max(keys)), self.frame) + 1))

    @property
    def fps(self) -> float:
        output = self.document.data.get("output", {})
        first = output[0] if isinstance(output, list) and output else output  # the further files of a list have none
        return max(float(first.get("fps", 24.0)), 0.1) if first else 24.0

    def _look(self) -> tuple:
        """All that the picture of a frame depends on."""
        return self.document.text, str(self._viewpoint.overrides()), self._muted

    def _on_region(self, message: Mapping) -> None:
        """Only a part of the picture is refined; without a box, all of it."""
        self._region = _messages.window(message.get("box"), self._viewpoint.resolution)
        self._update(moves=False)

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
            raise UsageError("the scene has no file yet: save it under a name")
        files = self.opened.temporary_files(self.document.data) if name else {}
        if not files:
            return self._save(name)
        self.opened.check_new(name)
        self._message = f"copying the files of {name}"
        self._update(moves=False)
        self._beside(lambda: self.opened.copied(files, name), lambda names: self._save(name, names))

    def _save(self, name: str, names: Mapping[str, str] | None = None) -> None:
        """`names`: new names of files that were copied for the saved scene, by their names in the present one."""
        try:
            if names:
                self._change(renamed_files(self.document.data, names), {})
            self.document.save(os.path.join(self.opened.folder, name) if name else "")
        except Exception:
            if names:
                self.opened.forget_copies(name)
                self._move_in_history(self.document.undo, "")
            raise
        self._message = f"saved {self.document.file}"
        self._update(moves=False)

    def _on_display(self, message: Mapping) -> None:
        display, view = _messages.names([message.get("display"), message.get("view")])
        if view not in self.displays.get(display, ()):
            raise UsageError(f"there is no view {view!r} of a display {display!r}")
        self.display, self.view = display, view
        self._show()
        self._update(moves=False)

    # ---- the state

    def _read(self, text: str) -> None:
        """Reads a scene with the engine. Raises scrim.Error where it is bad."""
        reader = _scrim.loads(
            text, folder=self.opened.folder, name=self._name, ocio=self.opened.ocio,
            sharing=self._reader, checked_frame=self.frame,
        )  # fmt: skip
        self._resolved = reader.resolved(self.frame)
        self._reader = reader
        self._viewpoint.read(self.document.data_of(text), self._resolved)

    def _controls(self) -> list[Group]:
        return groups_of(self.document.data, self._viewpoint.up, self.frame, self._viewpoint.pose.distance)

    def _control(self, name: object) -> Control:
        for group in self._controls():
            for control in group.controls:
                if control.id == name:
                    return control
        raise UsageError(f"the scene has no control {name!r}")

    def _now(self, moves: bool) -> Wanted:
        data = self.document.data
        view = self._viewpoint.overrides()
        return Wanted(
            self.document.text,
            shape_of(data, view, self.frame),
            strengths_of(data, self._resolved),
            view,
            self.frame,
            self._viewpoint.resolution,
            data.get("render", {}).get("quality") == "draft",
            self._muted,
            moves,
            self._verify,
            self.player.is_playing,
            self._region,
            self._serial,
            time.monotonic(),
            self._seen_from().as_data(),
        )

    def _update(self, moves: bool) -> None:
        """Renders the scene as it is now. Tells browsers the whole state; while something is held, only the weights."""
        self._wanted = self._now(moves)
        if (subject := self._subject_now()) != self._subject:
            self._subject, self._changed_by = subject, self._serial
        self._renderer.want(self._wanted)
        if moves:
            self._moved = time.monotonic()
            self._later(_STILL, self._rest_if_still)
            self._tell({"type": "weights", **self._seen()})
            return
        if self.exact_frame() is not None:  # the event needs no new picture
            self.serial_shown = self._answered()
            self._show()
        self.send_state()

    def _subject_now(self) -> tuple:
        """All that is shown but the view."""
        return {**self.document.data, "camera": None}, self.frame, self._muted

    def _answered(self) -> int:
        """Number of the last event up to which no event waits for the stage."""
        first = self._stage.turns.first_serial
        return self._serial if first is None else min(self._serial, first - 1)

    def _rest_if_still(self) -> None:
        if self._wanted.moves and time.monotonic() - self._moved >= 0.9 * _STILL:
            self._wanted = replace(self._wanted, moves=False)
            self._renderer.want(self._wanted)
            self.send_state()

    # ---- what browsers are told

    def _seen(self) -> dict:
        """What the page shows before the next picture is there. `changed_by`: the last event that changed more than
        the view."""
        return {
            "weights": self.weights(),
            "handles": _handles.of(self._scene_now(), self._seen_from()),
            "camera": self.camera,
            "changed_by": self._changed_by,
            "serial": self._serial,
        }

    @property
    def camera(self) -> Mapping:
        """The view, as the page projects by it."""
        return self._wanted.camera

    @property
    def strengths(self) -> Strengths:
        return self._wanted.strengths

    def weights(self) -> dict[str, list[float]] | None:
        return self.pictures.weights(self._wanted.strengths, self._muted) if self.pictures else None

    def state(self) -> dict:
        """Everything that the page shows beside the pictures."""
        return {
            "type": "state",
            "title": self._name,
            "file": os.path.basename(self.document.file),
            "others": self.opened.others,
            "groups": self._groups(),
            "muted": sorted(self._muted),
            **self._seen(),
            "frame": self.frame,
            "frames": self.frames,
            "resolution": self._viewpoint.resolution,
            "aspect": self._viewpoint.aspect,
            "cameras": self.opened.cameras,
            "region": self._region,
            "playing": self.player.is_playing,
            "displays": self.displays,
            "display": self.display,
            "view": self.view,
            "free": self._viewpoint.free is not None,
            "undo": self.document.can_undo,
            "redo": self.document.can_redo,
            "changed": self.document.is_changed,
            "command": self.command(),
            "message": self._message,
        }

    def send_state(self) -> None:
        self._tell(self.state())

    def command(self) -> str:
        """The command line that renders this picture; where none can, a comment that says why."""
        try:
            sets = self.document.assignments()
        except UsageError as error:
            return f"# {error}"
        frame = self.frame if self.opened.frames != [1] or self.frame != 1 else None
        over = self._viewpoint.overrides()
        over |= {
            f"{path_of('light', index, light)}.intensity": 0.0
            for index, light in enumerate(self.document.data.get("light", []))
            if f"light.{name_of('light', index, light)}" in self._muted
        }
        over |= {"ambient.color": [0.0, 0.0, 0.0]} if "ambient" in self._muted else {}
        return self.opened.command(self.document.file, sets, over, frame)

    def lut(self) -> Lut:
        """The table of the chosen view."""
        return self._tables.of(self._reader, self.display, self.view)

    def exact_frame(self) -> _scrim.Frame | None:
        """The frame that the scene's file makes; None while it is not there."""
        return self.pictures.frame if is_exact(self._wanted, self.pictures) else None

    def error(self) -> dict | None:
        """The result of the picture's verification: see `verification` of `--stats`. None: it was not verified."""
        frame = self.verified()
        return frame.stats["verification"] if frame is not None else None

    def verified(self) -> _scrim.Frame | None:
        """The frame of the picture, if it was verified."""
        frame = self.exact_frame()
        return frame if frame is not None and frame.error is not None else None

    def verified_pixels(self) -> dict:
        """The verified pixels, as the page shows them."""
        return verified(self.verified(), self.document.data, self._viewpoint.resolution)

    def progress(self) -> float | None:
        return self._renderer.progress

    def _took(self, pictures: Pictures, wanted: Wanted, task: Task) -> None:
        def take() -> None:
            self.pictures = pictures
            # Events that need no other picture may have come during the render.
            is_right = self.exact_frame() is not None
            shown = self._answered() if is_right else min(wanted.serial, self._answered())
            self.serial_shown = max(self.serial_shown, shown)
            if wanted.frame == self.frame and self.weights() is None:
                self.player.took(self._look(), self.frame, pictures)
            self._show()

        self._later(0.0, take)

    def _lost(self, error: Exception, wanted: Wanted) -> None:
        text = _messages.told(error)

        def tell() -> None:
            self._failed = (wanted.text, text)
            self._tell({"type": "error", "text": text})
            self.send_state()

        self._later(0.0, tell)

    def _groups(self) -> list[dict]:
        """The controls, as data. The control of an expression with an error also has the error, as `mistake`."""
        groups = [
            {"kind": g.kind, "name": g.name, "title": g.title, "folded": g.folded,
             "controls": [c.as_data() for c in g.controls]}
            for g in self._controls()
        ]  # fmt: skip
        text, error = self._failed
        if text == self.document.text and (found := _code.mistake(text, self._name, error)):
            for group in groups:
                if (group["kind"], group["name"]) == ("code", found["volume"]):
                    group["controls"][0]["mistake"] = found
        return groups
