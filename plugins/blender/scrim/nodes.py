# SPDX-License-Identifier: Apache-2.0
# Reads the volume of a material: nodes in, coefficients out. What cannot be mapped raises NotMapped where it decides
# what the medium is, or is noted where it only changes it a little. Nodes are used by their names alone, so that tests
# need no Blender.
import math
from dataclasses import dataclass, field

from . import formulae
from .expressions import Code, NotMapped, constant_of, source_of
from .values import BLACK, WHITE, Value, value_of


@dataclass
class Medium:
    """Coefficients at grid value 1. `emission` and `blackbody` are keys of a scene, without object density."""

    grid: str
    scattering: list
    extinction: list
    albedo_grid: str = ""
    albedo_scale: float = 1.0
    phase: dict = field(default_factory=lambda: {"type": "isotropic"})
    emission: dict = None
    blackbody: dict = None
    notes: list = field(default_factory=list)
    ax: str = ""  # code that makes grids of what nodes compute

    def keys(self, object_density=1.0):
        """(`density`, `medium`) of a [[volume]]."""
        scale, keys = formulae.medium(self.scattering, self.extinction)
        if self.albedo_grid:
            keys = {"albedo": {"grid": self.albedo_grid, "scale": self.albedo_scale}}
        keys["phase"] = self.phase
        if self.emission:
            keys["emission"] = {**self.emission, "scale": self.emission["scale"] * object_density}
        if self.blackbody:
            keys["blackbody"] = {**self.blackbody, "intensity": self.blackbody["intensity"] * object_density}
        return {"grid": self.grid, "scale": scale * object_density}, keys


