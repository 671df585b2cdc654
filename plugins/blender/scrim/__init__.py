# SPDX-License-Identifier: Apache-2.0
# Scrim as a render engine of Blender. Nothing of Blender is imported before it registers, so that the modules that map
# and write scenes can be used and tested without it.
import os

bl_info = {
    "name": "Scrim",
    "description": "Renders volumes with shadows and without noise",
    "author": "The Scrim authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render Engine",
    "category": "Render",
}


# The zip of the add-on (make_zip.py) holds the kit. In the source tree it is beside the other front ends.
_here = os.path.dirname(os.path.realpath(__file__))
if not os.path.isdir(os.path.join(_here, "scrim_kit")):
    __path__.append(os.path.join(_here, "..", "..", "kit"))


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
