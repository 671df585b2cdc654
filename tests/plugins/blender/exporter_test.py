# SPDX-License-Identifier: Apache-2.0
# What becomes of objects, row by row of the table in examples/BLENDER.md: look-alikes of Blender's in, tables of a
# scene out.
import math
import os
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from lookalikes import link, node

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))
from scrim import exr, export, motion, nodes  # noqa: E402
from scrim.scrim_kit import Failure, photometry  # noqa: E402

UNIT = [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]
# Turned by 90 degrees about z, twice as large, at (5, 6, 7)
TURNED = [[0, -2.0, 0, 5.0], [2.0, 0, 0, 6.0], [0, 0, 2.0, 7.0], [0, 0, 0, 1.0]]


def like(defaults, values):
    return SimpleNamespace(**{**defaults, **values})


class Fixture:
    """An exporter, what it warns of, and where things are."""

    def __init__(self, folder, version=(4, 5, 0), **settings):
        self.said, self.folder = [], folder
        settings = like({"scattering": "SINGLE", "solids": "HOLDOUT"}, settings)
        self.exporter = export.Exporter(str(folder), settings, self.said.append, lambda path, _: path, version)
        self.exporter.moves = motion.Moves({"camera": UNIT, "it": TURNED}, 1)


@pytest.fixture
def world(tmp_path):
    return Fixture(tmp_path)


# Camera

RENDER = {
    "resolution_x": 200, "resolution_y": 101, "resolution_percentage": 50, "pixel_aspect_x": 1.0, "pixel_aspect_y": 1.0
}  # fmt: skip
LENS = {
    "type": "PERSP", "sensor_fit": "AUTO", "sensor_width": 36.0, "sensor_height": 24.0, "lens": 50.0,
    "ortho_scale": 6.0, "shift_y": 0.25, "clip_start": 0.5,
}  # fmt: skip


def camera(fixture, render=(), **values):
    data = like({**LENS, "dof": SimpleNamespace(use_dof=False)}, values)
    thing = SimpleNamespace(name="eye", type="CAMERA", data=data)
    return fixture.exporter.camera(SimpleNamespace(render=like(RENDER, dict(render))), thing, 0.1)


def test_a_camera_has_a_matrix_a_lens_a_near_end_and_whole_pixels(world):
    got = camera(world)
    assert got.pop("fov") == pytest.approx(math.degrees(2 * math.atan(0.36)))
    assert got == {
        "matrix": UNIT, "resolution": [100, 50], "near": 0.5, "shift": [0.1, 0.25], "fov_axis": "horizontal"
    }  # fmt: skip


def test_pixels_that_are_not_square_change_the_side_that_the_sensor_fits(world):
    got = camera(world, {"pixel_aspect_y": 4.0})
    # 100 wide pixels are seen as wide as 25 high ones: half as wide as high.
    assert got["pixel_aspect"] == 0.25 and got["fov_axis"] == "vertical" and got["shift"] == pytest.approx([0.2, 0.5])


def test_parallel_cameras_have_a_height(world):
    got = camera(world, type="ORTHO")
    assert got["type"] == "orthographic" and got["height"] == pytest.approx(3) and "fov" not in got


def test_a_lens_is_sharp_at_a_distance_or_an_object(world):
    dof = {"use_dof": True, "aperture_fstop": 2.0, "focus_distance": 7.0, "focus_object": None}
    got = camera(world, dof=SimpleNamespace(**dof), lens=50.0)
    assert got["lens_radius"] == pytest.approx(0.0125) and got["focus_distance"] == 7
    assert "lens_radius" not in camera(world, dof=SimpleNamespace(**dof), type="ORTHO")


def test_other_cameras_fail(world):
    with pytest.raises(Failure, match="the camera 'eye' is neither perspective nor orthographic"):
        camera(world, type="PANO")


# Lights

LAMP = {
    "type": "POINT", "use_nodes": False, "color": (1, 1, 1), "energy": 4 * math.pi, "shadow_soft_size": 0.0,
    "use_shadow": True, "angle": 0.0, "spot_size": 1.0, "spot_blend": 0.2, "use_square": False, "shape": "SQUARE",
    "size": 1.0, "size_y": 1.0, "spread": math.pi,
}  # fmt: skip


