# SPDX-License-Identifier: Apache-2.0
# The viewport: a child renders a draft of half as many pixels after each change, and what is there is drawn meanwhile.
# Scenes are exported by Blender's own thread; no thread of ours touches Blender's data.
import os
import shutil
import tempfile
import traceback
import weakref

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d
from mathutils import Matrix

from . import colour, exr, export, motion, scene_file
from .scrim_kit import Failure, frames, program

PIXELS = 0.5  # of the region's, along each side
POLL_SECONDS = 0.05


def of(engine):
    """The engine's preview, which ends when Blender drops the engine. Not by its __del__: at that time Blender has
    already taken away what Python could ask the engine for."""
    preview = Preview(engine)
    weakref.finalize(engine, preview.end)
    return preview


class Preview:
    def __init__(self, engine):
        self.engine = weakref.ref(engine)  # a strong one would keep it, and the child, until garbage is collected
        self.folder = tempfile.mkdtemp(prefix="scrim-viewport-")
        self.process = None
        self.polled = False
        self.number = 0
        self.view = None
        self.texture = None

    def end(self):
        self.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def stop(self):
        if self.process is None:
            return
        self.process.stop()
        self.process = None
        shutil.rmtree(os.path.dirname(self.picture), ignore_errors=True)

    def say(self, text):
        self.engine().update_stats("Scrim", text)

    def fail(self, text):
        """Shows an error. The picture goes: it is that of another scene."""
        self.texture = None
        self.say(text)

    def update(self, context, depsgraph):
        """Renders anew, since something changed."""
        self.stop()
        self.view = view_of(context)
        self.careful(self.begin, context, depsgraph)

    def careful(self, step, *arguments):
        """Calls a step, and shows its exceptions: Blender would only print them, and go on to draw the scene as it
        was."""
        try:
            step(*arguments)
        except Failure as failure:
            self.fail(str(failure))
        except Exception as error:
            traceback.print_exc()
            self.fail(f"{type(error).__name__}: {error}")

    def begin(self, context, depsgraph):
        scrim = scene_file.preferred_program()
        self.number += 1
        folder = os.path.join(self.folder, str(self.number))
        os.mkdir(folder)
        # Without warnings of what is not mapped: renders give them; here each turn of the view would.
        moves = motion.Moves(motion.matrices(depsgraph, Matrix()), export.FRAME)
        exporter = scene_file.exporter_of(folder, depsgraph, lambda text: None)
        content = exporter.scene_of_view(depsgraph, viewport_camera(context), moves)
        content["output"] = {"type": "float", "compression": "none"}
        self.picture = os.path.join(folder, "picture.exr")
        arguments = [scrim, "render", scene_file.write_scene(folder, content), "-o", frames.pattern_of(self.picture)]
        arguments += ["-q", "--quality", "draft", "--ocio", colour.config_file(bpy, folder)]
        self.process = program.Background(arguments, os.path.join(folder, "told"))
        self.say("...")
        if not self.polled:
            self.polled = True
            bpy.app.timers.register(self.poll, first_interval=POLL_SECONDS)

    def poll(self):
        """By a timer: asks for a redraw when the child has ended."""
        if self.process is not None and not self.process.has_ended():
            return POLL_SECONDS
        self.polled = False
        engine = self.engine()
        if engine is not None and self.process is not None:
            engine.tag_redraw()
        return None

    def draw(self, context, depsgraph):
        if self.view is not None and view_of(context) != self.view:
            self.update(context, depsgraph)
        if self.process is not None and self.process.has_ended():
            self.careful(self.take)
        if self.texture is None:
            return
        region = context.region
        gpu.state.blend_set("ALPHA_PREMULT")
        # Scene-linear: the viewport turns all that is drawn into the display's colours.
        draw_texture_2d(self.texture, (0, 0), region.width, region.height)
        gpu.state.blend_set("NONE")

    def take(self):
        """The picture of the child that has ended, as a texture."""
        ended = self.process.result()
        self.process = None
        if ended.returncode != program.Status.DONE:
            raise Failure(ended.reason)
        picture = exr.read(self.picture)
        left, top, right, bottom = picture.display_window
        width, height = right - left + 1, bottom - top + 1
        planes = [picture.region(c, left, top, width, height) for c in "RGBA"]
        pixels = np.ascontiguousarray(np.stack(planes, axis=-1)[::-1], np.float32)
        buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
        self.texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
        shutil.rmtree(os.path.dirname(self.picture), ignore_errors=True)
        self.say("draft")


def view_of(context):
    """Everything that the viewport's picture depends on beside the scene."""
    region, view = context.region, context.region_data
    return region.width, region.height, view.perspective_matrix.copy().freeze()


def viewport_camera(context):
    """The `camera` of a scene that sees what the viewport does."""
    region, view = context.region, context.region_data
    width = max(int(region.width * PIXELS), 1)
    height = max(int(region.height * PIXELS), 1)
    return camera_of_window(view.window_matrix, view.view_matrix.inverted(), width, height)


def camera_of_window(projection, matrix, width, height):
    """The `camera` of a scene. `projection`: OpenGL's matrix, whose first rows hold 1 / (half the width), 1 / (half the
    height), and the shift of the window."""
    out = {"matrix": export.rows(matrix), "resolution": [width, height]}
    side = -1 if projection[3][3] == 0 else 1
    if side < 0:
        out.update(focal_length=0.5 * float(projection[0][0]), aperture=1.0)
        moved = (projection[0][2], projection[1][2])
    else:
        out.update(type="orthographic", height=2 / float(projection[1][1]))
        moved = (-projection[0][3], -projection[1][3])
    out["shift"] = [0.5 * float(moved[0]), 0.5 * float(moved[1]) * height / width]
    return out
