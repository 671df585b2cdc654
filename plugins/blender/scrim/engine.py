# SPDX-License-Identifier: Apache-2.0
# The render engine: depsgraph -> scene -> the program -> passes.
import json
import os
import shlex
import shutil
import tempfile
import traceback

import bpy
import numpy as np

from . import colour, exr, export, formulae, motion, preview, scene_file, so_far
from .scrim_kit import Failure, frames, program

SHUTTER_TIMES = 5
FAR = 1e10  # the depth that Blender writes where nothing is
# Passes beside Combined and Depth: property, name in Blender, channels in the EXR, name of the layer
EXTRA = (
    ("pass_transmittance", "Transmittance", ("transmittance.R", "transmittance.G", "transmittance.B"), "transmittance"),
    ("pass_albedo", "Albedo", ("albedo.R", "albedo.G", "albedo.B"), "albedo"),
)
# The summary of the last run, for the panel. Properties of the scene cannot be written while it is rendered.
last_run = {"text": ""}


def light_pass(name):
    return f"Light {name}"[:60]


def arguments_for(scene, folder):
    """Options of the program that the scene's settings make."""
    settings = scene.scrim
    out = ["--ocio", colour.config_file(bpy, folder), "--frames", str(export.FRAME)]
    if settings.tolerance > 0:
        out += ["--tolerance", str(settings.tolerance)]
    else:
        out += ["--quality", settings.quality.lower()]
    if settings.verify > 0:
        out += ["--verify", str(settings.verify)]
    try:
        changes = shlex.split(settings.overrides)
    except ValueError as error:
        raise Failure(f"the overrides '{settings.overrides}' cannot be read: {error}") from None
    for change in changes:
        out += ["--set", change]
    if scene.render.threads_mode == "FIXED":
        out += ["--threads", str(scene.render.threads)]
    return out


def layers_for(scene, view_layer):
    settings = scene.scrim
    out = ["light"] if settings.pass_lights else []
    out += ["depth"] if view_layer.use_pass_z else []
    return out + [layer for prop, _, _, layer in EXTRA if getattr(settings, prop)]


def output_table(scene, layers):
    fps = scene.render.fps / scene.render.fps_base
    return {"type": "float", "compression": "none", "layers": layers, "fps": float(fps)}


