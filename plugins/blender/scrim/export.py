# SPDX-License-Identifier: Apache-2.0
# A depsgraph of Blender as a scene of Scrim: tables, and files in a folder of their own. `warn` is called once for each
# thing that cannot be mapped, with its name; a scene that cannot be rendered at all raises Failure.
import os
import shutil

import numpy as np

from . import exr, formulae, meshes, motion, nodes
from .scrim_kit import Failure, frames, light_laws, media, photometry, ply
from .scrim_kit.names import Names

FRAME = 1  # of the scene, in place of Blender's frame: keys are about it
_SOLIDS = ("MESH", "CURVE", "SURFACE", "META", "FONT")
_LEAST = 1e-5


def rows(matrix):
    return [[float(v) for v in row] for row in matrix]


def column(matrix, i):
    return [float(matrix[row][i]) for row in range(3)]


def length(v):
    return sum(c * c for c in v) ** 0.5


class Exporter:
    def __init__(self, folder, settings, warn, abspath, version):
        """`settings`: of the scene, see addon.py. `abspath(path, library)` as bpy.path.abspath. `version`: three
        numbers, Blender's."""
        self.folder, self.settings, self.abspath = folder, settings, abspath
        self.before_4 = version < (4, 0)  # whose lights follow other laws
        self.names = Names()
        self.said = set()
        self.warn_user = warn
        self.light_passes = {}  # name in the scene -> name in Blender
        self.files = {}

    def warn(self, text):
        if text not in self.said:
            self.said.add(text)
            self.warn_user(text)

    def scene(self, depsgraph, camera_pose, moves):
        """`camera_pose`: (camera object, its shift along x). `moves`: motion.Moves, which knows all matrices."""
        self.moves = moves
        return self.scene_of_view(depsgraph, self.camera(depsgraph.scene, *camera_pose), moves)

    def scene_of_view(self, depsgraph, camera, moves):
        """The same, with the table of its camera."""
        self.moves = moves
        scene = depsgraph.scene
        out = {"camera": camera}
        volumes, lights, solids = [], [], []
        for instance in depsgraph.object_instances:
            thing, shown = instance.object, instance.show_self
            key = motion.key_of(instance)
            if thing.type == "VOLUME" and shown:
                volumes += self.volume(depsgraph, thing, key)
            elif thing.type == "LIGHT" and shown:
                lights += self.light(thing, key)
            elif thing.type in _SOLIDS and shown:
                seen, shining = self.solid(thing, key)
                solids += seen
                lights += shining
        lights += self.world(scene.world)
        if not volumes:
            raise Failure("there is no Volume object that Scrim can render in this view layer")
        out["volume"] = volumes
        if solids:
            out["mesh"] = solids
        if lights:
            out["light"] = lights
        return out

    # Camera

    def camera(self, scene, thing, shift_x):
        data, render = thing.data, scene.render
        if thing.type != "CAMERA" or data.type not in ("PERSP", "ORTHO"):
            raise Failure(f"the camera '{thing.name}' is neither perspective nor orthographic")
        width, height = resolution(render)
        pixel_aspect = render.pixel_aspect_x / render.pixel_aspect_y
        horizontal, sensor, aspect = formulae.camera_window(
            width, height, pixel_aspect, data.sensor_fit, data.sensor_width, data.sensor_height
        )
        out = {"matrix": self.moves.keyed("camera", rows), "resolution": [width, height]}
        out["near"] = float(data.clip_start)
        shift = (float(shift_x), float(data.shift_y))
        out.update(formulae.camera_lens(data.type, horizontal, sensor, aspect, data.lens, data.ortho_scale, shift))
        if abs(pixel_aspect - 1) > 1e-6:
            out["pixel_aspect"] = float(pixel_aspect)
        if data.dof.use_dof and data.type == "PERSP":
            out["lens_radius"] = formulae.lens_radius(data.lens, data.dof.aperture_fstop)
            out["focus_distance"] = self.focus(thing)
        if self.moves.shutter:
            out["shutter"] = self.moves.shutter
        return out

    def focus(self, camera):
        """Where the camera is sharp: at an object, or at a distance of its own."""
        target = camera.data.dof.focus_object
        if target is None:
            return float(camera.data.dof.focus_distance)
        there = camera.matrix_world.inverted() @ target.matrix_world.translation
        depth = -float(there.z)
        if depth > 0:
            return depth
        self.warn(f"camera '{camera.name}': '{target.name}', at which it is sharp, lies behind it")
        return float(camera.data.dof.focus_distance)

    # Volumes

    def volume(self, depsgraph, thing, key):
        data = thing.data
        name = f"volume '{thing.name}'"
        data.grids.load()
        if data.grids.error_message:
            raise Failure(f"{name}: {data.grids.error_message}")
        grids = [grid.name for grid in data.grids]
        if not grids:
            return []  # such as a sequence beyond its end: other engines show nothing there either
        material = next((slot.material for slot in thing.material_slots if slot.material), None)
        try:
            if material is None or not material.use_nodes:
                medium = nodes.default_medium(grids)
            else:
                vectors = [grid.name for grid in data.grids if grid.data_type.startswith("VECTOR")]
                medium = nodes.medium_of(material.node_tree, grids, vectors)
        except nodes.NotMapped as what:
            self.warn(f"{name} is not rendered: Scrim does not know {what}")
            return []
        for note in medium.notes:
            self.warn(f"{name}: Scrim does not know {note}")
        matrix = self.moves.matrix(key)
        in_object = data.render.space == "OBJECT"
        density, keys = medium.keys(formulae.object_density(matrix) if in_object else 1.0)
        keys["scattering"] = self.scattering(keys["albedo"], name)
        out = {"name": self.names.of(thing.name), "file": frames.pattern_of(self.volume_file(thing))}
        out.update(transform=self.moves.transform(key, self.warn, name), density=density, medium=keys)
        if medium.ax:
            out["ax"] = medium.ax
        if self.moves.shutter and data.velocity_grid:
            out.update(self.velocity(data, grids, name))
        if thing.is_holdout or thing.holdout_get(view_layer=depsgraph.view_layer_eval):
            out["holdout"] = True
        if not thing.visible_shadow:
            self.warn(f"{name}: casts a shadow, though it should not")
        return [out]

    def scattering(self, albedo, name):
        chosen = self.settings.scattering.lower()
        if chosen != "auto":
            return chosen
        most = albedo["scale"] if isinstance(albedo, dict) else max(albedo)
        chosen = media.scattering_of([most])
        if chosen == "full":
            self.warn(
                f"{name}: its material scatters {min(most, 1.0):.0%} of what it takes from light, so Scattering is "
                "Full; Once is as Cycles with 0 volume bounces, and faster"
            )
        return chosen

    def velocity(self, data, grids, name):
        triple = [data.velocity_x_grid, data.velocity_y_grid, data.velocity_z_grid]
        if data.velocity_grid in grids:
            grid = data.velocity_grid
        elif all(triple) and set(triple) <= set(grids):
            grid = triple
        else:
            return {}
        unit = "second" if data.velocity_unit == "SECOND" else "frame"
        return {"velocity": {"grid": grid, "scale": float(data.velocity_scale), "unit": unit}}

    def volume_file(self, thing):
        """The volume's file at the frame. A volume of geometry nodes or modifiers, which is only in memory, is
        written to one."""
        data = thing.data
        path = data.grids.frame_filepath or ""
        path = self.abspath(path, data.library) if path else ""
        if os.path.isfile(path) and not len(thing.modifiers):
            return self.linked(path, "volume")
        saved = os.path.join(self.folder, f"volume{len(self.files)}.vdb")
        memory = ("memory", data.session_uid if hasattr(data, "session_uid") else data.name_full)
        if memory not in self.files:
            if not data.grids.save(filepath=saved):
                raise Failure(f"volume '{thing.name}': cannot write its grids: {data.grids.error_message}")
            self.files[memory] = saved
        return self.files[memory]

    def linked(self, path, kind):
        """A path to the file that no scene takes for a pattern of a sequence."""
        path = os.path.abspath(path)
        if path not in self.files:
            link = os.path.join(self.folder, f"{kind}{len(self.files)}{os.path.splitext(path)[1]}")
            try:
                os.symlink(path, link)
            except OSError:
                shutil.copyfile(path, link)
            self.files[path] = link
        return self.files[path]

    # Lights

    def light(self, thing, key):
        data = thing.data
        name = f"light '{thing.name}'"
        if not thing.visible_volume_scatter:
            return []
        try:
            emitted = nodes.light_emission(data)
        except nodes.NotMapped as what:
            self.warn(f"{name}: Scrim does not know {what} (rendered as white of strength 1)")
            emitted = nodes.Shining(nodes.WHITE)
        warmth = data.temperature_color if getattr(data, "use_temperature", False) else (1, 1, 1)
        strength = light_laws.cycles_strength(data.color, data.energy, getattr(data, "exposure", 0.0), warmth)
        strength = [s * e for s, e in zip(strength, emitted.color)]
        profile, candelas = self.profile(emitted.profile, data, name)
        strength = [s * candelas for s in strength]
        if max(strength) <= 0:
            return []
        if self.linked_to_some(thing):
            self.warn(f"{name}: light linking is not rendered; it lights and is shadowed by all")
        matrix = self.moves.matrix(key)
        if data.type == "AREA":
            keys = self.area(data, matrix, strength, name)
        else:
            keys = self.lamp(data, strength, name, bool(profile))
        out = {"name": self.names.of(thing.name), **keys, **profile}
        self.light_passes[out["name"]] = thing.name
        if data.type != "SUN":
            out["position"] = self.moves.keyed(key, lambda m: column(m, 3))
        if data.type != "POINT" or profile:
            out["direction"] = self.moves.keyed(key, lambda m: [-c for c in column(m, 2)])
        if keys.get("shape") == "rectangle" or profile:
            out["up"] = self.moves.keyed(key, lambda m: column(m, 1))
        if not data.use_shadow:
            out["shadows"] = False
        return [out]

    @staticmethod
    def linked_to_some(thing):
        linking = getattr(thing, "light_linking", None)
        return linking is not None and bool(linking.receiver_collection or linking.blocker_collection)

    def profile(self, node, data, name):
        """(keys of a light for an IES texture, strength of its brightest direction)."""
        if node is None:
            return {}, 1.0
        if data.type not in ("POINT", "SPOT"):
            self.warn(f"{name}: only points and spots have IES textures (rendered without)")
            return {}, 1.0
        if node.mode == "INTERNAL":
            path = os.path.join(self.folder, f"profile{len(self.files)}.ies")
            with open(path, "w", encoding="latin-1", errors="replace") as file:
                file.write(node.ies.as_string() if node.ies else "")
            self.files[path] = path
        else:
            path = self.linked(self.abspath(node.filepath, node.id_data.library), "profile")
        try:
            largest = photometry.Photometry(path).largest
        except Failure as error:
            self.warn(f"{name}: {error} (rendered without)")
            return {}, 1.0
        return {"ies": frames.pattern_of(path)}, largest * light_laws.CYCLES_WATTS_OF_CANDELA

    def lamp(self, data, strength, name, as_point):
        normalize = getattr(data, "normalize", True)
        if data.type == "SUN":
            return light_laws.cycles_sun(strength, data.angle, normalize, self.before_4)
        radius = data.shadow_soft_size
        if data.type == "POINT":
            if as_point and radius > 0:
                self.warn(f"{name}: the radius of a light with an IES texture is not rendered; its shadows are sharp")
            return light_laws.cycles_point(strength, radius, normalize, as_point)
        if radius > 0:
            self.warn(f"{name}: the radius of a spot is not rendered; its shadows are sharp")
        if data.use_square:
            self.warn(f"{name}: a square spot is rendered as a round one")
        return light_laws.cycles_spot(strength, data.spot_size, data.spot_blend, radius, normalize)

    def area(self, data, matrix, strength, name):
        width = data.size * length(column(matrix, 0))
        tall = data.shape in ("RECTANGLE", "ELLIPSE")
        height = (data.size_y if tall else data.size) * length(column(matrix, 1))
        ellipse = data.shape in ("DISK", "ELLIPSE")
        if ellipse and abs(width - height) > 1e-3 * max(width, height):
            self.warn(f"{name}: an ellipse is rendered as a disk of its mean radius")
        normalize = getattr(data, "normalize", True)
        return light_laws.cycles_area(strength, width, height, ellipse, normalize, self.before_4, data.spread)

    def world(self, world):
        if world is None:
            return []
        try:
            sky = nodes.sky_of(world)
        except nodes.NotMapped as what:
            self.warn(f"world '{world.name}' is not rendered: Scrim does not know {what}")
            return []
        if sky is None:
            return []
        out = {"name": self.names.of("World"), "type": "dome", **light_laws.shining(sky.color, 1.0)}
        self.light_passes[out["name"]] = "World"
        if sky.clear is not None:
            out.update(up=[0.0, 0.0, 1.0], rotation=sky.turn, sky=sky.clear)
        if sky.image is not None:
            # Cycles' pictures of skies have +x in their middle and z up; the turn that takes Scrim's y up to z has -y.
            out.update(up=[0.0, 0.0, 1.0], rotation=90.0 + sky.turn, texture=self.texture(sky.image))
        return [out]

    def texture(self, image):
        path = self.abspath(image.filepath, image.library) if image.filepath else ""
        if image.source == "FILE" and not image.packed_file and os.path.isfile(path):
            path = self.linked(path, "sky")
        else:
            # Packed, painted or generated: its values as they are, in its own space.
            path = os.path.join(self.folder, "sky.exr")
            width, height = image.size
            pixels = np.empty(width * height * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            pixels = pixels.reshape(height, width, -1)[::-1]
            exr.write(path, pixels[:, :, :3] if image.channels >= 3 else np.repeat(pixels[:, :, :1], 3, axis=2))
        return {"file": frames.pattern_of(path), "colorspace": image.colorspace_settings.name}

    # Solids

    def solid(self, thing, key):
        """([[mesh]]es, [[light]]s) of an object that has a surface."""
        materials = [slot.material for slot in thing.material_slots]
        glow = self.glow(thing, materials)
        shown = self.settings.solids != "NONE"
        if not shown and not glow:
            return [], []
        if any(m.type == "FLUID" and m.fluid_type == "DOMAIN" for m in thing.modifiers):
            self.warn(f"'{thing.name}': simulations are rendered from files alone; export its cache as OpenVDB")
            return [], []
        trees = [material.node_tree for material in materials if material and material.use_nodes]
        if any(nodes.volume_of(tree) and not nodes.has_surface(tree) for tree in trees):
            self.warn(f"'{thing.name}': a volume within a mesh is not rendered; use a Volume object")
            return [], []
        mesh = thing.to_mesh()
        try:
            points, corners = meshes.triangles_of(mesh)
            slots = meshes.materials_of(mesh)
        finally:
            thing.to_mesh_clear()
        out, lights = [], []
        for slot, radiance in glow.items():
            part = corners[slots == slot]
            if len(part):
                name = self.names.of(thing.name)
                self.light_passes[name] = thing.name
                part = meshes.shining(part, thing.visible_shadow)
                out.append(self.mesh(thing, key, points, part, holdout=False, shadows=False))
                keys = {"type": "area", "shape": "mesh", "mesh": out[-1]["name"]}
                lights.append({"name": name, **keys, **light_laws.shining(radiance, 1.0)})
        if lights and shown and thing.visible_shadow:
            self.warn(f"'{thing.name}': it shines, and casts no shadow")
        holdout = bool(thing.visible_camera and self.settings.solids == "HOLDOUT")
        shadows = bool(shown and thing.visible_shadow and not lights)
        if len(corners) and (holdout or shadows):
            out.append(self.mesh(thing, key, points, corners, holdout=holdout, shadows=shadows))
        return out, lights

    def mesh(self, thing, key, points, corners, **roles):
        path = os.path.join(self.folder, f"mesh{len(self.files)}.ply")
        self.files[path] = path
        ply.write(path, points, corners)
        transform = self.moves.transform(key, self.warn, f"'{thing.name}'")
        return {"name": self.names.of(thing.name), "file": frames.pattern_of(path), "transform": transform, **roles}

    def glow(self, thing, materials):
        """The radiance of each material that shines into the smoke, by its slot."""
        out = {}
        for slot, material in enumerate(materials):
            if material is None or not getattr(thing, "visible_volume_scatter", True):
                continue
            try:
                radiance = nodes.mesh_emission(material)
            except nodes.NotMapped as what:
                self.warn(f"'{thing.name}' does not shine: Scrim does not know {what}")
                continue
            if max(radiance) > 0:
                out[slot] = radiance
        return out


def resolution(render):
    """As Blender has it: percent of both sides, cut to whole pixels."""
    part = render.resolution_percentage
    return render.resolution_x * part // 100, render.resolution_y * part // 100


def shutter_position(scene):
    if hasattr(scene.render, "motion_blur_position"):
        return scene.render.motion_blur_position
    # Versions in which only Cycles had it
    return getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
