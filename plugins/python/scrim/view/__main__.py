# SPDX-License-Identifier: Apache-2.0
"""`python -m scrim.view SCENE`: what `scrim view` runs. It ends with the exit statuses of the program `scrim`."""

from __future__ import annotations

import argparse
import asyncio
import functools
import gc
import importlib
import logging
import os
import signal
import sys
import threading
import webbrowser

from scrim_kit.program import Status, error_line

import scrim

from . import needs
from ._door import Door
from ._opening import may_load_usd, opened, takes_long

_STATUS = {
    scrim.UsageError: Status.USAGE,
    scrim.InputError: Status.INPUT,
    scrim.OutputError: Status.OUTPUT,
    scrim.OutOfMemoryError: Status.MEMORY,
}


def _arguments(words: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="scrim view", description="Shows a scene in the browser.")
    parser.add_argument("scene", metavar="SCENE|ASSET|FOLDER")
    parser.add_argument("--listen", default="127.0.0.1:0", metavar="HOST:PORT")
    parser.add_argument("--frame", type=int)
    parser.add_argument("--up", default="")
    parser.add_argument("--res", default="", metavar="WxH")
    parser.add_argument("--ocio", default="")
    parser.add_argument("--no-browser", action="store_true")
    return parser.parse_args(words)


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not (port.isdecimal() and port.isascii() and len(port) < 6 and int(port) < 65536 and host):
        raise scrim.UsageError(f"--listen '{text}': expected HOST:PORT, such as 127.0.0.1:8080, or 0 for a free port")
    return host.strip("[]"), int(port)


def _axis(text: str) -> tuple[float, float, float] | None:
    if not text:
        return None
    sign, letter = (-1.0, text[1:]) if text.startswith("-") else (1.0, text)
    if letter not in ("x", "y", "z"):
        raise scrim.UsageError(f"--up '{text}': expected x, y, z, -x, -y or -z")
    return tuple(sign * (letter == axis) for axis in "xyz")  # type: ignore[return-value]


def _size(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal() and text.isascii()):
        raise scrim.UsageError(f"--res '{text}': expected WxH, such as 512x512")
    return int(width), int(height)


def _invite(door: Door, opens_browser: bool) -> None:
    print(f"scrim view: {door.url}", flush=True)
    if opens_browser and any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")):
        try:
            file = door.invite()
        except OSError as error:
            logging.getLogger("scrim").warning("no browser is opened: %s", error)
            return
        threading.Thread(target=webbrowser.open, args=(file,), daemon=True).start()


async def _serve(server: object) -> int:
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, server.end, 128 + number)
    return await server.run()


def _view(words: list[str] | None) -> int:
    given = _arguments(words)
    needs()
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    listen = _address(given.listen)
    # The server's packages are loaded while the program reads the volumes. OpenUSD must be loaded alone: its libraries
    # wait for Python's lock while the system's loader is locked, and an import in another thread waits for the loader
    # while it holds Python's lock. Neither would end.
    if not may_load_usd(given.scene):
        threading.Thread(target=importlib.import_module, args=("._server", __package__), daemon=True).start()
    opening = functools.partial(
        opened, given.scene, frame=given.frame, ocio=given.ocio, up=_axis(given.up), resolution=_size(given.res)
    )  # fmt: skip
    if not takes_long(given.scene):
        scene = opening()
        opening = lambda: scene  # noqa: E731
    door = Door(*listen)
    try:
        _invite(door, not given.no_browser)
        from ._server import Server

        status = asyncio.run(_serve(Server(opening, door)))
    finally:
        door.end_invitation()
    gc.collect()  # pictures must go before the compiled module that made them
    return status


def main(words: list[str] | None = None) -> int:
    logging.basicConfig(format="scrim: %(message)s", level=logging.WARNING)
    try:
        return _view(words)
    except scrim.Error as error:
        print(error_line(str(error)), file=sys.stderr)
        return next((status for kind, status in _STATUS.items() if isinstance(error, kind)), Status.RENDER)
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
