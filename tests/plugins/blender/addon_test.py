# SPDX-License-Identifier: Apache-2.0
# The add-on in bpy: pictures, passes and errors as Blender gets them. Laws are compared with Cycles in compare_test.py.
import math
import os
import subprocess
import sys

import numpy as np
import pytest
import scenes as s
from scrim import addon, colour, engine

bpy = s.bpy
SCRIM = os.environ["SCRIM"]


@pytest.fixture(scope="session")
def smoke(tmp_path_factory):
    path = tmp_path_factory.mktemp("smoke") / "ball.vdb"
    make(path)
    return path


def make(path, *parameters):
    words = parameters or ("resolution=32", "shape=ball")
    subprocess.run([SCRIM, "make", "noise", *words, "-o", str(path), "-q"], check=True, timeout=60)


@pytest.fixture
def said(monkeypatch):
    """What the add-on warns of."""
    lines = []
    monkeypatch.setattr(engine.ScrimRenderEngine, "warn", lambda self, text: lines.append(text))
    return lines


def scene_with(smoke, **inputs):
    scene = s.fresh()
    s.volume(smoke, **{"Density": 4.0, **inputs})
    s.light("SUN", (3, -2, 3), energy=4.0, angle=0.0)
    return scene


def test_light_passes_add_up_to_the_picture(smoke, tmp_path):
    scene = scene_with(smoke)
    s.light("POINT", (-1, -1, 1), name="Fill 2", energy=30.0, shadow_soft_size=0.0)  # not each Blender has this default
    s.sky((0.05, 0.1, 0.2))
    scene.scrim.pass_lights, scene.scrim.overrides = True, "light.World.samples=20"
    got = s.render(tmp_path / "a.exr")
    total = sum(s.rgb(got, name) for name in ("Light key", "Light Fill 2", "Light World"))
    beauty = s.rgb(got)
    assert beauty.max() > 0.01
    assert np.abs(total - beauty).max() < 1e-4 * beauty.max()
    assert all(s.rgb(got, name).max() > 0.001 for name in ("Light key", "Light Fill 2", "Light World"))


def test_depth_and_transmittance(smoke, tmp_path):
    scene = scene_with(smoke)
    scene.view_layers[0].use_pass_z = True
    scene.scrim.pass_transmittance = True
    got = s.render(tmp_path / "a.exr")
    depth, alpha = got["Depth.Z"], got["Combined.A"]
    assert (depth[alpha == 0] == np.float32(1e10)).all() and (alpha == 0).any()
    middle = depth[alpha > 0.5]
    # The ball is about 4 from the camera, and 0.9 in radius.
    assert len(middle) and 2.9 < middle.min() and middle.max() < 5.1
    assert np.abs(1 - s.rgb(got, "Transmittance").mean(-1) - alpha).max() < 1e-3


def test_the_picture_is_shown_while_it_is_rendered(smoke, tmp_path, monkeypatch):
    scene = scene_with(smoke)
    scene.scrim.overrides = "render.texel=0.1 render.sheet_thickness=0.05"  # for seconds, in which there is news
    scene.render.use_border, scene.render.use_crop_to_border = True, True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 1
    alone = s.rgb(s.render(tmp_path / "a.exr"))
    shown = []
    show = engine.ScrimRenderEngine.show

    def recorded(self, pixels, size, depsgraph):
        show(self, pixels, size, depsgraph)
        if pixels is not None:
            shown.append(pixels)

    monkeypatch.setattr(engine.ScrimRenderEngine, "is_watched", lambda self: True)
    monkeypatch.setattr(engine.ScrimRenderEngine, "show", recorded)
    watched = s.rgb(s.render(tmp_path / "b.exr"))
    assert np.array_equal(watched, alone)
    # Light is added from front to back.
    assert all(0 < seen[..., :3].max() and (seen[..., :3] <= alone + 1e-3 * alone.max()).all() for seen in shown)
    assert shown and shown[0].shape[:2] == alone.shape[:2]


@pytest.mark.parametrize("crop", [False, True])
def test_a_border_is_a_part_of_the_picture(smoke, tmp_path, crop):
    scene = scene_with(smoke)
    whole = s.rgb(s.render(tmp_path / "a.exr"))
    render = scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.4, 0.8
    part = s.rgb(s.render(tmp_path / "b.exr"))
    # Rows of Blender's border count from the bottom: 25 to 51 of 64.
    top, bottom, left, right = 64 - 51, 64 - 25, 16, 48
    assert whole[top:bottom, left:right].max() > 0.01
    if crop:
        assert part.shape == (26, 32, 3)
    else:
        outside = part.copy()
        outside[top:bottom, left:right] = 0
        assert outside.max() == 0
        part = part[top:bottom, left:right]
    assert np.array_equal(part, whole[top:bottom, left:right])


