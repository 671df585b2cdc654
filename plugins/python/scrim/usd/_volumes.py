# SPDX-License-Identifier: Apache-2.0
"""UsdVol.Volume and its OpenVDBAssets as [[volume]].

A grid is placed by the transform in its file, then by a matrix of the stage. Where the field's prim is below its
Volume, that is the prim's local-to-world matrix. A prim elsewhere may be the field of several Volumes: the matrix is
then its own local transform followed by the local-to-world matrix of the Volume.

Where `scrim:file`, `scrim:grids` or `scrim:source` says what the volume is made of, its fields are not read, and the
Volume's own matrix places it.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass

from pxr import Gf, Sdf, Usd, UsdGeom, UsdVol
from scrim_kit import media

from . import _materials, _motion, _own
from ._reading import Item, Reading

# How Storm shows a volume without a material: albedo 0.18, isotropic phase.
DEFAULT_ALBEDO = [0.18, 0.18, 0.18]
_VELOCITIES = ("velocity", "vel", "v")
_ASSETS = ("file", "grids", "source")  # keys that say what a volume is made of
_FREE = ("parameters", "grids")  # tables whose keys are the user's


@dataclass
class Field:
    prim: Usd.Prim
    file: str
    grid: str
    matrix: Callable[[float], Gf.Matrix4d]


def _placed(reading: Reading, item: Item, prim: Usd.Prim) -> Callable[[float], Gf.Matrix4d]:
    if prim.GetPath().HasPrefix(item.prim.GetPath()):

        def below(time: float) -> Gf.Matrix4d:
            matrix = reading.local_to_world(prim, time)
            return matrix * item.within(time) if item.within else matrix

        return below

    def elsewhere(time: float) -> Gf.Matrix4d:
        own = UsdGeom.Xformable(prim).GetLocalTransformation(Usd.TimeCode(time))
        return Gf.Matrix4d(own) * reading.world(item, time)

    return elsewhere


def _field(reading: Reading, item: Item, channel: str, path: Sdf.Path) -> Field | None:
    prim = reading.stage.GetPrimAtPath(path)
    if not prim or not prim.IsA(UsdVol.OpenVDBAsset):
        kind = prim.GetTypeName() if prim else "nothing"
        reading.warn(item.prim, f"field '{channel}' is {path}, {kind} and not an OpenVDBAsset, and is not read")
        return None
    asset = UsdVol.OpenVDBAsset(prim)
    file = reading.file(asset.GetFilePathAttr())
    if not file:
        reading.warn(prim, f"it has no file at frame {reading.frame:g}, and is not read")
        return None
    name = reading.get(asset.GetFieldNameAttr(), otherwise="")
    index = reading.get(asset.GetFieldIndexAttr())
    return Field(prim, file, name if index is None else f"{name}[{index}]", _placed(reading, item, prim))


def _fields(reading: Reading, item: Item) -> dict[str, Field]:
    paths = UsdVol.Volume(item.prim).GetFieldPaths()
    read = {channel: _field(reading, item, channel, path) for channel, path in sorted(paths.items())}
    return {channel: field for channel, field in read.items() if field}


def _density(reading: Reading, item: Item, fields: dict[str, Field], wanted: str | None) -> str | None:
    """The channel that is extinction; None where none is found: a warning says so."""
    if not fields:
        reading.warn(item.prim, "it has no field that can be read, and is not rendered")
        return None
    if wanted is not None:
        named = [c for c, f in fields.items() if wanted in (c, f.grid)]
        return named[0] if named else next(iter(fields))
    if "density" in fields or len(fields) == 1:
        return "density" if "density" in fields else next(iter(fields))
    by_grid = [c for c, f in fields.items() if f.grid.split("[")[0] == "density"]
    if len(by_grid) == 1:
        return by_grid[0]
    reading.warn(
        item.prim,
        f"none of its fields {', '.join(fields)} is called density, and it is not rendered; "
        "scrim:density:grid says which is extinction",
    )
    return None


def _medium(reading: Reading, item: Item, own: dict) -> None:
    if "classified" in own:
        return
    medium = own.setdefault("medium", {})
    phase = medium.get("phase")
    if isinstance(phase, dict) and "g" in phase:
        phase.setdefault("type", "hg")
    if not medium or ("albedo" not in medium and set(medium) <= {"scattering"}):
        reading.warn(
            item.prim,
            "albedo 0.18, isotropic and extinction = grid value are taken, unless a material, scrim:albedo, "
            "scrim:g, scrim:density:scale or a side-car say what it is made of",
        )
    if not isinstance(medium.get("albedo"), (list, dict)):
        grey = medium.get("albedo", DEFAULT_ALBEDO)
        medium["albedo"] = [float(grey)] * 3 if isinstance(grey, (int, float)) else copy.copy(grey)


class Mapping:
    """One Volume of the stage at the frame."""

    def __init__(self, reading: Reading, item: Item, fields: dict[str, Field], density: str) -> None:
        self.reading, self.item, self.fields = reading, item, fields
        self.first = fields[density]
        self.density = density
        self.used = {density}
        # Fields of one file: grids have their names in the file. Fields of several files: those of their channels.
        self.several = any(field.file != self.first.file for field in fields.values())
        self.unnamed: dict[str, str] = {}

    def grid(self, name: str) -> str:
        """The name in the scene of a channel of the Volume, or of a grid of its file."""
        field = self.fields.get(name)
        if field is None:
            if self.several:
                self.unnamed[name] = f"{self.first.file}:{name}"
            return name
        self._check_place(name, field)
        self.used.add(name)
        return name if self.several else field.grid

    def _check_place(self, channel: str, field: Field) -> None:
        if not Gf.IsClose(field.matrix(self.reading.frame), self.first.matrix(self.reading.frame), 1e-9):
            self.reading.warn(
                self.item.prim, f"field '{channel}' stands elsewhere than the density, and is read where that is"
            )

    def _files(self) -> dict:
        """`file`; where the fields are of several files, `grids`."""
        if not self.several:
            return {"file": self.first.file}
        used = [self.density, *sorted(self.used - {self.density})]
        fields = {channel: self.fields[channel] for channel in used}
        named = {c: f"{f.file}:{f.grid}" if f.grid else f.file for c, f in fields.items()}
        return {"grids": {**named, **self.unnamed}}

    def name_grids(self, table: dict) -> None:
        """Replaces channels by names of grids in the values of `scrim:*` and of the side-car."""
        for key, value in table.items():
            if not isinstance(value, dict) or key in _FREE:
                continue
            grid = value.get("grid")
            if isinstance(grid, str):
                value["grid"] = self.grid(grid)
            elif isinstance(grid, list):  # the components of a velocity
                value["grid"] = [self.grid(name) for name in grid]
            self.name_grids(value)

    def velocity(self, own: dict) -> None:
        channel = next((c for c in _VELOCITIES if c in self.fields), None)
        if channel is None or "velocity" in own:
            return
        if len(self.reading.times) == 1:
            self.used.add(channel)  # without a shutter a velocity changes nothing
        else:
            own["velocity"] = {"grid": self.grid(channel), "unit": "second"}

    def read(self, own: dict) -> dict:
        self.name_grids(own)
        self.velocity(own)
        if "ax" in own or "ax_file" in own:
            self.used |= set(self.fields)  # an expression may read any of them
        out = {"name": self.reading.name(self.item), **self._files()}
        place = _motion.transform(self.reading, self.item, self.first.matrix)
        if place and "transform" not in own:
            out["transform"] = place
        grid = self.density if self.several else self.first.grid
        out["density"] = {"grid": grid} if grid else {}
        _own.merge(out, own)
        for channel in self.fields:
            if channel not in self.used:
                self.reading.warn(
                    self.item.prim,
                    f"field '{channel}' is not used; scrim:emission:grid or scrim:blackbody:grid = \"{channel}\" "
                    "would say what it is",
                )
        return out


def _of_own_asset(reading: Reading, item: Item, own: dict) -> dict:
    """A [[volume]] whose file, grids or source are said by `own`."""
    out = {"name": reading.name(item)}
    place = _motion.transform(reading, item, lambda time: reading.world(item, time))
    if place and "transform" not in own:
        out["transform"] = place
    _own.merge(out, own)
    return out


def _said_by(reading: Reading, item: Item, fields: dict[str, Field] | None, own: dict) -> dict:
    """Keys of a [[volume]]: those of the material, replaced by `own`, those of `scrim:*` and of the side-car. Emission
    and black bodies of grids that are no fields of the Volume are left out, as renderers do; `fields`: None where they
    are not read."""
    material = _materials.of(reading, item.prim) if "classified" not in own else None
    if material is None:
        return own
    for key in ("emission", "blackbody", "albedo"):
        table = material.medium.get(key)
        name = table.get("grid") if isinstance(table, dict) else None
        if name is None or fields is None or name in fields:
            continue
        if key == "albedo":
            material.medium[key] = [min(table["scale"], 1.0)] * 3
        else:
            del material.medium[key]
        if name not in material.unsaid:
            reading.warn(item.prim, f"its material takes {key} from '{name}', which is no field of it, and is left out")
    if fields is not None and material.density.get("grid") not in fields:
        material.density.pop("grid", None)
    said = {"density": material.density, "medium": material.medium}
    for key, value in own.get("medium", {}).items():  # albedo, phase and glow: `own` replaces them whole
        if key in ("albedo", "phase") or (isinstance(value, dict) and "grid" in value):
            said["medium"].pop(key, None)
    _own.merge(said, own)
    if not {"scattering", "octaves"} & set(own.get("medium", {})) and "shadows" not in own:
        _scatter_as_needed(reading, item, said["medium"])
    return said


def _scatter_as_needed(reading: Reading, item: Item, medium: dict) -> None:
    """`scattering` of a material, which has no word for it."""
    albedo = medium["albedo"]
    if isinstance(albedo, dict):
        albedo = albedo["rgb"] if "rgb" in albedo else [albedo.get("scale", 1.0)]
    most = max(albedo) if isinstance(albedo, list) else albedo
    if media.scattering_of([most]) != "full":
        return
    medium["scattering"] = "full"
    reading.warn(
        item.prim,
        f'its material scatters {min(most, 1.0):.0%} of what it takes from light: scattering = "full" is taken, since '
        "light that scatters once would leave dense smoke more than half a stop too dark; "
        'scrim:scattering = "single" renders faster',
    )


def _scale_by(medium: dict, key: str, name: str, factor: float) -> None:
    table = medium.get(key)
    if isinstance(table, dict):
        table[name] = table.get(name, 1.0) * factor


def _mapped(reading: Reading, item: Item, own: dict) -> dict | None:
    made = any(key in own for key in _ASSETS)
    fields = None if made else _fields(reading, item)
    own = _said_by(reading, item, fields, own)
    if fields is None:
        _medium(reading, item, own)
        return _of_own_asset(reading, item, own)
    density = _density(reading, item, fields, own.get("density", {}).get("grid"))
    if density is None:
        return None
    if abs(fields[density].matrix(reading.frame).GetDeterminant()) < 1e-30:
        reading.warn(item.prim, "its transform makes it flat, and it is not rendered")
        return None
    _medium(reading, item, own)
    return Mapping(reading, item, fields, density).read(own)


def read(reading: Reading, item: Item, exposure: float, sidecar: _own.Sidecar) -> dict | None:
    """A [[volume]]; None where the Volume cannot be mapped: a warning says so."""
    own = _own.attributes(reading, item.prim, of_volume=True)
    _own.merge(own, sidecar.of(item.prim, of_volume=True))
    out = _mapped(reading, item, own)
    if out and exposure != 1 and isinstance(out.get("medium"), dict):  # lights have the exposure, too
        _scale_by(out["medium"], "emission", "scale", exposure)
        _scale_by(out["medium"], "blackbody", "intensity", exposure)
    return out
