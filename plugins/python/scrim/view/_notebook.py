# SPDX-License-Identifier: Apache-2.0
"""The viewer in a cell of a notebook: a server in a thread of the kernel, and its page in a frame."""

from __future__ import annotations

import asyncio
import html
import os
import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

from .._errors import Error
from .._grids import fields_of
from ._door import Door
from ._opened import Opened

if TYPE_CHECKING:
    from .._scrim import Shot


class View:
    """A viewer that runs until `close`, or until Python ends. A notebook displays it as the value of a cell."""

    def __init__(self, opened: Opened, height: int) -> None:
        from ._server import Server

        self.height = height
        self._door = Door()
        self._server = Server(lambda: opened, self._door)
        self._ready, self._problem = threading.Event(), None
        self._text = opened.text
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = threading.Thread(target=self._serve, name="scrim-view", daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._problem is not None:
            raise self._problem

    def _serve(self) -> None:
        async def serve() -> None:
            self._loop = asyncio.get_running_loop()
            await self._server.run(self._ready)

        try:
            asyncio.run(serve())
        except Error as problem:
            self._problem = problem
            self._ready.set()

    @property
    def url(self) -> str:
        """The address for a frame on this machine. Whoever knows it can use the viewer."""
        return f"http://127.0.0.1:{self._door.port}/t/{self._door.token}/"

    @property
    def toml(self) -> str:
        """The scene as it was changed in the viewer."""
        session = self._server.session
        if session is not None:
            self._text = session.document.text
        return self._text

    def close(self) -> None:
        """Ends the viewer."""
        if self._thread.is_alive() and self._loop is not None:
            self._text = self.toml  # the session is gone afterwards
            self._loop.call_soon_threadsafe(self._server.end)
            self._thread.join()

    def _repr_html_(self) -> str:
        return (
            f'<iframe src="{html.escape(self.url)}" width="100%" height="{self.height}" style="border: 0" '
            'title="Scrim" allow="clipboard-write"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<scrim viewer at {self.url}>"


def opened_of(shot: Shot, frame: int | None, folder: object, volumes: Mapping[str, object] | None) -> Opened:
    """The `Opened` of a shot."""
    path = os.path.abspath(os.fspath(folder) if folder else os.path.dirname(shot.path) or ".")
    grids = {name: fields_of(given) for name, given in (volumes or {}).items()}
    frames = list(shot.frames)
    number = frames[0] if frame is None else frame
    return Opened(shot.toml(), "", path, shot.path, frames, number, grids=grids, keeps=shot)
