# SPDX-License-Identifier: Apache-2.0
# What Blender's window shows, as arrays, and checks that take turns with Blender's event loop.
import os
import struct
import sys
import time
import traceback
import zlib

import bpy
import numpy as np

TICK = 0.1
PATIENCE = 60  # seconds for one wait, on a busy machine


def read_png(path):
    """Height x width x channels of bytes, rows from the top. Images of Blender's own would be a change of the scene."""
    with open(path, "rb") as file:
        data = file.read()
    width, height, depth, kind, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    assert data[1:4] == b"PNG" and depth == 8 and kind in (2, 6) and not interlaced, path
    count = 3 if kind == 2 else 4
    at, packed = 8, b""
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + size]
        at += 12 + size
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * count)
    out = np.zeros((height, width, count), np.uint8)
    above = np.zeros((width, count), np.uint8)
    for row, line in zip(out, lines):
        row[:] = unfiltered(int(line[0]), line[1:].reshape(width, count), above)
        above = row
    return out


def unfiltered(kind, line, above):
    """A line of a PNG whose bytes count from those to the left (1, 3, 4) and above (2, 3, 4)."""
    if kind == 0:
        return line
    if kind == 1:
        return np.cumsum(line, axis=0, dtype=np.uint8)
    if kind == 2:
        return line + above
    out = np.zeros_like(line)
    left = corner = np.zeros(line.shape[1], np.int32)
    for x, (value, up) in enumerate(zip(line.astype(np.int32), above.astype(np.int32))):
        guess = (left + up) // 2 if kind == 3 else paeth(left, up, corner)
        left, corner = (value + guess) & 255, up
        out[x] = left
    return out


def paeth(left, up, corner):
    sides = np.stack([left, up, corner])
    return np.take_along_axis(sides, np.abs(left + up - corner - sides).argmin(0)[None], 0)[0]


def view():
    """(window, area, region, space) of the 3D viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    return window, area, next(r for r in area.regions if r.type == "WINDOW"), area.spaces.active


def shot(folder, name):
    """The viewport as it is on the screen: height x width x 3, from 0 to 1, rows from the top."""
    window, area, region, _ = view()
    path = os.path.join(folder, name + ".png")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.screen.screenshot(filepath=path)
    pixels = read_png(path)[:, :, :3] / 255.0
    top = pixels.shape[0] - region.y - region.height
    return pixels[top : top + region.height, region.x : region.x + region.width]


def until(condition, what):
    """For `yield from`: gives way to Blender until the condition holds."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"{PATIENCE} s went by without {what}")
        yield


def ticks(count):
    for _ in range(count):
        yield


def run(checks, folder, program):
    """Runs generators one after the other while Blender goes on, and ends it with their status."""
    state = {"left": list(checks), "now": None, "name": "", "failed": 0}

    def step():
        try:
            if state["now"] is None:
                if not state["left"]:
                    finish()
                check = state["left"].pop(0)
                state["name"], state["now"] = check.__name__, check()
            next(state["now"])
        except StopIteration:
            print(f"{program}: {state['name']}: passed", flush=True)
            state["now"] = None
        except Exception:
            state["failed"] += 1
            state["now"] = None
            print(f"{program}: {state['name']}: FAILED\n{traceback.format_exc()}", flush=True)
        return TICK

    def finish():
        failed = state["failed"]
        print(f"{program}: {len(checks) - failed} passed, {failed} failed", flush=True)
        sys.stderr.flush()
        os._exit(1 if failed else 0)

    bpy.app.timers.register(step, first_interval=1.0, persistent=True)