def test_instances_and_frames_of_sequences(smoke, tmp_path):
    scene = scene_with(smoke)
    thing = bpy.data.objects["volume"]
    alone = s.render(tmp_path / "a.exr")["Combined.A"]
    bpy.data.objects.remove(thing)
    # An object whose collection holds the volume, shown twice
    folder = tmp_path / "seq ####"
    folder.mkdir()
    for frame, size in ((1, 1.0), (2, 0.5)):
        make(folder / f"ball_{frame:04}.vdb", "resolution=32", "shape=ball", f"size={2 * size}")
    made = s.volume(folder / "ball_0001.vdb", Density=4.0)
    made.data.is_sequence, made.data.frame_duration, made.data.frame_start = True, 2, 1
    collection = bpy.data.collections.new("balls")
    collection.objects.link(made)
    scene.collection.objects.unlink(made)
    for x in (-0.6, 0.6):
        empty = s.place("empty", None, s.Matrix.Translation((x, 0, 0)))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
    pictures = []
    for frame in (1, 2):
        scene.frame_set(frame)
        pictures.append(s.render(tmp_path / f"b{frame}.exr")["Combined.A"])
    first, second = (picture.sum() for picture in pictures)
    assert 1.2 * alone.sum() < first < 2.5 * alone.sum()
    assert second < 0.6 * first


def test_volumes_of_geometry_nodes_are_written(tmp_path, said):
    scene = s.fresh()
    s.light("SUN", (3, -2, 3), energy=4.0, angle=0.0)
    mesh = bpy.data.meshes.new("cube")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    thing = s.place("cube", mesh)
    tree = bpy.data.node_groups.new("make", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:  # before Blender 4.0
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    cube, end = tree.nodes.new("GeometryNodeVolumeCube"), tree.nodes.new("NodeGroupOutput")
    cube.inputs["Density"].default_value = 2.0
    for socket in ("Resolution X", "Resolution Y", "Resolution Z"):
        cube.inputs[socket].default_value = 16
    cube.inputs["Min"].default_value, cube.inputs["Max"].default_value = (-0.5,) * 3, (0.5,) * 3
    tree.links.new(cube.outputs[0], end.inputs[0])
    thing.modifiers.new("make", "NODES").node_group = tree
    alpha = s.render(tmp_path / "a.exr")["Combined.A"]
    assert alpha[32, 32] == pytest.approx(1 - math.exp(-2), abs=0.12)
    assert not said, scene.name


def test_what_is_not_mapped_is_named_once(smoke, tmp_path, said):
    scene = scene_with(smoke)
    s.light("AREA", (2, -2, 2), name="soft", energy=10, spread=1.0, size=0.1)
    other = s.volume(smoke, name="other", Density_Attribute="smoke")
    other.data.materials.append(None)
    s.render(tmp_path / "a.exr")
    assert sorted(said) == [
        "volume 'other' is not rendered: Scrim does not know a density that is the same everywhere; link a grid to it",
    ]


def fails(tmp_path):
    """The text of a render that has to fail, and leave no file."""
    target = tmp_path / "failed.exr"
    with pytest.raises(RuntimeError) as raised:
        s.render(target)
    assert not target.exists()
    return str(raised.value)


def test_a_scene_without_volumes_fails(tmp_path):
    s.fresh()
    assert "Scrim: there is no Volume object that Scrim can render in this view layer" in fails(tmp_path)


def test_the_programs_errors_are_blenders(smoke, tmp_path):
    scene_with(smoke).scrim.overrides = "render.texel=1000"
    assert "'texel' is 1000" in fails(tmp_path)
    bpy.context.scene.scrim.overrides = "'"
    assert "Scrim: the overrides ''' cannot be read: No closing quotation" in fails(tmp_path)


def test_a_missing_program_fails(smoke, tmp_path, monkeypatch):
    scene_with(smoke)
    monkeypatch.setenv("SCRIM", "/nowhere/scrim")
    assert "Scrim: $SCRIM names '/nowhere/scrim' as the program scrim, which cannot be run" in fails(tmp_path)


def test_a_crash_of_the_program_is_not_blenders(smoke, tmp_path, monkeypatch):
    scene_with(smoke)
    program = tmp_path / "scrim"
    program.write_text("#!/bin/sh\nkill -SEGV $$\n")
    program.chmod(0o755)
    monkeypatch.setenv("SCRIM", str(program))
    assert "Scrim: scrim was ended by signal 11" in fails(tmp_path)


def test_an_error_of_ours_fails(smoke, tmp_path, monkeypatch):
    scene_with(smoke)
    monkeypatch.setattr(engine.exr, "read", lambda path: 1 / 0)
    assert "Scrim: ZeroDivisionError: division by zero" in fails(tmp_path)


def test_cancelling_ends_the_program(smoke, tmp_path, monkeypatch):
    scene_with(smoke)
    program = tmp_path / "scrim"
    program.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/pid; exec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setenv("SCRIM", str(program))
    pid = tmp_path / "pid"
    monkeypatch.setattr(engine.ScrimRenderEngine, "cancelled", lambda self: pid.exists() and pid.stat().st_size > 0)
    s.bpy.ops.render.render()
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_a_tolerance_is_measured(smoke, tmp_path):
    scene_with(smoke).scrim.tolerance = 0.02
    s.render(tmp_path / "a.exr")
    assert "error" in engine.last_run["text"] and "%" in engine.last_run["text"]


def test_a_missed_tolerance_is_said_and_the_picture_kept(smoke, tmp_path, said):
    scene_with(smoke).scrim.tolerance = 1e-7
    assert s.rgb(s.render(tmp_path / "a.exr")).max() > 0.01
    assert any("more than the tolerance" in line for line in said), said


def test_solids_hold_out(smoke, tmp_path):
    scene = scene_with(smoke)
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-3, -1.5, -3), (0, -1.5, -3), (0, -1.5, 3), (-3, -1.5, 3)], [], [(0, 1, 2, 3)])
    s.place("plane", mesh)
    hidden = s.render(tmp_path / "a.exr")["Combined.A"]
    scene.scrim.solids = "NONE"
    free = s.render(tmp_path / "b.exr")["Combined.A"]
    assert hidden[:, :32].max() == 0 < free[:, :32].max()
    assert np.abs(hidden - free)[:, 33:].max() < 1e-4