def light(fixture, visible=True, linking=None, **values):
    data = like(LAMP, values)
    extra = {"light_linking": linking} if linking else {}
    thing = SimpleNamespace(name="Key", data=data, visible_volume_scatter=visible, **extra)
    return fixture.exporter.light(thing, "it")


def test_a_point_is_at_its_place(world):
    (got,) = light(world)
    assert got.pop("intensity") == pytest.approx(1)
    assert got == {"name": "Key", "type": "point", "color": [1, 1, 1], "position": [5, 6, 7]}
    assert world.exporter.light_passes == {"Key": "Key"}


def test_suns_and_spots_shine_along_minus_z(world):
    (sun,) = light(world, type="SUN", energy=3.0, use_shadow=False)
    assert sun["direction"] == [0, 0, -2] and "position" not in sun and sun["shadows"] is False
    (spot,) = light(world, type="SPOT")
    assert spot["direction"] == [0, 0, -2] and spot["position"] == [5, 6, 7] and "shadows" not in spot
    assert spot["cone"] == pytest.approx(math.degrees(1.0))


def test_areas_count_in_the_world(world):
    (got,) = light(world, type="AREA", shape="RECTANGLE", size=0.5, size_y=3.0, energy=math.pi)
    assert (got["shape"], got["width"], got["height"]) == ("rectangle", 1, 6)
    assert got["intensity"] == pytest.approx(1 / 6) and got["up"] == [-2, 0, 0]
    (got,) = light(world, type="AREA", shape="DISK", size=1.5, energy=math.pi)
    assert got["radius"] == 1.5 and got["intensity"] == pytest.approx(1 / (math.pi * 1.5**2)) and "up" not in got


def test_exposure_temperature_and_normalize_count_where_blender_has_them(world):
    values = {"exposure": 1.0, "use_temperature": True, "temperature_color": (1, 0.5, 0.25)}
    (got,) = light(world, energy=2 * math.pi, **values)
    assert got["color"] == [1, 0.5, 0.25] and got["intensity"] == pytest.approx(1)
    (got,) = light(world, type="AREA", normalize=False, energy=math.pi)
    assert got["intensity"] == pytest.approx(1)
    (got,) = light(world, type="SUN", angle=0.5, energy=1.0, normalize=False)
    assert got["intensity"] == pytest.approx(2 * math.pi * (1 - math.cos(0.25)))


def test_before_4_0_lights_are_cycles_of_then(tmp_path):
    old = Fixture(tmp_path, version=(3, 4, 1))
    (sun,) = light(old, type="SUN", angle=0.5, energy=3.0)
    assert sun["intensity"] == 3
    (area,) = light(old, type="AREA", size=0.5, energy=4.0)
    assert area["intensity"] == pytest.approx(1)


def test_lights_that_give_no_volume_light_are_left_out(world):
    assert light(world, visible=False) == [] == light(world, energy=0.0)


def test_what_lights_do_not_have_is_warned_of(world):
    light(world, type="SPOT", shadow_soft_size=0.1, use_square=True)
    light(world, type="AREA", shape="ELLIPSE", size_y=2.0, spread=1.0)
    light(world, linking=SimpleNamespace(receiver_collection="some", blocker_collection=None))
    assert world.said == [
        "light 'Key': the radius of a spot is not rendered; its shadows are sharp",
        "light 'Key': a square spot is rendered as a round one",
        "light 'Key': an ellipse is rendered as a disk of its mean radius",
        "light 'Key': light linking is not rendered; it lights and is shadowed by all",
    ]


def test_the_spread_of_an_area_light_is_its_full_angle(world):
    (soft,) = light(world, type="AREA", shape="RECTANGLE", size_y=2.0, spread=math.pi / 3)
    assert soft["spread"] == pytest.approx(60) and world.said == []
    (even,) = light(world, type="AREA", shape="RECTANGLE", size_y=2.0)
    assert "spread" not in even


def test_a_world_is_a_dome(world):
    plain = SimpleNamespace(name="World", use_nodes=False, color=(0.2, 0.1, 0.1))
    assert world.exporter.world(plain) == [
        {"name": "World", "type": "dome", "color": [1, 0.5, 0.5], "intensity": 0.2}
    ]  # fmt: skip
    assert world.exporter.world(None) == []


