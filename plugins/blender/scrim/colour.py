# SPDX-License-Identifier: Apache-2.0
# The colour config that the program gets: Blender's own, so that both know the same spaces and have the same working
# space. From Blender 5.0 on that is of a version which OpenColorIO 2.1 cannot read, and the working space is a file's
# choice; a small config with Blender's names stands in for it.
import os

OWN_IS_READ_UP_TO = (5, 0)
SPACES = ("Linear Rec.709", "Linear Rec.2020", "ACEScg")

# To ACES2065-1, with Bradford's adaptation of the white.
_MATRICES = {
    "Linear Rec.709": (
        (0.4396329820, 0.3829886870, 0.1773783310),
        (0.0897764431, 0.8134394286, 0.0967841284),
        (0.0175411704, 0.1115465492, 0.8709122804),
    ),
    "Linear Rec.2020": (
        (0.6790856347, 0.1577009146, 0.1632134506),
        (0.0460020031, 0.8590546730, 0.0949433239),
        (-0.0005739432, 0.0284677684, 0.9721061748),
    ),
    "ACEScg": (
        (0.6954522414, 0.1406786965, 0.1638690622),
        (0.0447945634, 0.8596711185, 0.0955343182),
        (-0.0055258826, 0.0040252103, 1.0015006723),
    ),
}


def _matrix(name):
    numbers = []
    for row in _MATRICES[name]:
        numbers += [*row, 0]
    return f"!<MatrixTransform> {{matrix: {[*numbers, 0, 0, 0, 1]}}}"


def _space(name, body):
    return f"  - !<ColorSpace>\n    name: {name}\n    {body}\n"


def config_text(working):
    """Of OpenColorIO 2.0, with Blender's names for its spaces."""
    curve = "!<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}"
    srgb = f"!<GroupTransform> {{children: [{curve}, {_matrix('Linear Rec.709')}]}}"
    spaces = [_space("ACES2065-1", "isdata: false"), _space("Non-Color", "isdata: true")]
    spaces += [_space(name, f"to_scene_reference: {_matrix(name)}") for name in SPACES]
    spaces.append(_space("sRGB", f"to_scene_reference: {srgb}"))
    return (
        "ocio_profile_version: 2\n\nroles:\n"
        f"  aces_interchange: ACES2065-1\n  data: Non-Color\n  default: Non-Color\n  scene_linear: {working}\n\n"
        "displays:\n  sRGB:\n    - !<View> {name: Standard, colorspace: sRGB}\n\ncolorspaces:\n" + "\n".join(spaces)
    )


def config_file(bpy, folder):
    """The path of the config, which may be written into `folder`."""
    named = os.environ.get("BLENDER_OCIO") or os.environ.get("OCIO")
    if named:
        return named
    if bpy.app.version < OWN_IS_READ_UP_TO:
        # Beside the program, or where a distribution puts it.
        return os.path.join(bpy.utils.system_resource("DATAFILES", path="colormanagement"), "config.ocio")
    path = os.path.join(folder, "config.ocio")
    with open(path, "w", encoding="utf-8") as file:
        file.write(config_text(working_space(bpy)))
    return path


def working_space(bpy):
    chosen = getattr(getattr(bpy.data, "colorspace", None), "working_space", SPACES[0])
    return chosen if chosen in SPACES else SPACES[0]