def test_a_plan_is_shown(smoke):
    scene_with(smoke)
    assert bpy.ops.scrim.plan() == {"FINISHED"}
    text = bpy.data.texts["Scrim plan"].as_string()
    assert "shadows" in text and "of 'key'" in text
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="Scrim: the scene has no camera"):
        bpy.ops.scrim.plan()


def test_viewport_cameras_see_what_blenders_do():
    """A projection of OpenGL, made from a lens, becomes that lens."""
    pytest.importorskip("gpu")
    from scrim import preview

    scene = s.fresh((80, 60))
    camera = scene.camera
    camera.data.shift_x, camera.data.shift_y = 0.1, -0.2
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = camera.calc_matrix_camera(depsgraph, x=80, y=60)
    got = preview.camera_of_window(projection, camera.matrix_world, 80, 60)
    assert got["focal_length"] / got["aperture"] == pytest.approx(50 / 36)
    assert got["shift"] == pytest.approx([0.1, -0.2], abs=1e-6)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4
    projection = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=80, y=60)
    got = preview.camera_of_window(projection, camera.matrix_world, 80, 60)
    assert got["height"] == pytest.approx(3) and got["shift"] == pytest.approx([0.1, -0.2], abs=1e-6)


@pytest.mark.parametrize("working", colour.SPACES)
def test_the_small_config_has_the_working_space(tmp_path, working):
    """White stays white, and a colour that the scene gives in Rec.709 comes back as the working space has it."""
    (tmp_path / "config.ocio").write_text(colour.config_text(working))
    (tmp_path / "a.toml").write_text(
        'scene_version = 2\ncamera = { position = [0, 0, 4], target = [0, 0, 0], resolution = [32, 32] }\n'
        '[[volume]]\nsource = "noise"\nparameters = { resolution = 16 }\n'
        '[[light]]\ntype = "distant"\ndirection = [-1, -1, -1]\n'
        'color = { rgb = [0.5, 0.25, 1.0], colorspace = "Linear Rec.709" }\n'
        '[output]\ntype = "float"\ncompression = "none"\n'
    )
    got = {}
    for space in ("Linear Rec.709", working):
        picture = tmp_path / "a.exr"
        words = [SCRIM, "render", str(tmp_path / "a.toml"), "-o", str(picture), "-q"]
        words += ["--ocio", str(tmp_path / "config.ocio"), "--set", f'output.colorspace="{space}"']
        done = subprocess.run(words, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        read = s.exr.read(str(picture))
        got[space] = np.array([read.channels[c].sum() for c in "RGB"])
    assert got["Linear Rec.709"] / got["Linear Rec.709"][2] == pytest.approx([0.5, 0.25, 1], rel=1e-4)
    matrix = np.array(colour._MATRICES[working])
    expected = np.linalg.solve(matrix, np.array(colour._MATRICES["Linear Rec.709"]) @ got["Linear Rec.709"])
    assert got[working] == pytest.approx(expected, rel=1e-4)
    assert matrix.sum(1) == pytest.approx([1, 1, 1], abs=2e-6)


def test_registers_twice():
    addon.unregister()
    assert not hasattr(bpy.types.Scene, "scrim")
    addon.register()
    assert bpy.context.scene.scrim.quality == "STANDARD"


def test_this_blender_is_one_that_the_add_on_says_it_runs_in():
    assert s.scrim.bl_info["blender"] <= bpy.app.version
    if bpy.app.version < (4, 2):  # those since then read the manifest
        return
    tool = os.path.join(bpy.utils.resource_path("LOCAL"), "scripts", "addons_core", "bl_pkg", "cli", "blender_ext.py")
    folder = os.path.dirname(addon.__file__)
    # The program of Blender's own that `blender --command extension validate` runs.
    done = subprocess.run([sys.executable, tool, "validate", folder], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
