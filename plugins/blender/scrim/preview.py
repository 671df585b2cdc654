# SPDX-License-Identifier: Apache-2.0
# The viewport: a child renders a draft of half as many pixels after each change, and what is there is drawn meanwhile.
# Scenes are exported by Blender's own thread; no thread of ours touches Blender's data.
import os
import shutil
import tempfile

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d
from mathutils import Matrix

from . import child, colour, exr, export, motion

PIXELS = 0.5  # of the region's, along each side
POLL_SECONDS = 0.05


class Preview:
    def __init__(self, engine):
        self.engine = engine
        self.folder = tempfile.mkdtemp(prefix="scrim-viewport-")
        self.process = None
        self.number = 0
        self.view = None
        self.texture = None

    def end(self):
        if self.process is not None:
            child.stop(self.process)
            self.process = None
        shutil.rmtree(self.folder, ignore_errors=True)

    def update(self, context, depsgraph):
        """Starts anew: something changed."""
        if self.process is not None:
            child.stop(self.process)
            self.process = None
        self.view = view_of(context)
        try:
            self.begin(context, depsgraph)
        except child.Failure as failure:
            self.engine.update_stats("Scrim", str(failure))

    def begin(self, context, depsgraph):
        from . import engine

        self.number += 1
        folder = os.path.join(self.folder, str(self.number))
        os.mkdir(folder)
        program = child.find_program(engine.preference())
        # What is not mapped is said by renders; here it would be said at every turn of the view.
        moves = motion.Moves(motion.matrices(depsgraph, Matrix()), export.FRAME)
        exporter = export.Exporter(folder, depsgraph.scene.scrim, lambda text: None, engine.abspath)
        content = exporter.scene_of_view(depsgraph, viewport_camera(context), moves)
        content["output"] = {"type": "float", "compression": "none"}
        self.picture = os.path.join(folder, "picture.exr")
        arguments = [program, "render", engine.write_scene(folder, content), "-o", self.picture, "-q"]
        self.process = child.start(arguments + ["--quality", "draft", "--ocio", colour.config_file(bpy, folder)])
        bpy.app.timers.register(self.poll, first_interval=POLL_SECONDS)

    def poll(self):
        """By a timer: asks for a redraw when the child has ended."""
        if self.process is None:
            return None
        if self.process.poll() is None:
            return POLL_SECONDS
        self.engine.tag_redraw()
        return None

    def draw(self, context, depsgraph):
        if self.view is not None and view_of(context) != self.view:
            self.update(context, depsgraph)
        if self.process is not None and self.process.poll() is not None:
            self.take()
        if self.texture is None:
            return
        region = context.region
        gpu.state.blend_set("ALPHA_PREMULT")
        self.engine.bind_display_space_shader(depsgraph.scene)
        draw_texture_2d(self.texture, (0, 0), region.width, region.height)
        self.engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")

    def take(self):
        """The picture of the child that has ended, as a texture."""
        _, told = self.process.communicate()
        status, self.process = self.process.returncode, None
        if status != 0:
            text = child.reason(status, told.decode(errors="replace").splitlines())
            self.engine.update_stats("Scrim", text)
            return
        picture = exr.read(self.picture)
        left, top, right, bottom = picture.display_window
        width, height = right - left + 1, bottom - top + 1
        planes = [picture.region(c, left, top, width, height) for c in "RGBA"]
        pixels = np.ascontiguousarray(np.stack(planes, axis=-1)[::-1], np.float32)
        buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
        self.texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
        shutil.rmtree(os.path.dirname(self.picture), ignore_errors=True)
        self.engine.update_stats("Scrim", "draft")


def view_of(context):
    """What the viewport's picture depends on beside the scene."""
    region, view = context.region, context.region_data
    return region.width, region.height, view.perspective_matrix.copy().freeze()


def viewport_camera(context):
    """The `camera` of a scene that sees what the viewport does."""
    region, view = context.region, context.region_data
    width = max(int(region.width * PIXELS), 1)
    height = max(int(region.height * PIXELS), 1)
    return camera_of_window(view.window_matrix, view.view_matrix.inverted(), width, height)


def camera_of_window(projection, matrix, width, height):
    """`projection`: OpenGL's. Its first rows hold one over half the width and height, and how far the window moves."""
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
