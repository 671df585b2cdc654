# SPDX-License-Identifier: Apache-2.0
"""Shows a session to browsers: the page, and a web socket for what changes.

A browser needs the token or the ticket once; a cookie stands for it from then on. Requests under a foreign name of this
machine, or from the page of somebody else, are refused, since any page that a user visits may send them. The only files
that can be had are those of the page.
"""

from __future__ import annotations

import asyncio
import ipaddress
import json
import logging
import os
import socket
import struct
import tempfile
import urllib.parse
from collections.abc import Callable
from dataclasses import replace

import tornado.httpserver
import tornado.web
import tornado.websocket
from tornado.escape import json_encode

from .. import _scrim
from .._errors import UsageError
from . import _luts, _messages
from ._aside import Made, aside
from ._door import Door, is_any
from ._luts import Lut
from ._opened import Opened
from ._opening import opened
from ._pictures import Texture
from ._session import Session

_PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page")
_PARTS = ("code", "curves", "handles", "looks", "page", "panel", "picture", "places", "shaders", "steer", "values",
          "verified")  # fmt: skip
_FILES = {
    "": ("index.html", "text/html; charset=utf-8"),
    **{f"{name}.js": (f"{name}.js", "text/javascript; charset=utf-8") for name in _PARTS},
    "style.css": ("style.css", "text/css; charset=utf-8"),
}
_LOCAL = ("localhost", "127.0.0.1", "::1")
_MOST_MESSAGE = 65536  # bytes that a browser may send at a time
_PROGRESS_SECONDS = 0.25


class Server:
    """Serves at a door from `run` on. `opening()`: returns the `Opened`, or raises scrim.Error; while it works,
    browsers load the page."""

    def __init__(self, opening: Callable[[], Opened], door: Door) -> None:
        self.door = door
        self.host, self.port = door.host, door.port
        self.browsers: set[_Socket] = set()
        self._opening = opening
        self._opened: Opened | None = None
        self.session: Session | None = None  # until it is opened
        self._ended: asyncio.Event | None = None
        self.status = 0

    async def run(self, ready: asyncio.Event | None = None) -> int:
        """Serves until `end`; gives the exit status. Raises scrim.Error where the scene is bad."""
        loop = asyncio.get_running_loop()
        self._ended, self._opens = asyncio.Event(), asyncio.Lock()

        def later(seconds: float, call: object) -> None:
            try:
                loop.call_soon_threadsafe(*((loop.call_later, seconds, call) if seconds else (call,)))
            except RuntimeError:  # the loop has ended
                pass

        self._later = later
        rules = [("socket", _Socket), ("picture.exr", _Exr), ("(?P<name>[^/]*)", _Page)]
        app = tornado.web.Application(
            [(f"/(?:t/(?P<key>[^/]+)/)?{path}", handler, {"server": self}) for path, handler in rules],
            websocket_max_message_size=_MOST_MESSAGE, websocket_ping_interval=20, log_function=lambda handler: None,
        )  # fmt: skip
        http = tornado.httpserver.HTTPServer(app)
        http.add_sockets([self.door.socket])
        telling = None
        try:
            if await self._open():
                telling = asyncio.ensure_future(self._tell_progress())
                if ready is not None:
                    ready.set()
                await self._ended.wait()
        finally:
            if telling is not None:
                telling.cancel()
            http.stop()
            for browser in list(self.browsers):
                browser.close(1001, "the viewer has ended")
            await http.close_all_connections()
            if self.session is not None:
                self.session.close()
            self.session = self._opened = None
        return self.status

    def aside(self, work: Callable[[], Made]) -> asyncio.Future[Made]:
        """The result of `work`, which is called in a thread."""
        made = asyncio.get_running_loop().create_future()
        aside(
            work,
            self._later,
            lambda it: made.done() or made.set_result(it),
            lambda problem: made.done() or made.set_exception(problem),
        )
        return made

    async def _open(self) -> bool:
        """Opens the scene, and greets the browsers that wait. False: `end` was called first."""
        made = self.aside(self._opening)
        ended = asyncio.ensure_future(self._ended.wait())
        await asyncio.wait({made, ended}, return_when=asyncio.FIRST_COMPLETED)
        ended.cancel()
        if not made.done():
            made.cancel()
            return False
        self._opened = made.result()
        self.session = self._begin(self._opened)
        self._opened = replace(self._opened, loaded=None)
        for browser in list(self.browsers):
            browser.greet()
        return True

    def _begin(self, opened: Opened, serial: int = 0) -> Session:
        return Session(opened, self.tell, self.show, self._later, serial)

    async def open(self, name: object, serial: int) -> None:
        """Shows another file of the folder. Raises where it cannot be opened; the scene stays then."""
        others = self.session.opened.others

        def begin() -> Session:
            if name not in others:
                raise UsageError(f"there is no {_messages.shortened(name)} among the files of the folder")
            path = os.path.join(os.path.dirname(self._opened.input), name)
            return self._begin(replace(opened(path, ocio=self._opened.ocio), others=others), serial)

        async with self._opens:  # one after the other: the last one that was asked for is shown
            try:
                new = await self.aside(begin)
            except Exception:
                self.session.refuse(serial)
                raise
            before, self.session = self.session, new
            new.refuse(before.serial)  # events that came in the meantime were for the scene before
            await self.aside(before.close)

    def end(self, status: int = 0) -> None:
        """Ends `run`, from the loop's thread."""
        self.status = status
        if self._ended is not None:
            self._ended.set()

    def tell(self, message: dict) -> None:
        text = json_encode(message)
        if message.get("type") == "error":
            logging.getLogger("scrim").error("%s", message["text"])
        for browser in list(self.browsers):
            browser.tell(text)

    def show(self) -> None:
        for browser in list(self.browsers):
            browser.show()

    async def _tell_progress(self) -> None:
        last = None
        while True:
            await asyncio.sleep(_PROGRESS_SECONDS)
            now = self.session.progress()
            if now != last and self.browsers:
                self.tell({"type": "progress", "part": now})
            last = now

    def allows(self, request: tornado.httputil.HTTPServerRequest) -> bool:
        """Whether a request names this machine as it should, and comes from our own page if from any."""
        host = _name_of(request.host)
        mine = {self.host.lower(), *_LOCAL}
        if is_any(self.host):  # listening on all addresses: any address in numbers, and the names of this machine
            mine |= {socket.gethostname().lower(), socket.getfqdn().lower()}
        if host not in mine and not (is_any(self.host) and _is_number(host)):
            return False
        origin = request.headers.get("Origin")
        return origin is None or urllib.parse.urlsplit(origin).netloc.lower() == request.host.lower()