def test_a_sky_texture_is_a_dome_with_a_clear_sky(world, monkeypatch):
    sky = nodes.Sky([23.3, 23.3, 23.3], turn=170.0, clear={"sun_elevation": 20.0})
    monkeypatch.setattr(export.nodes, "sky_of", lambda _: sky)
    assert world.exporter.world(SimpleNamespace(name="World")) == [
        {"name": "World", "type": "dome", "color": [1, 1, 1], "intensity": 23.3, "up": [0, 0, 1], "rotation": 170,
         "sky": {"sun_elevation": 20}}
    ]  # fmt: skip


def test_pictures_of_skies_are_linked_or_written(world):
    class Pixels:
        def foreach_get(self, target):
            target[:] = np.arange(8)

    space = SimpleNamespace(name="sRGB")
    picture = SimpleNamespace(
        filepath="", library=None, source="GENERATED", packed_file=None, size=(1, 2), channels=4, pixels=Pixels(),
        colorspace_settings=space,
    )  # fmt: skip
    got = world.exporter.texture(picture)
    read = exr.read(got["file"])
    # Blender's rows begin at the bottom.
    assert got["colorspace"] == "sRGB" and [read.channels[c][:, 0].tolist() for c in "RGB"] == [[4, 0], [5, 1], [6, 2]]
    (world.folder / "sky #### [1].hdr").write_text("x")
    picture.source, picture.filepath = "FILE", str(world.folder / "sky #### [1].hdr")
    linked = world.exporter.texture(picture)["file"]
    assert os.path.samefile(linked, picture.filepath) and "#" not in linked


def test_files_are_named_whatever_their_folder_is_called(tmp_path):
    folder = tmp_path / "a##b do$lar %04d"
    folder.mkdir()
    picture = SimpleNamespace(
        filepath=str(folder / "s.hdr"), library=None, source="FILE", packed_file=None,
        colorspace_settings=SimpleNamespace(name="sRGB"),
    )  # fmt: skip
    (folder / "s.hdr").write_text("x")
    assert Fixture(folder).exporter.texture(picture)["file"] == f"{tmp_path}/a$#$#b do$$lar $%04d/sky0.hdr"


# Volumes


class Grids(list):
    error_message = ""

    def __init__(self, names, path):
        super().__init__(SimpleNamespace(name=name) for name in names)
        self.frame_filepath = path
        self.saved = 0

    def load(self):
        return True

    def save(self, filepath):
        self.saved += 1
        with open(filepath, "w"):
            return True


VOLUME = {
    "velocity_grid": "velocity", "velocity_x_grid": "", "velocity_y_grid": "", "velocity_z_grid": "",
    "velocity_unit": "SECOND", "velocity_scale": 2.0, "library": None,
}  # fmt: skip


def volume(fixture, names=("density",), modifiers=(), holdout=False, space="WORLD", shadow=True, **values):
    path = fixture.folder / "smoke_0007.vdb"
    path.write_text("x")
    own = {"grids": Grids(names, str(path)), "render": SimpleNamespace(space=space), "name_full": "v"}
    data = like(VOLUME, {**own, **values})
    thing = SimpleNamespace(
        name="Smoke", data=data, material_slots=[], modifiers=modifiers, is_holdout=False, visible_shadow=shadow,
        holdout_get=lambda view_layer: holdout,
    )  # fmt: skip
    return data, fixture.exporter.volume(SimpleNamespace(view_layer_eval=None), thing, "it")


def test_a_volume_is_its_frames_file_where_its_matrix_puts_it(world):
    data, (got,) = volume(world)
    assert os.path.samefile(got.pop("file"), data.grids.frame_filepath)
    assert got == {
        "name": "Smoke", "transform": {"matrix": TURNED}, "density": {"grid": "density", "scale": 1},
        "medium": {"albedo": [0.5] * 3, "phase": {"type": "isotropic"}, "scattering": "single"},
    }  # fmt: skip


def test_object_space_and_scattering_and_holdout(tmp_path):
    fixture = Fixture(tmp_path, scattering="FULL")
    _, (got,) = volume(fixture, space="OBJECT", holdout=True)
    assert got["density"]["scale"] == pytest.approx(0.5)
    assert got["medium"]["scattering"] == "full" and got["holdout"] is True


