# SPDX-License-Identifier: Apache-2.0
"""What browsers ask for by pointing into the picture, and lights that come and go."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .._errors import UsageError
from . import _handles, _keys, _lens, _lights, _messages
from ._document import name_of


class Placing:
    """A part of a `Session`."""

    def _on_place(self, message: Mapping) -> None:
        """A light's handle was dragged."""
        index, x, y = self._light(message)
        self._change(_handles.moved(self._scene_now(), index, self._seen_from(), x, y), message)

    def _on_add(self, message: Mapping) -> None:
        """A new light."""
        data = self.document.data
        light = _lights.added(data, message.get("light"), self._viewpoint.pose, self._resolved["lights"])
        self._change([(("light", len(data.get("light", []))), light)], message)

    def _on_remove(self, message: Mapping) -> None:
        """A light goes."""
        name = message.get("light")
        index = _number_of(name, self.document.data)
        if index is None:
            raise UsageError(f"the scene has no light {name!r}")
        muted, self._muted = self._muted, self._muted - {f"light.{name}"}
        try:
            self._change(_lights.removed(self.document.data, index), message)
        except Exception:
            self._muted = muted
            raise

    def _on_highlight(self, message: Mapping) -> None:
        """A light is to shine where the page was clicked."""
        index, x, y = self._light(message)
        changes = _handles.highlit(self._scene_now(), index, self._seen_from(), self._depth(), x, y)
        if changes is None:
            raise UsageError("there is nothing to light at this place")
        self._change(changes, message)

    def _on_focus(self, message: Mapping) -> None:
        """The lens is to be sharp where the page was clicked."""
        x, y = _messages.number(message.get("x")), _messages.number(message.get("y"))
        self._change(_lens.focused(self.document.data, self._depth(), x, y), message)

    def _depth(self) -> np.ndarray:
        depth = self.pictures.depth if self.pictures else None
        if depth is None:
            raise UsageError("where things are is known once the picture is finished: wait for it")
        return depth.mean

    def _scene_now(self) -> Mapping:
        """The scene with the values that its keys have at the frame."""
        return _keys.at(self.document.data, self.frame)

    def _light(self, message: Mapping) -> tuple[int, float, float]:
        name, scene = message.get("light"), self._scene_now()
        index = _number_of(name, scene)
        if index is None or not _handles.has_handle(scene["light"][index]):
            raise UsageError(f"the scene has no light {name!r} that can be placed in the picture")
        return index, _messages.number(message.get("x")), _messages.number(message.get("y"))

    def _seen_from(self) -> _handles.View:
        return _handles.View(self._viewpoint.pose, self._viewpoint.shift)


def _number_of(name: object, scene: Mapping) -> int | None:
    """The place of a light among those of a scene; None where it is not there."""
    lights = scene.get("light", [])
    return next((i for i, light in enumerate(lights) if name_of("light", i, light) == name), None)