def volume_of(tree):
    """The node that the active output's volume comes from, or None."""
    outputs = [n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial"]
    fit = [n for n in outputs if getattr(n, "target", "ALL") in ("ALL", "CYCLES")]
    active = next((n for n in fit if n.is_active_output), fit[0] if fit else None)
    return source_of(active.inputs["Volume"])[0] if active is not None else None


def has_surface(tree):
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeOutputMaterial" and node.inputs["Surface"].links:
            return True
    return False


def _or_noted(socket, notes):
    """For a value that only shapes the look: notes what is not mapped, and takes the socket's value without its
    link."""
    try:
        value = value_of(socket)
        if not value.grid:
            return value
        notes.append(f"the grid '{value.grid}' at '{socket.name}'")
    except NotMapped as what:
        notes.append(str(what))
    return Value(constant_of(socket) if hasattr(socket, "default_value") else WHITE)


@dataclass
class _Part:
    """The coefficients that one shader adds."""

    scattering: Value = None
    extinction: Value = None
    phase: dict = None


class _Sum:
    def __init__(self, grids, vectors):
        self.grids = grids
        self.parts = []
        self.medium = Medium("", BLACK, BLACK)
        self.code = Code(grids, vectors)

    def value(self, socket, vector=False):
        """A constant times a grid; where nodes compute more than that, a grid that an expression makes."""
        try:
            return value_of(socket)
        except NotMapped:
            variable = self.code.of(socket, vector)
            if not self.code.varies(variable):
                raise
        return Value(WHITE, self.code.grid(variable, None if vector else 0.0))

    def product(self, a, b):
        """The product of two values. Both may be grids."""
        if not (a.grid and b.grid):
            return a.times(b)
        first, second = (self.code.scalar(self.code.variable_of(v.grid))[0] for v in (a, b))
        grid = self.code.grid((f"{first} * {second}", False))
        return Value([x * y for x, y in zip(a.color, b.color)], grid)

    def add(self, node):
        kind = node.bl_idname
        if kind == "ShaderNodeAddShader":
            for socket in node.inputs:
                source, _ = source_of(socket)
                if source is not None:
                    self.add(source)
        elif kind == "ShaderNodeVolumePrincipled":
            self.principled(node)
        elif kind == "ShaderNodeVolumeScatter":
            self.scatter(node)
        elif kind == "ShaderNodeVolumeAbsorption":
            density = self.density(node.inputs["Density"])
            color = _or_noted(node.inputs["Color"], self.medium.notes).color
            self.parts.append(_Part(extinction=density.times(Value([1 - c for c in color]))))
        elif kind == "ShaderNodeEmission":
            self.emit(node.inputs["Strength"], node.inputs["Color"])
        else:
            raise NotMapped(f"node '{node.name}'")

    def density(self, socket):
        value = self.value(socket)
        return Value([max(c, 0.0) for c in value.color], value.grid)

    def scatter(self, node):
        density = self.density(node.inputs["Density"])
        color = _or_noted(node.inputs["Color"], self.medium.notes).color
        kind = getattr(node, "phase", "HENYEY_GREENSTEIN")
        if kind not in ("HENYEY_GREENSTEIN", "RAYLEIGH", "DRAINE", "MIE"):
            self.medium.notes.append(f"the phase function {kind} of node '{node.name}' (taken for Henyey-Greenstein)")
        lit = density.times(Value(color))
        self.parts.append(_Part(lit, lit, self.phase(node, kind)))

    def phase(self, node, kind):
        return formulae.phase(kind, lambda name: _or_noted(node.inputs[name], self.medium.notes).number)

    def principled(self, node):
        notes = self.medium.notes
        density = self.density(node.inputs["Density"])
        name = node.inputs["Density Attribute"].default_value
        if name in self.grids:
            density = self.product(density, Value(WHITE, name))
        color = self.value(node.inputs["Color"], vector=True)
        grid = color.grid
        name = node.inputs["Color Attribute"].default_value
        if name in self.grids:
            if grid:
                raise NotMapped(f"the product of the grids '{grid}' and '{name}'")
            grid = name
        absorption = _or_noted(node.inputs["Absorption Color"], notes).color
        rgb = [max(c, 0.0) for c in color.color]
        if grid:
            self.colored_by(grid, rgb, absorption)
        phase = self.phase(node, "HENYEY_GREENSTEIN")
        extinction = WHITE if grid else formulae.principled_extinction(rgb, absorption)
        self.parts.append(_Part(density.times(Value(rgb)), density.times(Value(extinction)), phase))
        self.emit(node.inputs["Emission Strength"], node.inputs["Emission Color"])
        self.glow(node)

    def colored_by(self, grid, rgb, absorption):
        """sigma_s = colour * grid * density; with black for the absorption sigma_t is the density."""
        if max(absorption) > 0:
            self.medium.notes.append("'Absorption Color' beside a grid of colours (taken for black)")
        if max(rgb) - min(rgb) > 1e-4 * max(rgb):
            self.medium.notes.append("a 'Color' beside a grid of colours that is not grey (taken for its mean)")
        self.medium.albedo_grid = grid
        self.medium.albedo_scale = sum(rgb) / 3

    def emit(self, strength_socket, color_socket):
        strength = self.value(strength_socket)
        if max(strength.color) <= 0:
            return
        source, output = source_of(color_socket)
        if source is not None and source.bl_idname == "ShaderNodeValToRGB":
            self.emit_ramp(strength, source)
            return
        value = strength.times(value_of(color_socket))
        if max(value.color) <= 0:
            return
        if not value.grid:
            self.medium.notes.append("emission of one strength everywhere; link a grid to it")
            return
        if self.medium.emission:
            raise NotMapped("a second emission")
        most = max(value.color)
        emission = {"grid": value.grid, "scale": most}
        if min(value.color) < most:
            # A ramp is constant beyond its end; emission is not.
            far = 1e4
            emission["ramp"] = [[0.0, BLACK], [far, [far * max(c, 0.0) / most for c in value.color]]]
        self.medium.emission = emission

    def emit_ramp(self, strength, node):
        """Emission of one strength whose colour is a ramp over a grid."""
        if strength.grid:
            raise NotMapped(f"a strength of emission beside the colours of node '{node.name}' that both vary")
        ramp = node.color_ramp
        if ramp.color_mode != "RGB" or ramp.interpolation != "LINEAR":
            raise NotMapped(f"the settings of node '{node.name}'")
        if self.medium.emission:
            raise NotMapped("a second emission")
        points = [[float(e.position), [float(c) for c in list(e.color)[:3]]] for e in ramp.elements]
        if max(points[0][1]) > 0:
            raise NotMapped(f"a colour of node '{node.name}' at 0 that is not black")
        grid = self.value(node.inputs[0])
        if not grid.grid:
            raise NotMapped(f"node '{node.name}' at no grid")
        number = grid.number
        if number <= 0:
            return
        steps = [[p / number, c] for p, c in points]
        if steps[0][0] > 0:
            steps.insert(0, [0.0, BLACK])
        self.medium.emission = {"grid": grid.grid, "scale": strength.number, "ramp": steps}

    # svm/closure.h: radiance 5.67e-8 * 1e-6 / pi * mix(1, T^4, intensity), and 1 is nothing beside T^4.
    def glow(self, node):
        notes = self.medium.notes
        intensity = _or_noted(node.inputs["Blackbody Intensity"], notes).number
        if intensity <= 0:
            return
        tint = _or_noted(node.inputs["Blackbody Tint"], notes).color
        if max(tint) - min(tint) > 1e-4 * max(tint):
            notes.append("a 'Blackbody Tint' that is not grey (taken for its mean)")
        temperature = self.value(node.inputs["Temperature"])
        name = node.inputs["Temperature Attribute"].default_value
        if name in self.grids:
            temperature = self.product(temperature, Value(WHITE, name))
        if not temperature.grid:
            notes.append(f"a black body of one temperature everywhere; there is no grid '{name}'")
        elif temperature.number > 0:
            self.medium.blackbody = {
                "grid": temperature.grid,
                "scale": temperature.number,
                "intensity": intensity * sum(tint) / 3,
                "normalize": False,
            }

    def result(self):
        medium = self.medium
        medium.ax = self.code.text if self.code.made else ""
        parts = [p for p in self.parts if p.extinction is not None and max(p.extinction.color) > 0]
        names = {p.extinction.grid for p in parts}
        if "" in names:
            raise NotMapped("a density that is the same everywhere; link a grid to it")
        if len(names) > 1:
            raise NotMapped(f"densities of several grids ({', '.join(sorted(names))})")
        # A medium that only glows: any grid with a density of 0.
        glowing = (medium.emission or medium.blackbody or {}).get("grid", "")
        medium.grid = names.pop() if names else glowing
        if not medium.grid:
            raise NotMapped("nothing that scatters, absorbs or glows by a grid")
        medium.extinction = [sum(p.extinction.color[i] for p in parts) for i in range(3)]
        lit = [p for p in parts if p.scattering is not None and max(p.scattering.color) > 0]
        medium.scattering = [sum(p.scattering.color[i] for p in lit) for i in range(3)]
        if medium.albedo_grid and len(parts) > 1:
            raise NotMapped("a grid of colours beside another shader")
        if lit:
            medium.phase = self.phase_of(lit)
        return medium

    def phase_of(self, lit):
        weights = {}
        for part in lit:
            key = tuple(part.phase.items())
            weights[key] = weights.get(key, 0.0) + sum(part.scattering.color)
        phases = [dict(key) for key in weights]
        if len(phases) == 1:
            return phases[0]
        if len(phases) > 2 or any(p["type"] not in ("isotropic", "hg") for p in phases):
            raise NotMapped("a sum of phase functions other than two Henyey-Greensteins")
        share = list(weights.values())
        return {
            "type": "two-lobe",
            "g1": phases[0].get("g", 0.0),
            "g2": phases[1].get("g", 0.0),
            "blend": share[1] / sum(share),
        }


def medium_of(tree, grids, vectors=()):
    """The Medium of a material's node tree for a volume with `grids`, some of them `vectors`. Raises NotMapped."""
    node = volume_of(tree)
    if node is None:
        raise NotMapped("a material without a volume shader")
    total = _Sum(grids, vectors)
    total.add(node)
    medium = total.result()
    used = [medium.grid, medium.albedo_grid]
    used += [keys["grid"] for keys in (medium.emission, medium.blackbody) if keys]
    missing = sorted({name for name in used if name and name not in grids and name not in total.code.made})
    if missing:
        has = ", ".join(grids) or "none"
        raise NotMapped(f"the grid{'s' if len(missing) > 1 else ''} {', '.join(missing)}: the volume has {has}")
    return medium


# Blender without a material shows a volume's density by a Principled Volume with its defaults.
def default_medium(grids):
    if "density" not in grids:
        raise NotMapped("no material, and no grid 'density'")
    return Medium("density", [0.5] * 3, WHITE)


@dataclass
class Shining:
    """The light of a surface or a lamp: `color`, times the candelas of an IES texture if there is one."""

    color: list
    profile: object = None


def light_emission(light):
    """The light that a light's nodes describe; without nodes it is white. Raises NotMapped."""
    if not light.use_nodes or light.node_tree is None:
        return Shining(WHITE)
    node = _surface_of(light.node_tree, "ShaderNodeOutputLight")
    if node is None:
        return Shining(BLACK)
    if node.bl_idname != "ShaderNodeEmission":
        raise NotMapped(f"node '{node.name}'")
    return _shining(node.inputs["Strength"], node.inputs["Color"])


def mesh_emission(material):
    """The radiance of a material's surface, BLACK where it does not shine. Raises NotMapped."""
    node = _surface_of(material.node_tree, "ShaderNodeOutputMaterial") if material.use_nodes else None
    if node is None or node.bl_idname not in ("ShaderNodeEmission", "ShaderNodeBsdfPrincipled"):
        return BLACK
    if node.bl_idname == "ShaderNodeEmission":
        strength, color = node.inputs["Strength"], node.inputs["Color"]
    else:
        strength = node.inputs["Emission Strength"]
        color = node.inputs["Emission Color" if "Emission Color" in node.inputs else "Emission"]
    if not strength.links and float(strength.default_value) <= 0:
        return BLACK  # with a strength of 0 the colour does not matter
    emitted = _shining(strength, color)
    if emitted.profile is not None:
        raise NotMapped(f"node '{emitted.profile.name}' on a mesh")
    return emitted.color


def _surface_of(tree, output):
    end = next((n for n in tree.nodes if n.bl_idname == output and n.is_active_output), None)
    return source_of(end.inputs["Surface"])[0] if end is not None else None


def _shining(strength, color):
    value, profile = _profiled(strength)
    value = value.times(value_of(color))
    if value.grid:
        raise NotMapped(f"the attribute '{value.grid}'")
    return Shining(value.color, profile)


def _profiled(socket):
    """(the value of a socket, the IES texture that it is multiplied by or None)"""
    node, _ = source_of(socket)
    kind = node.bl_idname if node is not None else ""
    if kind == "ShaderNodeTexIES":
        if node.inputs["Vector"].links:
            raise NotMapped(f"the vector of node '{node.name}'")
        return value_of(node.inputs["Strength"]), node
    if kind == "ShaderNodeMath" and node.operation == "MULTIPLY" and not node.use_clamp:
        (a, first), (b, second) = _profiled(node.inputs[0]), _profiled(node.inputs[1])
        if first is not None and second is not None:
            raise NotMapped(f"the product of nodes '{first.name}' and '{second.name}'")
        return a.times(b), first if second is None else second
    return value_of(socket), None


@dataclass
class Sky:
    color: list
    image: object = None
    turn: float = 0.0  # degrees about z, counterclockwise from above
    clear: dict | None = None  # `sky` of a dome; its sun is over -y before the turn


def sky_of(world):
    """The light of the world, or None. Raises NotMapped."""
    if not world.use_nodes or world.node_tree is None:
        color = [float(c) for c in world.color]
        return Sky(color) if max(color) > 0 else None
    tree = world.node_tree
    end = next((n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputWorld" and n.is_active_output), None)
    node, _ = source_of(end.inputs["Surface"]) if end is not None else (None, "")
    if node is None:
        return None
    if node.bl_idname not in ("ShaderNodeBackground", "ShaderNodeEmission"):
        raise NotMapped(f"node '{node.name}'")
    strength = value_of(node.inputs["Strength"])
    source, _ = source_of(node.inputs["Color"])
    if source is not None and source.bl_idname == "ShaderNodeTexSky":
        return _clear_sky(source, strength.color) if max(strength.color) > 0 else None
    if source is None or source.bl_idname != "ShaderNodeTexEnvironment":
        color = strength.times(value_of(node.inputs["Color"])).color
        return Sky(color) if max(color) > 0 else None
    if source.projection != "EQUIRECTANGULAR":
        raise NotMapped(f"the projection {source.projection} of node '{source.name}'")
    if source.image is None or max(strength.color) <= 0:
        return None
    return Sky(strength.color, source.image, _turn(source))


# Blender's skies after Nishita; what its newest versions call them.
_CLEAR_SKIES = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")
# Radiance 1 of Blender's sky is 1 W / (m^2 sr) of light as bright as at 555 nm, that is 683 lumens; in that of Scrim's
# sky, 100000 lux are pi.
_SKY_UNIT = 100e3 / (683 * math.pi)


def _clear_sky(texture, color):
    if texture.sky_type not in _CLEAR_SKIES:
        raise NotMapped(f"the type {texture.sky_type} of node '{texture.name}'")
    dust = texture.dust_density if hasattr(texture, "dust_density") else texture.aerosol_density
    keys = {
        "sun_elevation": max(min(math.degrees(texture.sun_elevation), 90.0), -90.0),
        "altitude": max(min(float(texture.altitude), 60000.0), 0.0),
        "air_density": float(texture.air_density),
        "dust_density": float(dust),
        "ozone_density": float(texture.ozone_density),
        "ground_albedo": 0.0,  # Blender's sky is black below the horizon
        "sun_disc": bool(texture.sun_disc),
        "sun_size": max(min(math.degrees(texture.sun_size), 5.0), 0.05),
        "sun_intensity": float(texture.sun_intensity),
    }
    # The sun's rotation is clockwise from +y.
    turn = 180.0 - math.degrees(texture.sun_rotation) + _turn(texture)
    return Sky([_SKY_UNIT * c for c in color], turn=turn, clear=keys)


def _turn(texture):
    mapping, _ = source_of(texture.inputs["Vector"])
    if mapping is None or mapping.bl_idname == "ShaderNodeTexCoord":
        return 0.0
    if mapping.bl_idname != "ShaderNodeMapping":
        raise NotMapped(f"node '{mapping.name}'")
    source, output = source_of(mapping.inputs["Vector"])
    if source is not None and (source.bl_idname != "ShaderNodeTexCoord" or output != "Generated"):
        raise NotMapped(f"node '{source.name}'")
    x, y, z = (float(v) for v in mapping.inputs["Rotation"].default_value)
    if max(abs(x), abs(y)) > 1e-6:
        raise NotMapped(f"a rotation about x or y by node '{mapping.name}'")
    # A point is turned before it is looked up, so the picture turns the other way.
    return math.degrees(z) * (1 if mapping.vector_type == "TEXTURE" else -1)