def _name_of(host: str) -> str:
    try:
        return (urllib.parse.urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def _is_number(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


class _Guarded(tornado.web.RequestHandler):
    """A request needs the token or the cookie, and a host and origin of this viewer."""

    def initialize(self, server: Server) -> None:
        self.server = server

    @property
    def _cookie(self) -> str:
        return f"scrim-view-{self.server.port}"  # all ports of a host share cookies

    @property
    def _framed_by(self) -> str:
        # A notebook's page may frame addresses that hold the token. Browsers do not send the cookies of such a frame.
        return "*" if self.request.path.startswith("/t/") else "'self'"

    def set_default_headers(self) -> None:
        self.set_header(
            "Content-Security-Policy",
            f"default-src 'self'; img-src 'self' data:; frame-ancestors {self._framed_by}; base-uri 'none'",
        )
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")

    def prepare(self) -> None:
        if not self.server.allows(self.request):
            raise tornado.web.HTTPError(403, reason="Foreign host or origin")
        door = self.server.door
        self.is_guest = door.knows(self.get_argument("token", None)) or door.takes(self.get_argument("ticket", None))
        is_known = door.remembers(self.get_cookie(self._cookie)) or door.knows(self.path_kwargs.get("key"))
        if not (self.is_guest or is_known):
            raise tornado.web.HTTPError(403, reason="The token is missing")

    def write_error(self, status_code: int, **more: object) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}. The address that the viewer printed has the token.\n")


class _Page(_Guarded):
    def get(self, name: str, key: str | None = None) -> None:
        if name not in _FILES:
            raise tornado.web.HTTPError(404)
        if self.is_guest:
            # The browser is sent on to an address without the token, which its history and the screen then show. The
            # cookie is lax: a strict one would not be sent after the file of the invitation. `allows` refuses requests
            # from other pages.
            self.set_cookie(self._cookie, self.server.door.cookie, httponly=True, samesite="Lax")
            self.redirect("/" + name)
            return
        file, kind = _FILES[name]
        self.set_header("Content-Type", kind)
        with open(os.path.join(_PAGE, file), "rb") as page:
            self.finish(page.read())


class _Exr(_Guarded):
    """The picture that the scene's file makes, once it is there."""

    async def get(self, key: str | None = None) -> None:
        session = self.server.session
        frame = session.exact_frame() if session is not None else None
        if frame is None:
            raise tornado.web.HTTPError(409, reason="The picture is not finished")
        data = await self.server.aside(lambda: _exr_of(frame))
        self.set_header("Content-Type", "image/x-exr")
        self.set_header("Content-Disposition", 'attachment; filename="picture.exr"')
        self.finish(data)


def _exr_of(frame: _scrim.Frame) -> bytes:
    with tempfile.TemporaryDirectory(prefix="scrim-view-") as folder:
        with open(frame.write(os.path.join(folder, "picture.exr")), "rb") as file:
            return file.read()


class _Socket(_Guarded, tornado.websocket.WebSocketHandler):
    """One browser. It gets a picture only after it said that it has the last one, so pictures do not queue up."""

    def initialize(self, server: Server) -> None:
        super().initialize(server)
        self._has: set[int] = set()  # numbers of textures there
        self._waits = False  # the browser has not said yet that it has the last picture
        self._is_old = False  # what the browser has is not the newest
        self._lut: Lut | None = None  # that the browser has
        self._verified: object = None  # the frame whose verified pixels the browser has

    def check_origin(self, origin: str) -> bool:
        return True  # `allows` has checked it

    def open(self, *arguments: str, **named: str) -> None:
        self.set_nodelay(True)
        self.server.browsers.add(self)
        if self.server.session is not None:
            self.greet()

    def greet(self) -> None:
        """Sends the state and the pictures."""
        self.tell(json_encode(self.server.session.state()))
        self.show()

    def on_close(self) -> None:
        self.server.browsers.discard(self)

    def on_message(self, text: str | bytes) -> None:
        try:
            message = json.loads(text)
            if not isinstance(message, dict):
                raise ValueError("a message is no object")
        except (ValueError, RecursionError) as error:
            self._fail(f"the page sent what is no message: {error}")
            return
        if message.get("type") == "have":
            self._waits = False
            if self._is_old:
                self.show()
        elif message.get("type") == "end":
            self.server.end()
        elif self.server.session is not None:
            try:
                if message.get("type") == "open":
                    opening = self.server.open(message.get("name"), _messages.whole(message.get("serial", 0)))
                    asyncio.ensure_future(opening).add_done_callback(self._opened)
                else:
                    self.server.session.handle(message)
            except Exception as error:  # noqa: BLE001  it would end the connection
                self._fail(_messages.told(error))

    def _opened(self, opening: asyncio.Future) -> None:
        if not opening.cancelled() and (error := opening.exception()) is not None:
            self._fail(_messages.told(error))

    def _fail(self, text: str) -> None:
        self.tell(json_encode({"type": "error", "text": text}))

    def tell(self, text: str | bytes, binary: bool = False) -> None:
        try:
            sent = self.write_message(text, binary=binary)
        except tornado.websocket.WebSocketClosedError:
            self.server.browsers.discard(self)
            return
        # A browser that leaves meanwhile is no error; it is discarded in `on_close`.
        sent.add_done_callback(lambda done: done.cancelled() or done.exception())

    def show(self) -> None:
        """Sends the newest pictures and the view's table, unless the browser has them."""
        session = self.server.session
        pictures = session.pictures
        if pictures is None:
            return
        lut = session.lut()
        if self._lut is not lut:
            self._lut = lut
            head = {
                "type": "lut",
                "size": lut.size,
                "fine": lut.size == _luts.SIZE,
                "knee": _luts.KNEE,
                "most": _luts.MOST,
            }
            self.tell(_packed(head, [lut.data]), binary=True)
        self._is_old = self._waits
        if self._waits:
            return
        if (frame := session.verified()) is not None and frame is not self._verified:
            self._verified = frame
            self.tell(json_encode({"type": "verified", **session.verified_pixels()}))
        self._waits = True
        slots: dict[str, Texture] = {"beauty": pictures.beauty}
        if pictures.rest is not None:
            slots["rest"] = pictures.rest
        slots |= {name: layer.texture for name, layer in (pictures.layers or {}).items() if layer.texture}
        if pictures.plate is not None:
            slots["plate"] = pictures.plate
        if pictures.depth is not None:
            slots["depth"] = pictures.depth.texture
        fresh = [texture for texture in slots.values() if texture.number not in self._has]
        self._has = {texture.number for texture in slots.values()}
        head = {
            "type": "pictures",
            "slots": {name: texture.number for name, texture in slots.items()},
            "fresh": [{"number": t.number, "shape": t.pixels.shape} for t in fresh],
            "weights": session.weights(),
            "stage": pictures.stage,
            "exact": session.exact_frame() is not None,
            "layers": pictures.layers is not None,
            "seconds": pictures.seconds,
            "error": session.error(),
            "depths": pictures.depth.ends if pictures.depth else None,
            "camera": pictures.camera,
            "aim": session.camera,
            "serial": session.serial_shown,
        }
        self.tell(_packed(head, [texture.pixels.tobytes() for texture in fresh]), binary=True)


def _packed(head: dict, parts: list[bytes]) -> bytes:
    """A binary message: the length of the head, the head as JSON with spaces up to a multiple of 8, and the parts."""
    text = json_encode(head).encode()
    text += b" " * (-(len(text) + 4) % 8)
    return b"".join([struct.pack("<I", len(text)), text, *parts])
