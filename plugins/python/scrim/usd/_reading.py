# SPDX-License-Identifier: Apache-2.0
"""What all parts of the reader share: the stage at a frame, its transforms, warnings, and the folder for files."""

from __future__ import annotations

import hashlib
import os
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pxr import Gf, Sdf, Tf, Usd, UsdGeom
from scrim_kit.frames import pattern_of
from scrim_kit.names import Names

from .._errors import InputError

SHUTTER_TIMES = 9  # at which whatever moves is read while the shutter is open; straight lines between


@dataclass
class Options:
    """What the caller chose; see `scrim.usd.open`."""

    camera: str | None = None
    settings: str | None = None
    purpose: tuple[str, ...] | None = None
    sidecar: str | os.PathLike[str] | None = None
    distant: str = "radiance"
    meshes: str = "holdout"
    resolution: tuple[int, int] | None = None


@dataclass
class Messages:
    """Warnings and notes. A text is kept once, however many frames give it."""

    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def warn(self, prim: object, text: str) -> None:
        self._add(self.warnings, prim, text)

    def note(self, prim: object, text: str) -> None:
        self._add(self.notes, prim, text)

    @staticmethod
    def _add(to: list[str], prim: object, text: str) -> None:
        line = f"{prim.GetPath() if isinstance(prim, Usd.Prim) else prim}: {text}"
        if line not in to:
            to.append(line)


@dataclass
class Item:
    """A prim that is to be rendered. `suffix`: of its name. `within(time)`: for an instance of a PointInstancer, the
    matrix that follows the prim's own. `linked`: the path of that instancer, which collections of lights may name."""

    prim: Usd.Prim
    suffix: str = ""
    within: Callable[[float], Gf.Matrix4d] | None = None
    linked: Sdf.Path | None = None

    def names(self) -> list[str]:
        """Names for the item, best first: PRIM, PARENT_PRIM, and so on up to the root."""
        parts = [path.name for path in self.prim.GetPath().GetPrefixes()]
        return ["_".join(parts[-count:]) + self.suffix for count in range(1, len(parts) + 1)]

    def included(self, query: Usd.CollectionMembershipQuery) -> bool:
        return query.IsPathIncluded(self.linked or self.prim.GetPath())


