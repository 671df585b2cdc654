# SPDX-License-Identifier: Apache-2.0
"""UsdLux as [[light]]. A light shines along -z of its own frame; its sizes are those in the world."""

from __future__ import annotations

import math
from collections.abc import Callable

from pxr import Gf, Usd, UsdGeom, UsdLux
from scrim_kit import light_laws, photometry
from scrim_kit.failure import Failure

from . import _colour, _own
from ._reading import Item, Reading, numbers

_EVEN = 1e-4  # relative difference of the scales along axes that counts as none


def is_light(prim: Usd.Prim) -> bool:
    return prim.HasAPI(UsdLux.LightAPI) or prim.IsA(UsdLux.LightFilter)


def _axes(matrix: Gf.Matrix4d) -> list[Gf.Vec3d]:
    return [Gf.Vec3d(matrix.GetRow3(i)) for i in range(3)]


def _facing(matrix: Gf.Matrix4d) -> list[float]:
    """The direction of the light: perpendicular to the frame's x and y, even where the frame is sheared and its -z is
    not."""
    x, y, z = _axes(matrix)
    normal = Gf.Cross(x, y).GetNormalized()
    return numbers(-normal if Gf.Dot(normal, z) > 0 else normal)


def _place(matrix: Gf.Matrix4d) -> list[float]:
    return numbers(matrix.ExtractTranslation())


