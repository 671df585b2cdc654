# SPDX-License-Identifier: Apache-2.0
# The viewport in Blender's window: what is on the screen, and what becomes of the child.
#   blender --factory-startup --python viewport_test.py -- FOLDER [-k CHECK]
# FOLDER gets the pictures of the screen.
import os
import subprocess
import sys

import numpy as np
import scenes as s
import screen
from bpy_extras.view3d_utils import location_3d_to_region_2d
from screen import shot, ticks, until, view

bpy = s.bpy
from scrim import preview  # noqa: E402

WORDS = sys.argv[sys.argv.index("--") + 1 :]
FOLDER = WORDS[0]
SCRIM = os.environ["SCRIM"]
SMOKE = os.path.join(FOLDER, "ball.vdb")
said, previews = [], []

_of, _say = preview.of, preview.Preview.say


def of(engine):
    previews.append(_of(engine))
    return previews[-1]


def say(self, text):
    said.append(text)
    _say(self, text)


preview.of, preview.Preview.say = of, say


def scene(**volume):
    """A ball of smoke, lit from the camera's right; nothing in the viewport but it."""
    _, _, _, space = view()
    space.shading.type = "SOLID"
    os.environ["SCRIM"] = SCRIM
    made = s.cleared((400, 300))
    made.view_settings.view_transform = "Raw"
    s.volume(SMOKE, **{"Density": 4.0, **volume})
    s.light("SUN", (4, -1, 0), energy=8.0, angle=0.0)
    _, _, _, space = view()
    space.overlay.show_overlays = space.show_gizmo = False
    for name in ("show_region_toolbar", "show_region_ui", "show_region_header", "show_region_tool_header"):
        setattr(space, name, False)
    space.region_3d.view_perspective = "CAMERA"
    return made


def rendered():
    said.clear()
    view()[3].shading.type = "RENDERED"


def settled():
    """Waits until a picture is drawn, and nothing asks for another."""
    yield from until(lambda: said and said[-1] == "draft", f"a draft; it said {said}")
    quiet = 0
    while quiet < 4:
        quiet = quiet + 1 if said[-1] == "draft" and previews[-1].process is None else 0
        yield


def background(name):
    """What is there without the smoke, which is hidden and shown again."""
    thing = bpy.data.objects["volume"]
    thing.hide_viewport = True
    yield from until(lambda: said and said[-1].startswith("there is no Volume object"), "a word about it")
    yield from ticks(3)
    out = shot(FOLDER, name)
    said.clear()
    thing.hide_viewport = False
    yield from settled()
    return out


def frame():
    """Of the camera in the viewport: left, top, right, bottom in pixels."""
    _, _, region, space = view()
    camera = bpy.context.scene.camera
    corners = [
        location_3d_to_region_2d(region, space.region_3d, camera.matrix_world @ corner)
        for corner in camera.data.view_frame(scene=bpy.context.scene)
    ]
    x, y = [c.x for c in corners], [c.y for c in corners]
    return min(x), region.height - max(y), max(x), region.height - min(y)


def part(picture, box, size):
    """Means of the pixels in `size` columns and rows of a box."""
    xs, ys = np.linspace(box[0], box[2], size[0] + 1), np.linspace(box[1], box[3], size[1] + 1)
    xs, ys = xs.round().astype(int), ys.round().astype(int)
    return np.array([[picture[t:b, r:q].mean((0, 1)) for r, q in zip(xs, xs[1:])] for t, b in zip(ys, ys[1:])])


def smoke_is_drawn():
    """As the render has it, over the viewport's own background, in the display's colours."""
    made = scene(Color=(0.9, 0.6, 0.3))
    for transform in ("Raw", "Standard"):
        made.view_settings.view_transform = transform
        rendered()
        yield from settled()
        behind = yield from background(f"empty {transform}")
        seen = shot(FOLDER, f"smoke {transform}")
        size = (20, 15)
        box = frame()
        assert box[2] - box[0] > 200, box
        picture = s.render(os.path.join(FOLDER, "a.exr"))
        rgb, alpha = s.rgb(picture), picture["Combined.A"][:, :, None]
        straight = rgb / np.maximum(alpha, 1e-6)
        if transform == "Standard":
            straight = np.where(straight < 0.0031308, 12.92 * straight, 1.055 * straight ** (1 / 2.4) - 0.055)
        whole = (0, 0, rgb.shape[1], rgb.shape[0])
        expected = part(straight * alpha, whole, size) + (1 - part(alpha, whole, size)) * part(behind, box, size)
        got = part(seen, box, size)
        assert np.abs(expected - part(behind, box, size)).max() > 0.2
        # A draft of fewer pixels, and a box that is cut to whole ones: the ball's border is less sharp.
        assert np.abs(got - expected).max() < 0.06 and np.abs(got - expected).mean() < 0.008