class Reading:
    """A stage at one frame. `times`: the time codes at which moving things are read; without a shutter only the
    frame."""

    def __init__(self, stage: Usd.Stage, frame: float, options: Options, messages: Messages, folder: str) -> None:
        self.stage, self.frame, self.options, self.folder = stage, frame, options, folder
        self.warn, self.note = messages.warn, messages.note
        self.times = [frame]
        self._names = Names()
        self._caches: dict[float, UsdGeom.XformCache] = {}

    def open_shutter(self, opens: float, closes: float) -> None:
        step = (closes - opens) / (SHUTTER_TIMES - 1)
        self.times = [self.frame + opens + i * step for i in range(SHUTTER_TIMES)]

    def local_to_world(self, prim: Usd.Prim, time: float) -> Gf.Matrix4d:
        if time not in self._caches:
            self._caches[time] = UsdGeom.XformCache(Usd.TimeCode(time))
        return Gf.Matrix4d(self._caches[time].GetLocalToWorldTransform(prim))

    def name(self, item: Item) -> str:
        """The name of an item in the scene. No other item gets it."""
        return self._names.of(*item.names())

    def world(self, item: Item, time: float) -> Gf.Matrix4d:
        matrix = self.local_to_world(item.prim, time)
        return matrix * item.within(time) if item.within else matrix

    def moving(self, value: Callable[[float], object]) -> object:
        """The value at the frame, or keys where it changes while the shutter is open."""
        if len(self.times) > 1:
            values = [value(time) for time in self.times]
            if any(v != values[0] for v in values):
                return {"keys": [[time, v] for time, v in zip(self.times, values)]}
        return value(self.frame)

    def get(self, attribute: Usd.Attribute, time: float | None = None, otherwise: object = None) -> object:
        value = attribute.Get(Usd.TimeCode(self.frame if time is None else time)) if attribute else None
        return otherwise if value is None else value

    def file(self, attribute: Usd.Attribute) -> str:
        """The path of an asset as a scene names it; "" where there is none. A file within a .usdz is first copied
        into the folder of the reading."""
        asset = self.get(attribute)
        if asset is None or not asset.path:
            return ""
        path = asset.resolvedPath
        if not path:
            layers = [spec.layer for spec in attribute.GetPropertyStack(Usd.TimeCode(self.frame))]
            path = Sdf.ComputeAssetPathRelativeToLayer(layers[0], asset.path) if layers else asset.path
        packed = re.fullmatch(r"(.*\.usdz)\[([^\]]+)\]", path)
        if packed:
            path = self._unpacked(*packed.groups())
        return pattern_of(path)

    def _unpacked(self, archive: str, member: str) -> str:
        # Archives in several folders may have one name: each has a folder of its own, the same in all frames.
        own = hashlib.sha256(os.fsencode(os.path.abspath(archive))).hexdigest()[:16]
        folder = os.path.join(self.folder, own, os.path.basename(archive))
        path = os.path.join(folder, member)
        if not os.path.exists(path):
            try:
                with zipfile.ZipFile(archive) as file:
                    file.extract(member, folder)
            except (OSError, KeyError, zipfile.BadZipFile) as problem:
                raise InputError(f"{archive}[{member}]: {problem}") from problem
        return path

    def items(self, wanted: Callable[[Usd.Prim], bool]) -> Iterator[Item]:
        """All visible prims of the purposes that were asked for, those of instances included."""
        purposes = self.purposes()
        for item in self._below(self.stage.GetPseudoRoot(), Usd.PrimDefaultPredicate):
            if not wanted(item.prim):
                continue
            imageable = UsdGeom.Imageable(item.prim)
            if imageable.ComputeVisibility(Usd.TimeCode(self.frame)) == UsdGeom.Tokens.invisible:
                continue
            if imageable.ComputePurpose() in purposes:
                yield item

    def purposes(self) -> tuple[str, ...]:
        return self.options.purpose or ("default", "render")

    def _below(self, root: Usd.Prim, predicate: object) -> Iterator[Item]:
        prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate)))
        for prim in prims:
            if prim.IsA(UsdGeom.PointInstancer):
                prims.PruneChildren()
                yield from self._instances(prim)
            elif prim != root or not prim.IsPseudoRoot():
                yield Item(prim)

    def _instances(self, prim: Usd.Prim) -> Iterator[Item]:
        instancer = UsdGeom.PointInstancer(prim)
        base = Usd.TimeCode(self.frame)
        indices = self.get(instancer.GetProtoIndicesAttr(), otherwise=[])
        mask = list(instancer.ComputeMaskAtTime(base))
        prototypes = instancer.GetPrototypesRel().GetForwardedTargets()

        def place(time: float) -> list[Gf.Matrix4d]:
            return instancer.ComputeInstanceTransformsAtTime(
                Usd.TimeCode(time),
                base,
                UsdGeom.PointInstancer.IncludeProtoXform,
                UsdGeom.PointInstancer.IgnoreMask,
            )

        placed = {time: place(time) for time in self.times if len(indices)}
        if placed and self.frame not in placed:
            placed[self.frame] = place(self.frame)
        if any(len(matrices) != len(indices) for matrices in placed.values()):
            self.warn(prim, "its instances have no place or no prototype, and are left out")
            return
        below: dict[int, list[Item]] = {}
        for number, index in enumerate(indices):
            if mask and not mask[number]:
                continue
            root = self.stage.GetPrimAtPath(prototypes[index])
            if index not in below:
                below[index] = list(self._below(root, Usd.PrimIsActive & Usd.PrimIsLoaded)) if root else []
            for item in below[index]:
                yield self._instance(prim, root, item, number, placed)

    def _instance(
        self, prim: Usd.Prim, root: Usd.Prim, item: Item, number: int, placed: dict[float, list[Gf.Matrix4d]]
    ) -> Item:
        def within(time: float) -> Gf.Matrix4d:
            inner = item.within(time) if item.within else Gf.Matrix4d(1)
            to_root = self.local_to_world(root, time).GetInverse()
            return inner * to_root * placed[time][number] * self.local_to_world(prim, time)

        return Item(item.prim, f"{item.suffix}_{number}", within, prim.GetPath())


def opened_stage(path: str | os.PathLike[str]) -> Usd.Stage:
    text = os.fspath(path)
    if not os.path.isfile(text):
        raise InputError(f"{text}: no such file")
    try:
        return Usd.Stage.Open(text)
    except Tf.ErrorException as problem:
        raise InputError(f"{text}: OpenUSD cannot read it: {' '.join(str(problem).split())}") from problem


def frames_of(stage: Usd.Stage) -> list[int]:
    """The whole time codes of the stage's range; [1] where it has none."""
    if not stage.HasAuthoredTimeCodeRange():
        return [1]
    first, last = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    return list(range(int(-(-first // 1)), int(last // 1) + 1)) or [int(first)]


def rows(matrix: Gf.Matrix4d) -> list[list[float]]:
    """A matrix of USD, for row vectors, as one of a scene, for column vectors."""
    return [[float(matrix[column][row]) for column in range(4)] for row in range(4)]


def numbers(vector: object) -> list[float]:
    return [float(v) for v in vector]