class Light:
    """One light of the stage at the frame."""

    def __init__(self, reading: Reading, item: Item, scale: float) -> None:
        self.reading, self.item, self.prim, self.scale = reading, item, item.prim, scale
        self.api = UsdLux.LightAPI(item.prim)

    def input(self, name: str, time: float | None = None, otherwise: object = None) -> object:
        return self.reading.get(self.prim.GetAttribute("inputs:" + name), time, otherwise)

    def warn(self, text: str) -> None:
        self.reading.warn(self.prim, text)

    def moving(self, value: Callable[[Gf.Matrix4d], object]) -> object:
        return self.reading.moving(lambda time: value(self.reading.world(self.item, time)))

    def scales(self, time: float) -> list[float]:
        return [axis.GetLength() for axis in _axes(self.reading.world(self.item, time))]

    def strength(self, time: float) -> float:
        """intensity * 2^exposure, as the camera exposes it"""
        strength = self.input("intensity", time) * 2.0 ** self.input("exposure", time) * self.scale
        if strength < 0:
            self.warn("its intensity is below 0, and taken as 0")
        return max(strength, 0.0)

    def color(self, time: float) -> object:
        attribute = self.prim.GetAttribute("inputs:color")
        rgb = numbers(self.input("color", time))
        if self.input("enableColorTemperature", time):
            tint = _colour.temperature(self.input("colorTemperature", time), _colour.space_of(self.reading, attribute))
            rgb = [c * t for c, t in zip(rgb, tint)]
        return _colour.value(self.reading, attribute, rgb)

    def colored(self) -> dict:
        """`color` of a [[light]]; keyed only where all keys are plain numbers, since a key cannot name a colour
        space."""
        out = self.reading.moving(self.color)
        if isinstance(out, dict) and "keys" in out and any(isinstance(v, dict) for _, v in out["keys"]):
            self.warn("its colour changes while the shutter is open; that of the frame is taken")
            out = self.color(self.reading.frame)
        return {} if out == [1.0, 1.0, 1.0] else {"color": out}

    def by(self, law: Callable[[float, float], float]) -> object:
        """The `intensity` that a law gives for (strength, time); keyed where it changes while the shutter is open."""
        return self.reading.moving(lambda time: law(self.strength(time), time))

    def normalized(self, time: float) -> bool:
        return bool(self.input("normalize", time))

    # What each type of light becomes

    def distant(self) -> dict:
        reading = self.reading
        as_irradiance = reading.options.distant == "irradiance"

        def law(strength: float, time: float) -> tuple[float, float]:
            return light_laws.usd_distant(strength, self.input("angle", time), as_irradiance or self.normalized(time))

        angle = float(self.input("angle"))
        if angle > 180:
            self.warn(f"its angle of {angle:g} degrees is rendered as 180")
        reading.note(
            self.prim,
            f"irradiance {law(self.strength(reading.frame), reading.frame)[1]:.4g} on what faces it, times its colour "
            f"(intensity {self.input('intensity'):g}, exposure {self.input('exposure'):g}, angle {angle:g}, "
            f"normalize {'true' if self.normalized(reading.frame) else 'false'}, read as {reading.options.distant})",
        )
        out = {"type": "distant", "direction": self.moving(_facing)}
        out["intensity"] = self.by(lambda strength, time: law(strength, time)[0])
        if angle > 0:
            out["angle"] = min(angle, 180.0)
        return out

    def round_radius(self, time: float, scales: list[float], what: str) -> float:
        """The radius times the geometric mean of the scales. `what`: the warning where the scales differ."""
        if max(scales) - min(scales) > _EVEN * max(scales):
            self.warn(f"its scale differs along axes: {what}")
        return float(self.input("radius", time)) * math.prod(scales) ** (1 / len(scales))

    def sphere_radius(self, time: float) -> float:
        return self.round_radius(time, self.scales(time), "an ellipsoid is rendered as a sphere of the same volume")

    def cone(self) -> tuple[float, float] | None:
        """(half angle, softness) of the cone of ShapingAPI; None: the light has no cone."""
        if not self.prim.HasAPI(UsdLux.ShapingAPI):
            return None
        if self.input("shaping:focus"):
            self.warn("its focus is not rendered")
        if self.profile() and not self.prim.IsA(UsdLux.SphereLight):
            self.warn("its IES profile is not rendered: only a sphere can have one")
        angle = float(self.input("shaping:cone:angle"))
        return (angle, float(self.input("shaping:cone:softness"))) if angle < 180 else None

    def profile(self) -> str | None:
        """The path of the photometric file; "" or None: the light has none."""
        if not self.prim.HasAPI(UsdLux.ShapingAPI):
            return None
        return self.reading.file(self.prim.GetAttribute("inputs:shaping:ies:file"))

    def luminaire(self) -> tuple[dict, float]:
        """(keys of a point or spot with a photometric file, factor on its intensity). The factor is the file's largest
        candela value, divided by the mean of all where the profile is normalized. The vertical angle 0 is -z."""
        path = self.profile()
        if not path:
            return {}, 1.0
        try:
            profile = photometry.Photometry(path)
        except Failure as error:
            self.warn(f"its IES profile is not rendered: {error}")
            return {}, 1.0
        if self.input("shaping:ies:angleScale"):
            self.warn("the angleScale of its IES profile is not rendered")
        factor = profile.largest / (profile.mean if self.input("shaping:ies:normalize") else 1)
        keys = {"ies": path, "direction": self.moving(_facing)}
        keys["up"] = self.moving(lambda matrix: numbers(_axes(matrix)[1].GetNormalized()))
        return keys, factor

    def sphere(self) -> dict:
        cone = self.cone()
        shape, factor = self.luminaire()
        if cone and cone[0] > 90:
            self.warn(f"its cone of {cone[0]:g} degrees to each side is not rendered; it shines to all sides")
            cone = None
        as_point = bool(self.reading.get(self.prim.GetAttribute("treatAsPoint"), otherwise=False))
        radius = self.sphere_radius(self.reading.frame)
        if not cone and not shape and not as_point and radius > 0:
            out = {"type": "area", "shape": "sphere", "radius": self.reading.moving(self.sphere_radius)}
            return self.placed(out)
        if radius <= 0 and not self.normalized(self.reading.frame):
            self.warn("a sphere without a size gives no light unless it is normalized")
        out = {"type": "spot" if cone else "point", "position": self.moving(_place)}
        out["intensity"] = self.by(
            lambda strength, time: (
                factor * light_laws.usd_point(strength, self.sphere_radius(time), self.normalized(time))
            )
        )
        if (cone or shape) and radius > 0 and not as_point:
            what = "a cone" if cone else "an IES profile"
            self.warn(f"a sphere with {what} is rendered as a point: its radius of {radius:g} softens no shadow")
        out |= shape
        if cone:
            if cone[1] > 0:
                self.warn("its cone fades by the cosine between the same two angles, and not by the angle")
            out |= {"direction": self.moving(_facing), "cone": 2 * cone[0], "blend": min(max(cone[1], 0.0), 1.0)}
        return out

    def surface(self, out: dict) -> dict:
        out["intensity"] = self.by(lambda strength, time: strength)
        if self.normalized(self.reading.frame):
            out["normalize"] = True
        return out

    def placed(self, out: dict) -> dict:
        return self.surface({**out, "position": self.moving(_place)})

    def flat(self, shape: str) -> dict:
        cone = self.cone()
        if cone and cone[0] < 90:
            self.warn(f"its cone of {cone[0]:g} degrees to each side is not rendered; it shines to all of one side")
        x, y, _ = _axes(self.reading.world(self.item, self.reading.frame))
        if abs(Gf.Dot(x.GetNormalized(), y.GetNormalized())) > _EVEN:
            self.warn("it is sheared, but rendered with right angles")
        out = {"type": "area", "shape": shape, "direction": self.moving(_facing)}
        out["up"] = self.moving(lambda matrix: numbers(_axes(matrix)[1].GetNormalized()))
        return self.placed(out)

    def rectangle(self) -> dict:
        out = self.flat("rectangle")
        out["width"] = self.reading.moving(lambda t: float(self.input("width", t)) * self.scales(t)[0])
        out["height"] = self.reading.moving(lambda t: float(self.input("height", t)) * self.scales(t)[1])
        picture = self.texture()
        return {**out, "slide": picture} if picture else out

    def disk(self) -> dict:
        def radius(time: float) -> float:
            return self.round_radius(time, self.scales(time)[:2], "an ellipse is rendered as a disk of the same area")

        out = self.flat("disk")
        return {**out, "radius": self.reading.moving(radius)}

    def cylinder(self) -> dict:
        """Its length is along x, as that of a scene's cylinder is across `up`."""

        def radius(time: float) -> float:
            return self.round_radius(time, self.scales(time)[1:], "an elliptic cylinder is rendered as a round one")

        out = self.flat("cylinder")
        if self.reading.get(self.prim.GetAttribute("treatAsLine"), otherwise=False):
            self.warn("treatAsLine is not read: it has its radius")
        out["width"] = self.reading.moving(lambda t: float(self.input("length", t)) * self.scales(t)[0])
        return {**out, "radius": self.reading.moving(radius)}

    def texture(self) -> dict | None:
        attribute = self.prim.GetAttribute("inputs:texture:file")
        file = self.reading.file(attribute)
        if not file:
            return None
        space = attribute.GetColorSpace()
        return {"file": file, "colorspace": space} if space and space != "auto" else {"file": file}

    def dome(self) -> dict:
        layout = self.input("texture:format", otherwise="automatic")
        if layout not in ("automatic", "latlong"):
            self.warn(f"its picture of format '{layout}' is read as latlong")
        portals = self.prim.GetRelationship("portals")
        if portals and portals.GetTargets():
            self.warn("portals are not needed, and not read")
        matrix = self.reading.world(self.item, self.reading.frame)
        if any(not Gf.IsClose(self.reading.world(self.item, t), matrix, 1e-9) for t in self.reading.times):
            self.warn("it turns while the shutter is open, and is rendered as it stands at the frame")
        if matrix.GetDeterminant() < 0:
            self.warn("it is mirrored, but rendered without mirroring")
        up, turn = dome_frame(self.pole() * matrix.RemoveScaleShear())
        out = {"type": "dome", "up": up, "rotation": turn, "intensity": self.by(lambda strength, time: strength)}
        picture = self.texture()
        return {**out, "texture": picture} if picture else out

    def pole(self) -> Gf.Matrix4d:
        """A DomeLight's top is +y; a DomeLight_1 may turn it to +z."""
        axis = "Y"
        if self.prim.IsA(UsdLux.DomeLight_1):
            axis = str(self.reading.get(self.prim.GetAttribute("poleAxis"), otherwise="scene"))
            if axis == "scene":
                axis = str(UsdGeom.GetStageUpAxis(self.reading.stage))
        turn = Gf.Rotation(Gf.Vec3d.XAxis(), 90 if axis == "Z" else 0)
        return Gf.Matrix4d(1).SetRotate(turn)

    def links(self) -> tuple[Usd.CollectionMembershipQuery, Usd.CollectionMembershipQuery]:
        return (
            self.api.GetLightLinkCollectionAPI().ComputeMembershipQuery(),
            self.api.GetShadowLinkCollectionAPI().ComputeMembershipQuery(),
        )

    def table(self, name: str, kind: dict) -> dict:
        out = {"name": name, **kind, **self.colored()}
        self.say_what_is_not()
        if self.prim.HasAPI(UsdLux.ShadowAPI) and not self.input("shadow:enable"):
            out["shadows"] = False
        return out

    def say_what_is_not(self) -> None:
        if self.prim.IsA(UsdLux.NonboundableLightBase) and self.cone():
            self.warn("its cone is not rendered")
        for name in ("diffuse", "specular"):
            if self.input(name, otherwise=1.0) != 1.0:
                self.warn(f"its {name} multiplier is not for volumes, and not read")
        if self.api.GetFiltersRel().GetTargets():
            self.warn("its light filters are not rendered")
        if self.prim.HasAPI(UsdLux.ShadowAPI):
            for name, plain in (("color", Gf.Vec3f(0)), ("distance", -1.0), ("falloff", -1.0)):
                if self.input("shadow:" + name) != plain:
                    self.warn(f"shadow:{name} is not rendered")


