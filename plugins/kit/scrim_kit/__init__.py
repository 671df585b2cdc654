# SPDX-License-Identifier: Apache-2.0
"""What Scrim's front ends (Blender, farm, OpenUSD) share, in pure Python from 3.10 on and without other packages.

The farm and the Python module import it as `scrim_kit`. Blender's add-on holds it as a package of its own, since
add-ons may not change where Python looks for packages; so modules of the kit import one another relatively.

    toml_text   scenes and overrides as TOML
    frames      ranges of frames, and file names with the frame in them
    program     the program `scrim` as a child process
    light_laws  lights of other programs in Scrim's units
    media       media of other programs in keys of a scene
    names       names for volumes, lights and meshes of a scene
    ply         meshes as files that a scene names
"""

from .failure import Failure

__all__ = ["Failure"]
