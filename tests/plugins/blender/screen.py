# SPDX-License-Identifier: Apache-2.0
# What Blender's window shows, as arrays, and checks that take turns with Blender's event loop.
import os
import sys
import time
import traceback

import bpy
import numpy as np
import PIL.Image

TICK = 0.1
PATIENCE = 60  # seconds for one wait, on a busy machine


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
    # By another library: an image of Blender's own would be a change of the scene.
    pixels = np.asarray(PIL.Image.open(path).convert("RGB")) / 255.0
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
