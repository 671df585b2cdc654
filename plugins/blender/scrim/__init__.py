# SPDX-License-Identifier: Apache-2.0
# Scrim as a render engine of Blender. Nothing of Blender is imported before it registers, so that the modules that map
# and write scenes can be used and tested without it.
bl_info = {
    "name": "Scrim",
    "description": "Renders volumes with shadows and without noise",
    "author": "The Scrim authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render Engine",
    "category": "Render",
}


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