def test_what_a_shot_cannot_ignore_scatters_fully_and_is_told(tmp_path):
    fixture = Fixture(tmp_path, scattering="AUTO")
    _, (got,) = volume(fixture)  # Blender's default, of albedo 0.5
    assert got["medium"]["scattering"] == "single" and fixture.said == []
    assert fixture.exporter.scattering([0.59, 0.2, 0.1], "volume 'a'") == "single" and fixture.said == []
    assert fixture.exporter.scattering([0.1, 0.6, 0.1], "volume 'b'") == "full"
    assert fixture.exporter.scattering({"grid": "Cd", "scale": 0.95}, "volume 'c'") == "full"
    assert fixture.exporter.scattering({"grid": "Cd", "scale": 0.5}, "volume 'c'") == "single"
    why = "of what it takes from light, so Scattering is Full; Once is as Cycles with 0 volume bounces, and faster"
    assert fixture.said == [
        f"volume 'b': its material scatters 60% {why}",
        f"volume 'c': its material scatters 95% {why}",
    ]
    once = Fixture(tmp_path, scattering="SINGLE")
    assert once.exporter.scattering([0.99] * 3, "volume 'b'") == "single" and once.said == []


def test_what_only_memory_holds_is_written_once(world):
    data, (first,) = volume(world, modifiers=["noise"])
    assert data.grids.saved == 1 and os.path.basename(first["file"]) == "volume0.vdb"
    data, (second,) = volume(world, modifiers=["noise"])
    assert data.grids.saved == 0 and second["file"] == first["file"] and second["name"] == "Smoke_2"


def test_volumes_that_cannot_be_are_left_out_or_fail(world):
    assert volume(world, names=())[1] == []
    assert volume(world, names=("heat",))[1] == []
    text = "volume 'Smoke' is not rendered: Scrim does not know no material, and no grid 'density'"
    assert world.said == [text]
    assert volume(world, shadow=False)[1]
    assert world.said[-1] == "volume 'Smoke': casts a shadow, though it should not"
    broken = Grids(("density",), "")
    broken.error_message = "cannot be read"
    with pytest.raises(Failure, match="volume 'Smoke': cannot be read"):
        volume(world, grids=broken)


@pytest.mark.parametrize(
    "names, values, grid",
    [
        (("density", "velocity"), {}, "velocity"),
        (("density", "x", "y", "z"), {f"velocity_{c}_grid": c for c in "xyz"}, ["x", "y", "z"]),
    ],
)
def test_velocities_blur_while_the_shutter_is_open(world, names, values, grid):
    assert "velocity" not in volume(world, names=names, **values)[1][0]
    world.exporter.moves = motion.Moves({"it": UNIT}, 1, [], [0, 0.5])
    assert volume(world, names=names, **values)[1][0]["velocity"] == {"grid": grid, "scale": 2, "unit": "second"}
    assert "velocity" not in volume(world)[1][0]


# Motion


def test_what_moves_has_keys_about_the_frame(world):
    seen = [(time, {"it": [[1.0, 0, 0, time], *UNIT[1:]], "still": UNIT}) for time in (-0.25, 0.25)]
    moves = motion.Moves({"it": UNIT, "still": UNIT}, 1, seen, [-0.25, 0.25])
    assert moves.keyed("it", lambda m: export.column(m, 3)) == {"keys": [[0.75, [-0.25, 0, 0]], [1.25, [0.25, 0, 0]]]}
    assert moves.keyed("still", lambda m: export.column(m, 3)) == [0, 0, 0]
    assert moves.transform("still", world.said.append, "it") == {"matrix": UNIT}


def test_a_linked_object_has_its_own_matrix_beside_a_local_one_of_its_name():
    def instance(library, matrix, parent=None):
        thing = SimpleNamespace(name="Smoke", name_full="Smoke" + library)
        return SimpleNamespace(object=thing, parent=parent, is_instance=parent is not None, persistent_id=(0,),
                               matrix_world=np.array(matrix))  # fmt: skip

    ours, theirs = instance("", UNIT), instance(" [library.blend]", TURNED)
    within = [instance("", matrix, it.object) for it, matrix in ((ours, TURNED), (theirs, UNIT))]
    seen = [ours, theirs, *within]
    moves = motion.Moves(motion.matrices(SimpleNamespace(object_instances=seen), np.array(UNIT)), 1)
    for one in seen:
        assert (moves.matrix(motion.key_of(one)) == one.matrix_world).all()