class ScrimRenderEngine(bpy.types.RenderEngine):
    bl_idname = "SCRIM"
    bl_label = "Scrim"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.preview = None

    def update_render_passes(self, scene, renderlayer):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        if renderlayer.use_pass_z:
            self.register_pass(scene, renderlayer, "Depth", 1, "Z", "VALUE")
        for prop, name, _, _ in EXTRA:
            if getattr(scene.scrim, prop):
                self.register_pass(scene, renderlayer, name, 3, "RGB", "COLOR")
        if scene.scrim.pass_lights:
            names = [thing.name for thing in scene.objects if thing.type == "LIGHT"]
            for name in names + (["World"] if scene.world else []):
                self.register_pass(scene, renderlayer, light_pass(name), 3, "RGB", "COLOR")

    # An exception that leaves this would end as a black picture and success.
    def render(self, depsgraph):
        folder = tempfile.mkdtemp(prefix="scrim-blender-")
        try:
            self.render_in(folder, depsgraph)
        except program.Cancelled:
            pass
        except Failure as failure:
            self.report({"ERROR"}, f"Scrim: {failure}")
        except Exception as error:
            traceback.print_exc()
            self.report({"ERROR"}, f"Scrim: {type(error).__name__}: {error}")
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def warn(self, text):
        self.report({"WARNING"}, f"Scrim: {text}")

    def render_in(self, folder, depsgraph):
        scene = depsgraph.scene
        scrim = scene_file.preferred_program()
        self.update_stats("", "Scrim: writing the scene")
        camera = self.camera_override or scene.camera
        if camera is None:
            raise Failure("the scene has no camera")
        camera = camera.evaluated_get(depsgraph)
        moves = self.moves(depsgraph, camera)
        shifted = (camera, self.camera_shift_x(camera))
        content, passes = scene_file.export_scene(folder, depsgraph, self.warn, shifted, moves)
        content["output"] = output_table(scene, layers_for(scene, depsgraph.view_layer_eval))
        width, height = export.resolution(scene.render)
        x0, y0, wide, high = self.window(scene.render, width, height)
        picture = os.path.join(folder, "picture.exr")
        stats = os.path.join(folder, "stats.json")
        arguments = [scrim, "render", scene_file.write_scene(folder, content), "-o", frames.pattern_of(picture)]
        arguments += arguments_for(scene, folder) + ["--stats", stats, "--progress", "json"]
        top = height - y0 - high
        if (wide, high) != (width, height):
            arguments += ["--crop", f"{x0},{top},{x0 + wide},{top + high}"]
        if self.is_watched():
            seen = so_far.SoFar()
            try:
                self.run([*arguments, "--display-server", seen.address], stats,
                         lambda: self.show(seen.take(), (wide, high), depsgraph))
            finally:
                seen.close()
        else:
            self.run(arguments, stats)
        self.put(exr.read(picture), (x0, top, wide, high), passes, depsgraph)

    def is_watched(self):
        return not bpy.app.background

    def show(self, pixels, size, depsgraph):
        """Shows the picture so far, if there is one."""
        wide, high = size
        if pixels is None or pixels.shape != (high, wide, 4):
            return
        result = self.begin_result(0, 0, wide, high, layer=depsgraph.view_layer_eval.name)
        fill(result.layers[0].passes["Combined"], pixels[::-1])
        self.end_result(result)

    def window(self, render, width, height):
        """What is rendered, in pixels: x0, y0 from the bottom, width, height."""
        if not render.use_border:
            return 0, 0, width, height
        return formulae.border(
            width, height, render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y
        )

    def moves(self, depsgraph, camera):
        """Matrices of the frame, and of times while the shutter is open. Leaves the frame as it was."""
        render, name = depsgraph.scene.render, camera.name_full
        matrix = self.camera_model_matrix(camera)
        now = motion.matrices(depsgraph, matrix)
        if not render.use_motion_blur or render.motion_blur_shutter <= 0:
            return motion.Moves(now, export.FRAME)
        shutter = formulae.shutter(render.motion_blur_shutter, export.shutter_position(depsgraph.scene))
        frame = depsgraph.scene.frame_current + depsgraph.scene.frame_subframe
        samples = []
        for i in range(SHUTTER_TIMES):
            time = shutter[0] + (shutter[1] - shutter[0]) * i / (SHUTTER_TIMES - 1)
            self.set_time(frame + time)
            moved = next((it for it in depsgraph.scene.objects if it.name_full == name), camera)
            samples.append((time, motion.matrices(depsgraph, self.camera_model_matrix(moved.evaluated_get(depsgraph)))))
        self.set_time(frame)
        return motion.Moves(now, export.FRAME, samples, shutter)

    def set_time(self, time):
        whole = int(np.floor(time))
        self.frame_set(whole, time - whole)

    def run(self, arguments, stats, watch=lambda: None):
        """Runs the program, which writes its statistics into the file `stats`, and shows what it tells. Calls `watch`
        twenty times a second."""

        def progress(part):
            self.update_progress(part)
            self.update_stats("", f"Scrim: {100 * part:.0f} %")

        def cancelled():
            watch()
            return self.cancelled()

        ended = program.run(arguments, progress, cancelled)
        for text in ended.warnings:
            self.warn(text)
        if ended.status not in (program.Status.DONE, program.Status.INACCURATE):
            raise Failure(ended.reason)
        if ended.status == program.Status.INACCURATE:
            self.warn(ended.reason)
        with open(stats, encoding="utf-8") as file:
            frame = json.load(file)[0]
        last_run["text"] = frame["summary"]
        self.update_stats("", f"Scrim: {frame['summary']}")
        peak = frame["peak_memory_bytes"] / 2**20
        self.update_memory_stats(memory_used=peak, memory_peak=peak)

    def cancelled(self):
        return self.test_break()

    def put(self, picture, window, light_names, depsgraph):
        """The picture's channels into Blender's passes, whose rows begin at the bottom."""
        scene, layer = depsgraph.scene, depsgraph.view_layer_eval
        x0, top, wide, high = window
        wanted = {"Combined": (("R", "G", "B", "A"), 0.0)}
        for prop, name, channels, _ in EXTRA:
            if getattr(scene.scrim, prop):
                wanted[name] = (channels, 1.0 if name == "Transmittance" else 0.0)
        if scene.scrim.pass_lights:
            for inside, outside in light_names.items():
                wanted[light_pass(outside)] = (tuple(f"light.{inside}.{c}" for c in "RGB"), 0.0)
        for name, (channels, _) in wanted.items():
            if name != "Combined":
                self.add_pass(name, 3, "RGB", layer=layer.name)
        result = self.begin_result(0, 0, wide, high, layer=layer.name)
        passes = result.layers[0].passes
        if layer.use_pass_z:
            wanted["Depth"] = (("Z",), FAR)
        for name, (channels, outside) in wanted.items():
            target = passes.get(name)
            if target is None:
                continue
            held = [c if c in picture.channels else grey(c, picture.channels) for c in channels]
            planes = [picture.region(c, x0, top, wide, high, outside) for c in held]
            if name == "Depth":
                planes = [np.where((planes[0] > 0) & (planes[0] < FAR), planes[0], FAR)]
            fill(target, np.stack(planes, axis=-1)[::-1])
        self.end_result(result)

    # The viewport

    def view_update(self, context, depsgraph):
        if self.preview is None:
            self.preview = preview.of(self)
        self.preview.update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        if self.preview is None:
            self.preview = preview.of(self)
        self.preview.draw(context, depsgraph)


def grey(name, channels):
    """The channel in place of `name`, in a layer that has one channel for all colours."""
    base = name.rpartition(".")[0]
    for candidate in (base, base + ".Y", base + ".A"):
        if candidate in channels:
            return candidate
    raise Failure(f"the picture has no channel '{name}', but {', '.join(sorted(channels))}")


def fill(target, pixels):
    pixels = np.ascontiguousarray(pixels, np.float32)
    try:
        target.rect.foreach_set(pixels.reshape(-1))
    except TypeError:  # before Blender 4.2
        target.rect.foreach_set(pixels.reshape(-1, pixels.shape[-1]))
