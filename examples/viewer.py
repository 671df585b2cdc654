#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes viewer.webp, the looping picture of `scrim view`: a headless Chromium drives the page.

    PYTHONPATH=build/python build/python-venv/bin/python examples/viewer.py [PICTURE.webp]

Needs a build with the Python package, Debian's chromium, and from PyPI tornado, tomlkit and playwright. Each picture is
taken once the page shows what the last event asks for. Chromium also encodes the pictures; only the file around them is
written here (https://developers.google.com/speed/webp/docs/riff_container).
"""

from __future__ import annotations

import base64
import math
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, Playwright, sync_playwright

HERE = Path(__file__).resolve().parent
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
SIZE = (1120, 640)  # of the page
SHOWN = 840  # pixels that a picture is wide
MILLISECONDS = 80  # of a picture
QUALITY = 0.66
PATIENCE = 120_000

# The smoke of layers.toml, alone and in both lights.
SCENE = """\
[camera]
position = [0, 0.3, 5]
target = [0, 0, 0]
fov = 36
resolution = [780, 560]

[[volume]]
name = "smoke"
source = "noise"
parameters = { resolution = 96, seed = 4 }
density = { scale = 25 }
[volume.medium]
phase = { type = "hg", g = 0.3 }

[[light]]
name = "key"
type = "distant"
direction = [0.6, -0.5, -0.6]
color = [1, 0.72, 0.42]
intensity = 10

[[light]]
name = "rim"
type = "distant"
direction = [-0.8, -0.3, 0.5]
color = [0.35, 0.6, 1]
intensity = 14

[ambient]
color = [0.03, 0.04, 0.05]
"""

# A pointer, since pictures of a page have none.
POINTER = """() => {
    const pointer = document.createElement("div");
    pointer.id = "pointer";
    pointer.innerHTML = '<svg width="22" height="30"><path d="M2 2 L2 22 L7 17 L11 26 L15 24 L11 16 L18 16 Z" \
fill="white" stroke="black" stroke-width="1.5"/></svg>';
    pointer.style.cssText = "position: fixed; z-index: 99; pointer-events: none";
    document.body.append(pointer);
    const move = ({ clientX, clientY }) => (pointer.style.transform = `translate(${clientX - 2}px, ${clientY - 2}px)`);
    for (const kind of ["pointermove", "pointerdown", "pointerup"]) addEventListener(kind, move, true);
}"""

# A picture of the page, smaller, as WebP.
ENCODE = """async ([png, width, quality]) => {
    const picture = new Image();
    picture.src = `data:image/png;base64,${png}`;
    await picture.decode();
    const canvas = new OffscreenCanvas(width, Math.round((width * picture.height) / picture.width));
    const context = canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    const blob = await canvas.convertToBlob({ type: "image/webp", quality });
    return btoa(Array.from(new Uint8Array(await blob.arrayBuffer()), (byte) => String.fromCharCode(byte)).join(""));
}"""


class Film:
    """Pictures of a page, one after the other. `encoder`: another page, which makes WebP of them."""

    def __init__(self, page: Page, encoder: Page) -> None:
        self._page, self._encoder = page, encoder
        self._last, self.pictures = b"", []  # [a WebP, how many times it is shown]

    def take(self, times: int = 1) -> None:
        """Takes a picture once the page shows what was asked for last."""
        self._page.wait_for_function("scrim.pending === 0", timeout=PATIENCE)
        self._page.evaluate("new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
        png = self._page.screenshot()
        if png == self._last:
            self.pictures[-1][1] += times
            return
        self._last = png
        given = [base64.b64encode(png).decode(), SHOWN, QUALITY]
        self.pictures.append([base64.b64decode(self._encoder.evaluate(ENCODE, given)), times])

    def rest(self, times: int) -> None:
        """Waits for the finished picture and its layers, and shows it."""
        done = "scrim.isSettled && document.body.dataset.stage === 'exact' && document.body.dataset.layers"
        self._page.wait_for_function(f"{done} && document.body.dataset.table === 'fine'", timeout=PATIENCE)
        self._page.wait_for_timeout(400)
        self.take(times)

    def drag(self, places: list[tuple[float, float]], **buttons: str) -> None:
        """Goes to the first place, and drags over the others."""
        mouse = self._page.mouse
        mouse.move(*places[0])
        self.take(2)
        mouse.down(**buttons)
        for place in places[1:]:
            mouse.move(*place)
            self.take()
        mouse.up(**buttons)

    def write(self, path: Path) -> None:
        """An animated WebP that repeats for ever."""
        parts = [_chunk(b"ANIM", struct.pack("<IH", 0xFF000000, 0))]
        width = height = 0
        for webp, times in self.pictures:
            bits = _picture_of(webp)
            width, height = (side & 0x3FFF for side in struct.unpack_from("<HH", bits, 14))
            place = _three(0) + _three(0) + _three(width - 1) + _three(height - 1) + _three(MILLISECONDS * times)
            parts.append(_chunk(b"ANMF", place + b"\x02" + bits))  # replaces what was there
        head = _chunk(b"VP8X", b"\x02\x00\x00\x00" + _three(width - 1) + _three(height - 1))
        body = b"WEBP" + head + b"".join(parts)
        path.write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)


def _picture_of(webp: bytes) -> bytes:
    """The chunk of a WebP that is the picture: its profile is that of every screen."""
    at = 12  # behind the head of the file
    while webp[at : at + 4] != b"VP8 ":
        size = struct.unpack_from("<I", webp, at + 4)[0]
        at += 8 + size + size % 2
    return _chunk(b"VP8 ", webp[at + 8 : at + 8 + struct.unpack_from("<I", webp, at + 4)[0]])


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _three(number: int) -> bytes:
    return struct.pack("<I", number)[:3]


def along(*places: tuple[float, float], count: int) -> list[tuple[float, float]]:
    """`count` places on the way from each to the next, slower at both ends."""
    out = [places[0]]
    for (x0, y0), (x1, y1) in zip(places, places[1:]):
        for i in range(1, count + 1):
            part = 0.5 - 0.5 * math.cos(math.pi * i / count)
            out.append((x0 + part * (x1 - x0), y0 + part * (y1 - y0)))
    return out


def middle(page: Page, selector: str) -> tuple[float, float]:
    box = page.locator(selector).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def play(page: Page, film: Film) -> None:
    """An orbit, a light that is dragged around the smoke, and a slider; back to where it began."""
    film.rest(8)
    x, y = middle(page, "#picture")
    film.drag(along((x - 90, y + 60), (x + 110, y + 90), count=14))
    film.rest(7)
    page.click("#scene-camera")
    film.rest(4)
    light = middle(page, "[title='key']")
    film.drag(along(light, (x - 20, y - 150), (x + 175, y - 40), count=11))
    film.rest(7)
    slide(page, film, "rim (distant) intensity", (-50, 8))
    slide(page, film, "smoke density", (-12, 2))
    page.click("#undo")
    page.click("#undo")
    page.click("#undo")
    page.locator("aside").evaluate("panel => (panel.scrollTop = 0)")
    film.rest(2)


def slide(page: Page, film: Film, label: str, ways: tuple[int, int]) -> None:
    """Drags a slider by so many pixels from where it is, one after the other."""
    slider = page.get_by_label(label, exact=True)
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    at = (box["x"] + 8 + float(slider.input_value()) / 1000 * (box["width"] - 16), box["y"] + box["height"] / 2)
    film.drag(along(at, *((at[0] + way, at[1]) for way in ways), count=7))
    film.rest(7)


@contextmanager
def viewer_of(scene: str) -> Iterator[str]:
    """Runs `scrim view`; gives the address at which it listens."""
    words = [sys.executable, "-m", "scrim.view", scene, "--no-browser"]
    viewer = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        yield viewer.stdout.readline().split(": ", 1)[1].strip()
    finally:
        viewer.terminate()
        viewer.wait()


def chromium_of(kit: Playwright) -> Browser:
    return kit.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)


def main() -> None:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "viewer.webp"
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as kit:
        (Path(folder) / "smoke.toml").write_text(SCENE)
        with viewer_of(f"{folder}/smoke.toml") as url:
            chromium = chromium_of(kit)
            view = {"width": SIZE[0], "height": SIZE[1]}
            page = chromium.new_page(bypass_csp=True, viewport=view)
            page.goto(url)
            page.evaluate(POINTER)
            film = Film(page, chromium.new_page())
            play(page, film)
            film.write(path)
            print(f"{path}: {len(film.pictures)} pictures, {path.stat().st_size / 1000:.0f} kB")
            chromium.close()


if __name__ == "__main__":
    main()
