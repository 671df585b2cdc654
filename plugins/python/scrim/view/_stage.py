# SPDX-License-Identifier: Apache-2.0
"""The stage that a session shows: its frames and cameras, which are read beside the event loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ._opened import Opened
from ._turns import Turn, Turns


class Stage:
    """Reads scenes of frames (`opened.text_at`) and cameras (`opened.keeps`). `scene_camera()`: the camera of the scene
    as it is now. `later`, `failed`: as for `Turns`. `turns`: the reading that is under way or waits."""

    def __init__(
        self,
        opened: Opened,
        scene_camera: Callable[[], object],
        later: Callable[[float, Callable[[], object]], object],
        failed: Callable[[BaseException], object],
    ) -> None:
        self._shot, self._text_at, self._scene_camera = opened.keeps, opened.text_at, scene_camera
        self._chosen: tuple | None = None  # the stage through one of its other cameras, and that camera in the scene
        self.turns = Turns(later, failed)

    @property
    def has_frames(self) -> bool:
        """Whether each frame has a scene of its own."""
        return self._text_at is not None

    def read_frame(self, number: int, take: Callable[[str, Mapping | None], object], serial: int | None) -> None:
        """Calls `take(text, camera)` with the scene of a frame. `camera`: what the camera that was chosen is at the
        frame; None where the scene has another camera. `serial`: number of the event that asks for the frame; None: the
        player asks."""
        text_at = self._text_at

        def begin() -> Callable[[], tuple]:
            through = self._through()
            return lambda: (through, text_at(number), through.scene(number)["camera"] if through else None)

        def then(made: tuple) -> None:
            through, text, camera = made
            if self._through() is not through:  # a camera was chosen, or its choice undone, while the stage was read
                self.read_frame(number, take, serial)
                return
            take(text, camera)
            if through:
                self._chosen = (through, self._scene_camera())

        self.turns.ask(Turn("played" if serial is None else "frame", begin, then, serial))

    def read_camera(
        self, name: str, frame: Callable[[], int], take: Callable[[Mapping], object], serial: int
    ) -> None:
        """Calls `take(camera)` with the camera `name` at the frame `frame()`. What the scene's camera is then moves
        with the frames."""
        shot = self._shot

        def begin() -> Callable[[], tuple]:
            number = frame()

            def read() -> tuple:
                through = shot.through(name)
                return through, through.scene(number)["camera"]

            return read

        def then(made: tuple) -> None:
            through, camera = made
            take(camera)
            self._chosen = (through, self._scene_camera())

        self.turns.ask(Turn("camera", begin, then, serial))

    def _through(self) -> object:
        """The stage through the camera that was chosen; None where the scene has another camera."""
        return self._chosen[0] if self._chosen and self._scene_camera() == self._chosen[1] else None
