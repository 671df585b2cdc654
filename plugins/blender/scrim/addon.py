# SPDX-License-Identifier: Apache-2.0
# What is registered: the scene's properties, preferences, panels, and the operator that shows a plan.
import os
import shutil
import tempfile

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import colour, engine, export, motion, scene_file
from .scrim_kit import Failure, program

PLAN_SECONDS = 60


class ScrimSettings(bpy.types.PropertyGroup):
    quality: EnumProperty(
        name="Quality",
        description="How accurate the picture is: about 3, 1, 0.3 or 0.1 % of error against brute force",
        items=[(name.upper(), name.capitalize(), "") for name in ("draft", "standard", "high", "ultra")],
        default="STANDARD",
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="In place of the quality: the error (relative RMSE) to stay below, which is measured. 0: none",
        min=0.0,
        max=1.0,
        precision=4,
    )
    verify: IntProperty(
        name="Verify Pixels",
        description="Compare this many pixels with the brute-force reference, and report the error. 0: none",
        min=0,
        soft_max=1000,
    )
    scattering: EnumProperty(
        name="Scattering",
        description="How often light scatters",
        items=[
            ("AUTO", "As Needed", "Full for materials that scatter 60 % or more of what they take, else once"),
            ("SINGLE", "Once", "As Cycles with 0 volume bounces"),
            ("OCTAVES", "Octaves", "Once, with the look of more"),
            ("FULL", "Full", "As often as it does: clouds, and smoke that fire lights"),
        ],
    )
    solids: EnumProperty(
        name="Solids",
        description="Effect of meshes on volumes; another engine renders them",
        items=[
            ("HOLDOUT", "Hide and Shadow", "Hide what is behind them, and throw shadows into volumes"),
            ("SHADOW", "Shadow", "Throw shadows into volumes"),
            ("NONE", "None", "Are not there"),
        ],
    )
    overrides: StringProperty(
        name="Overrides",
        description="More values of the scene, in the form of --set: render.texel=0.5 render.antialias=2",
    )
    pass_lights: BoolProperty(name="Lights", description="A pass for each light")
    pass_transmittance: BoolProperty(name="Transmittance", description="Fraction of the background that is visible")
    pass_albedo: BoolProperty(name="Albedo", description="A pass of the media's albedo")


class ScrimPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program", description="The program scrim (default: $SCRIM, or else the one in PATH)", subtype="FILE_PATH"
    )

    def draw(self, context):
        self.layout.prop(self, "program")


def plan_text(context):
    """What `scrim plan` says of the scene as it is."""
    scrim = scene_file.preferred_program()
    depsgraph = context.evaluated_depsgraph_get()
    scene = depsgraph.scene
    if scene.camera is None:
        raise Failure("the scene has no camera")
    camera = scene.camera.evaluated_get(depsgraph)
    folder = tempfile.mkdtemp(prefix="scrim-plan-")
    try:
        moves = motion.Moves(motion.matrices(depsgraph, camera.matrix_world), export.FRAME)
        said = []
        content, _ = scene_file.export_scene(folder, depsgraph, said.append, (camera, camera.data.shift_x), moves)
        written = scene_file.write_scene(folder, content)
        arguments = [scrim, "plan", written, "--ocio", colour.config_file(bpy, folder)]
        plan = program.ask(arguments, PLAN_SECONDS).output
        notes = "".join(f"not mapped: {text}\n" for text in said)
        return notes + plan.replace(folder + os.sep, "")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class SCRIM_OT_plan(bpy.types.Operator):
    bl_idname = "scrim.plan"
    bl_label = "Show Plan"
    bl_description = "What the scene needs: effects on and off with the reason, sheets, memory, in a text"

    def execute(self, context):
        try:
            text = plan_text(context)
        except Failure as failure:
            self.report({"ERROR"}, f"Scrim: {failure}")
            return {"CANCELLED"}
        block = bpy.data.texts.get("Scrim plan") or bpy.data.texts.new("Scrim plan")
        block.from_string(text)
        self.report({"INFO"}, "the plan is in the text 'Scrim plan'")
        return {"FINISHED"}


class ScrimPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {"SCRIM"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class SCRIM_PT_render(ScrimPanel, bpy.types.Panel):
    bl_label = "Scrim"
    bl_context = "render"

    def draw(self, context):
        layout, settings = self.layout, context.scene.scrim
        layout.use_property_split = True
        column = layout.column()
        column.active = settings.tolerance <= 0
        column.prop(settings, "quality")
        for name in ("tolerance", "verify", "scattering", "solids", "overrides"):
            layout.prop(settings, name)
        if engine.last_run["text"]:
            layout.label(text=engine.last_run["text"])
        layout.operator(SCRIM_OT_plan.bl_idname)


class SCRIM_PT_passes(ScrimPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout, settings = self.layout, context.scene.scrim
        layout.use_property_split = True
        layout.prop(context.view_layer, "use_pass_z", text="Depth")
        for name in ("pass_lights", "pass_transmittance", "pass_albedo"):
            layout.prop(settings, name)


CLASSES = (
    ScrimSettings,
    ScrimPreferences,
    SCRIM_OT_plan,
    SCRIM_PT_render,
    SCRIM_PT_passes,
    engine.ScrimRenderEngine,
)
# Panels of Blender's own that hold for this engine as they do for its own: film, lights, materials, volumes.
_NOT_OURS = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_freestyle"}


def shared_panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and panel.__name__ not in _NOT_OURS:
            yield panel


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.scrim = PointerProperty(type=ScrimSettings)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add("SCRIM")


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard("SCRIM")
    del bpy.types.Scene.scrim
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
