# SPDX-License-Identifier: Apache-2.0
# The scene of a depsgraph in a file for the program, and the program: what the engine, its viewport and the plan share.
import os

import bpy

from . import export
from .program_path import program_path
from .scrim_kit import toml_text


def preferred_program():
    """The path of the program that the add-on's preferences name, else as `program_path`. Raises Failure."""
    addon = bpy.context.preferences.addons.get(__package__)
    return program_path(addon.preferences.program if addon and addon.preferences else "")


def abspath(path, library):
    return bpy.path.abspath(path, library=library)


def exporter_of(folder, depsgraph, warn):
    return export.Exporter(folder, depsgraph.scene.scrim, warn, abspath, bpy.app.version)


def export_scene(folder, depsgraph, warn, camera, moves):
    """(scene, light passes) with `camera` = (object, shift along x)."""
    exporter = exporter_of(folder, depsgraph, warn)
    return exporter.scene(depsgraph, camera, moves), exporter.light_passes


def write_scene(folder, scene):
    """The path of the file in `folder` that holds the scene."""
    path = os.path.join(folder, "scene.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(toml_text.document({"scene_version": 2, **scene}))
    return path