@pytest.mark.parametrize(
    "scene, position",
    [
        ({"render": SimpleNamespace(motion_blur_position="END")}, "END"),
        ({"render": SimpleNamespace(), "cycles": SimpleNamespace(motion_blur_position="START")}, "START"),
        ({"render": SimpleNamespace()}, "CENTER"),
    ],
)
def test_the_shutters_place_is_where_each_blender_has_it(scene, position):
    assert export.shutter_position(SimpleNamespace(**scene)) == position


# Solids


class Many(list):
    def __init__(self, values, width):
        super().__init__([None] * (len(values) // width))
        self.values = values

    def foreach_get(self, name, target):
        target[:] = self.values


class Triangles(Many):
    def __init__(self, corners, slots):
        super().__init__(list(corners), 3)
        self.slots = list(slots) or [0] * len(self)

    def foreach_get(self, name, target):
        target[:] = self.slots if name == "material_index" else self.values


TETRAHEDRON = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]


def surface(
    fixture, camera=True, shadow=True, modifiers=(), corners=(0, 1, 2), materials=(), slots=(), scatter=True,
    points=(0, 0, 0, 1, 0, 0, 0, 1, 0),
):  # fmt: skip
    """(meshes, lights) of an object."""
    mesh = SimpleNamespace(vertices=Many(list(points), 3), loop_triangles=Triangles(corners, slots))
    mesh.calc_loop_triangles = lambda: None
    thing = SimpleNamespace(
        name="Wall", visible_shadow=shadow, visible_camera=camera, modifiers=modifiers,
        material_slots=[SimpleNamespace(material=m) for m in materials], visible_volume_scatter=scatter,
        to_mesh=lambda: mesh, to_mesh_clear=lambda: None,
    )  # fmt: skip
    return fixture.exporter.solid(thing, "it")


def solid(fixture, **values):
    meshes, lights = surface(fixture, **values)
    assert lights == []
    return meshes


def test_solids_hold_out_and_throw_shadows_as_they_are_seen(world):
    (got,) = solid(world)
    with open(got.pop("file"), "rb") as file:
        assert b"element vertex 3" in file.read()
    assert got == {"name": "Wall", "transform": {"matrix": TURNED}, "holdout": True, "shadows": True}
    assert solid(world, camera=False)[0]["holdout"] is False
    assert solid(world, shadow=False)[0]["shadows"] is False
    assert solid(world, camera=False, shadow=False) == [] == solid(world, corners=())


def test_solids_may_be_left_out(tmp_path):
    assert solid(Fixture(tmp_path, solids="SHADOW"))[0]["holdout"] is False
    assert solid(Fixture(tmp_path, solids="NONE")) == []


def test_simulations_are_warned_of(world):
    assert solid(world, modifiers=[SimpleNamespace(type="FLUID", fluid_type="DOMAIN")]) == []
    assert world.said == ["'Wall': simulations are rendered from files alone; export its cache as OpenVDB"]


def glowing(strength=3.0, color=(1, 0.5, 0, 1), kind="ShaderNodeEmission"):
    names = {"Strength": strength, "Color": color}
    if kind == "ShaderNodeBsdfPrincipled":
        names = {"Emission_Strength": strength, "Emission_Color": color}
    shader, end = node(kind, **names), node("ShaderNodeOutputMaterial", Surface=None, Volume=None)
    end.is_active_output = True
    link(shader, end, "Surface")
    return SimpleNamespace(use_nodes=True, node_tree=SimpleNamespace(nodes=[end, shader]))


def faces_of(table):
    with open(table["file"], "rb") as file:
        return int(re.search(rb"element face (\d+)", file.read())[1])


@pytest.mark.parametrize("kind", ["ShaderNodeEmission", "ShaderNodeBsdfPrincipled"])
def test_a_surface_that_shines_is_a_light_and_casts_no_shadow(world, kind):
    (shining, seen), (light_,) = surface(world, materials=[glowing(kind=kind)])
    assert (shining["holdout"], shining["shadows"]) == (False, False)
    assert (seen["holdout"], seen["shadows"], seen["name"]) == (True, False, "Wall_3")
    assert light_.pop("name") == "Wall" and light_.pop("color") == [1, 0.5, 0]
    assert light_ == {"type": "area", "shape": "mesh", "mesh": "Wall_2", "intensity": 3}
    assert faces_of(shining) == 2 and faces_of(seen) == 1  # an open one shines to both sides
    assert world.said == ["'Wall': it shines, and casts no shadow"] and world.exporter.light_passes == {"Wall": "Wall"}


def test_a_closed_surface_shines_outwards(world):
    points, corners = TETRAHEDRON
    (shining, _), _ = surface(world, materials=[glowing()], points=points, corners=corners)
    assert faces_of(shining) == 4
    (shining, _), _ = surface(world, materials=[glowing()], points=points, corners=corners, shadow=False)
    assert faces_of(shining) == 8  # light passes through it


def test_triangles_shine_whose_material_does(world):
    dark = glowing(strength=0.0)
    points, corners = TETRAHEDRON
    shown, lights = surface(
        world, materials=[dark, glowing()], slots=[0, 1, 1, 0], points=points, corners=corners, camera=False
    )
    assert [faces_of(mesh) for mesh in shown] == [4] and len(lights) == 1  # two of them, open
    assert surface(world, materials=[dark])[1] == [] == surface(world, materials=[glowing()], scatter=False)[1]
    assert surface(world, materials=[None])[1] == []


def test_what_shines_does_so_where_solids_are_left_out(tmp_path):
    (mesh,), (light_,) = surface(Fixture(tmp_path, solids="NONE"), materials=[glowing()])
    assert mesh["shadows"] is False and light_["mesh"] == mesh["name"]


def with_profile(path, strength=1.0, factor=None):
    """Nodes of a light whose strength an IES texture gives, times `factor`."""
    texture = node("ShaderNodeTexIES", Vector=None, Strength=strength)
    texture.mode, texture.filepath = "EXTERNAL", str(path)
    texture.id_data = SimpleNamespace(library=None)
    shader, end = node("ShaderNodeEmission", Strength=1.0, Color=(1, 1, 1, 1)), node("ShaderNodeOutputLight", Surface=None)
    end.is_active_output = True
    last = texture
    if factor is not None:
        last = node("ShaderNodeMath", A=1.0, B=factor)
        last.operation, last.use_clamp = "MULTIPLY", False
        link(texture, last, "A")
    link(last, shader, "Strength"), link(shader, end, "Surface")
    return {"use_nodes": True, "node_tree": SimpleNamespace(nodes=[end, shader, texture, last])}


WALL = os.path.join(os.path.dirname(__file__), "../../../examples/scenes/luminaires/wall.ies")


def test_an_ies_texture_is_a_luminaire_with_candelas_in_watts(world):
    (got,) = light(world, **with_profile(WALL, strength=2.0, factor=3.0))
    assert os.path.samefile(got.pop("ies"), WALL)
    largest = photometry.Photometry(WALL).largest
    assert got.pop("intensity") == pytest.approx(6 * largest * 4 * math.pi / 177.83, rel=1e-4)
    assert got == {
        "name": "Key", "type": "point", "color": [1, 1, 1], "position": [5, 6, 7], "direction": [0, 0, -2],
        "up": [-2, 0, 0],
    }  # fmt: skip
    (got,) = light(world, type="SPOT", shadow_soft_size=0.1, **with_profile(WALL))
    assert got["type"] == "spot" and "ies" in got


def test_ies_textures_that_cannot_be_rendered_are_warned_of(world, tmp_path):
    (tmp_path / "bad.ies").write_text("no")
    (got,) = light(world, **with_profile(tmp_path / "bad.ies"))
    assert "ies" not in got and "not a photometric file" in world.said[0]
    (got,) = light(world, type="SUN", **with_profile(WALL))
    assert "ies" not in got and world.said[1] == "light 'Key': only points and spots have IES textures (rendered without)"
    (got,) = light(world, shadow_soft_size=0.1, **with_profile(WALL))
    assert got["type"] == "point" and "its shadows are sharp" in world.said[2]