def turning_turns_it():
    """Lit from the camera's right: seen from behind it is the left side that is bright."""
    scene()
    space = view()[3]
    sides = []
    for turn in (0.0, np.pi):
        space.region_3d.view_perspective = "PERSP"
        space.region_3d.view_location, space.region_3d.view_distance = (0, 0, 0), 4.5
        space.region_3d.view_rotation = (
            s.Matrix.Rotation(turn, 3, "Z").to_quaternion() @ s.looking((0, -4, 0), (0, 0, 0)).to_quaternion()
        )
        rendered() if not sides else said.clear()
        yield from settled()
        picture = shot(FOLDER, f"turned {turn:.0f}")
        height, width = picture.shape[:2]
        middle = picture[height // 2 - 20 : height // 2 + 20]
        sides.append([middle[:, width // 2 + x - 10 : width // 2 + x + 10].mean() for x in (-60, 60)])
    (left, right), (left_behind, right_behind) = sides
    assert right > 2 * left and left_behind > 2 * right_behind, sides


def it_is_where_blender_has_it():
    """The ball's middle is where Blender projects it: perspective, parallel, and a shifted camera."""
    made = scene()
    place = (0.4, 0.2, 0.3)
    bpy.data.objects["volume"].matrix_world = s.Matrix.Translation(place) @ s.Matrix.Scale(0.3, 4)
    rendered()
    space = view()[3]
    yield from settled()
    for kind in ("CAMERA", "PERSP", "ORTHO"):
        said.clear()
        space.region_3d.view_perspective = kind
        if kind == "CAMERA":
            made.camera.data.shift_x, made.camera.data.shift_y = 0.2, -0.1
        yield from settled()
        behind = yield from background("empty " + kind)
        there = np.abs(shot(FOLDER, "at " + kind) - behind).mean(-1)
        assert (there > 0.02).sum() > 300, kind
        rows, columns = np.nonzero(there > 0.02)
        _, _, region, _ = view()
        x, y = location_3d_to_region_2d(region, space.region_3d, place)
        got = 0.5 * (columns.min() + columns.max()), 0.5 * (rows.min() + rows.max())
        assert abs(got[0] - x) < 5 and abs(got[1] - (region.height - y)) < 5, (kind, got, (x, region.height - y))


def an_edited_light_changes_it():
    """By 2 more, and then by 4 more, which is twice as much: what is behind and seen through it takes no part."""
    scene(Color=(1, 1, 1))
    rendered()
    pictures = []
    for energy in (2.0, 4.0, 8.0):
        said.clear()
        bpy.data.lights["key"].energy = energy
        yield from settled()
        pictures.append(part(shot(FOLDER, f"energy {energy:.0f}"), frame(), (20, 15)))
    dim, middle, bright = pictures
    lit = middle - dim > 0.05
    assert lit.sum() > 30 and bright.max() < 0.99
    ratio = (bright - middle)[lit].sum() / (middle - dim)[lit].sum()
    assert 1.96 < ratio < 2.04, ratio


def program(text):
    path = os.path.join(FOLDER, "program")
    with open(path, "w") as file:
        file.write("#!/bin/sh\n" + text)
    os.chmod(path, 0o755)
    os.environ["SCRIM"] = path


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def children(name):
    """The process ids of all that were started by now."""
    if not os.path.exists(name):
        return []
    with open(name) as file:
        return [int(line) for line in file.read().split()]


def changes_and_another_shading_end_the_child():
    scene()
    name = os.path.join(FOLDER, "pids")
    program(f"echo $$ >> '{name}'; exec sleep 300\n")
    rendered()
    yield from until(lambda: children(name), "a child")
    yield from ticks(3)
    first, folder = children(name)[-1], previews[-1].folder
    assert alive(first) and os.path.isdir(folder)
    count = len(children(name))
    bpy.data.lights["key"].energy = 1.0
    yield from until(lambda: len(children(name)) > count, "a second child")
    yield from ticks(3)
    assert not alive(first) and alive(children(name)[-1])
    assert len(os.listdir(folder)) == 1  # the scene of the living one
    view()[3].shading.type = "SOLID"
    yield from until(lambda: not any(alive(pid) for pid in children(name)), "the end of the child")
    yield from until(lambda: not os.path.exists(folder), "the end of its folder")


def errors_are_said():
    """By the child, by its crash, before it is there; and then all is well again."""
    scene()
    for text, expected in (
        ("echo 'scrim: error: not today' >&2; exit 3\n", "not today"),
        ("kill -SEGV $$\n", "scrim was ended by signal 11"),
        ("echo 'scrim: warning: x' >&2; exit 0\n", "FileNotFoundError"),
        (None, "$SCRIM names '/nowhere/scrim' as the program scrim, which cannot be run"),
    ):
        if text:
            program(text)
        else:
            os.environ["SCRIM"] = "/nowhere/scrim"
        rendered()
        yield from until(lambda: said and said[-1].startswith(expected), f"'{expected}', but {said}")
        yield from ticks(5)
        assert previews[-1].texture is None and previews[-1].process is None
        view()[3].shading.type = "SOLID"
        yield from ticks(3)
    os.environ["SCRIM"] = SCRIM
    rendered()
    yield from settled()
    assert previews[-1].texture is not None


s.fresh()
subprocess.run([SCRIM, "make", "primitives", "resolution=48", "-o", SMOKE, "-q"], check=True, timeout=60)
bpy.context.preferences.view.show_splash = False
chosen = WORDS[2] if "-k" in WORDS else ""
CHECKS = (
    smoke_is_drawn,
    turning_turns_it,
    it_is_where_blender_has_it,
    an_edited_light_changes_it,
    changes_and_another_shading_end_the_child,
    errors_are_said,
)
screen.run([check for check in CHECKS if chosen in check.__name__], FOLDER, "viewport_test")