def dome_frame(matrix: Gf.Matrix4d) -> tuple[list[float], float]:
    """(`up`, `rotation`) of the scene's dome whose frame is `matrix`. In a scene, `rotation` turns the middle of the
    picture about +y, from +z towards +x; the shortest turn that takes +y to `up` follows."""
    up = matrix.TransformDir(Gf.Vec3d(0, 1, 0)).GetNormalized()
    middle = matrix.TransformDir(Gf.Vec3d(0, 0, 1)).GetNormalized()
    if up[1] < -1 + 1e-9:  # upside down: half a turn about x
        back = Gf.Rotation(Gf.Vec3d.XAxis(), 180)
    else:
        back = Gf.Rotation(up, Gf.Vec3d(0, 1, 0))
    x, _, z = back.TransformDir(middle)
    return numbers(up), math.degrees(math.atan2(x, z))


_KINDS: list[tuple[type, Callable[[Light], dict]]] = [
    (UsdLux.DistantLight, Light.distant),
    (UsdLux.SphereLight, Light.sphere),
    (UsdLux.RectLight, Light.rectangle),
    (UsdLux.DiskLight, Light.disk),
    (UsdLux.CylinderLight, Light.cylinder),
    (UsdLux.DomeLight, Light.dome),
    (UsdLux.DomeLight_1, Light.dome),
]


def read(reading: Reading, item: Item, scale: float, sidecar: _own.Sidecar) -> tuple[dict, Light] | None:
    """A [[light]]; None where the light cannot be mapped: a warning says so. `scale`: the camera's exposure."""
    prim = item.prim
    if prim.IsA(UsdLux.LightFilter):
        return None  # the light that the filter belongs to has the warning
    kind = next((made for schema, made in _KINDS if prim.IsA(schema)), None)
    if kind is None:
        reading.warn(prim, f"lights of type {prim.GetTypeName() or 'none'} are not rendered")
        return None
    light = Light(reading, item, scale)
    out = light.table(reading.name(item), kind(light))
    _own.merge(out, _own.attributes(reading, prim))
    _own.merge(out, sidecar.of(prim))
    if "sky" in out:
        out.pop("texture", None)  # the picture is for renderers that do not know the sky
    return out, light


def of_mesh(reading: Reading, item: Item, scale: float, mesh: str) -> tuple[dict, Light]:
    """The [[light]] of a solid with MeshLightAPI. `mesh`: the name of the solid's [[mesh]]."""
    light = Light(reading, item, scale)
    return light.table(mesh, light.surface({"type": "area", "shape": "mesh", "mesh": mesh})), light
