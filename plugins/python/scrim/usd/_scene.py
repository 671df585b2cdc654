# SPDX-License-Identifier: Apache-2.0
"""A stage at a frame as a scene: the whole of it, on one page."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pxr import Usd, UsdGeom, UsdVol

from .._errors import InputError
from . import _camera, _framing, _lights, _meshes, _own, _settings, _volumes
from ._reading import Item, Messages, Options, Reading


@dataclass
class FrameScene:
    """`crop`: x0, y0, x1, y1, where UsdRender asks for a part of the picture."""

    scene: dict
    crop: tuple[int, int, int, int] | None


def _drawn(prim: Usd.Prim) -> bool:
    return prim.IsA(UsdVol.Volume) or _meshes.is_solid(prim) or _lights.is_light(prim)


def _link(reading: Reading, light: _lights.Light, name: str, lit: list[tuple[Item, dict]], solids: list[Item]) -> bool:
    """lightLink as `lights` of volumes. Whether anything throws shadows, as shadowLink says."""
    by_light, by_shadow = light.links()
    for item, volume in lit:
        if item.included(by_light) and name not in volume["lights"]:
            volume["lights"].append(name)
    casting = [item.included(by_shadow) for item in [i for i, _ in lit] + solids]
    if any(casting) and not all(casting):
        reading.warn(light.prim, "its shadowLink leaves out some solids or volumes; all of them cast shadows")
    return any(casting)


def _linked(reading: Reading, lights: list[tuple[dict, _lights.Light]], volumes: list, solids: list[Item]) -> None:
    said = {volume["name"]: volume["lights"] for _, volume in volumes if "lights" in volume}
    for _, volume in volumes:
        volume["lights"] = []
    for table, light in lights:
        if not _link(reading, light, table["name"], volumes, solids):
            table["shadows"] = False
    for _, volume in volumes:
        if volume["name"] in said:
            volume["lights"] = said[volume["name"]]
        elif len(volume["lights"]) == len(lights):
            del volume["lights"]


def _volumes_at(reading: Reading, frame: int, sidecar: _own.Sidecar) -> list[dict]:
    """Volumes of another frame; of what cannot be mapped there is no word."""
    quiet = Reading(reading.stage, frame, replace(reading.options), Messages(), reading.folder)
    read = [_volumes.read(quiet, item, 1.0, sidecar) for item in quiet.items(lambda prim: prim.IsA(UsdVol.Volume))]
    return [volume for volume in read if volume]


def scene_at(
    stage: Usd.Stage, frame: float, options: Options, sidecar: _own.Sidecar, messages: Messages, folder: str
) -> FrameScene:
    reading = Reading(stage, frame, replace(options), messages, folder)
    scene: dict = {"scene_version": 2}
    settings = _settings.read(reading, scene)
    camera = _camera.prim_of(reading, settings)
    shutter = _camera.shutter_of(reading, camera, settings) if camera else None
    if shutter:
        reading.open_shutter(*shutter)
    scene["camera"] = _camera.read(reading, camera, settings) if camera else {}
    exposure = _camera.exposure_scale(reading, camera) if camera else 1.0

    volumes, lights, meshes, solids = [], [], [], []
    for item in reading.items(_drawn):
        if _lights.is_light(item.prim) and item.prim.IsA(UsdGeom.Gprim):
            reading.warn(item.prim, "the light that it gives as a surface or a volume is not rendered")
        if item.prim.IsA(UsdVol.Volume):
            volume = _volumes.read(reading, item, exposure, sidecar)
            if volume:
                volumes.append((item, volume))
        elif _lights.is_light(item.prim) and not item.prim.IsA(UsdGeom.Gprim):
            light = _lights.read(reading, item, exposure, sidecar)
            if light:
                lights.append(light)
        elif reading.options.meshes != "none":
            mesh = _meshes.read(reading, item, sidecar)
            if mesh:
                meshes.append(mesh)
                solids.append(item)
    if not volumes:
        raise InputError(f"the stage shows no volume at frame {frame:g}")
    if camera is None:
        scene["camera"] = _framing.camera(reading, settings, lambda other: _volumes_at(reading, other, sidecar))
    crop = _camera.window(scene["camera"], settings)
    _linked(reading, lights, volumes, solids)
    scene["volume"] = [volume for _, volume in volumes]
    for name, tables in (("light", [table for table, _ in lights]), ("mesh", meshes)):
        if tables:
            scene[name] = tables
    scene.setdefault("output", {}).setdefault("fps", float(stage.GetTimeCodesPerSecond()))
    if camera:
        _own.merge(scene["camera"], sidecar.of(camera))
    _own.merge(scene, sidecar.scene)
    if not _shines(scene):
        reading.warn("/", "it has no light, and nothing that glows: the volumes are black")
    return FrameScene(scene, crop)


def _shines(scene: dict) -> bool:
    """Whether anything in it gives light."""
    glows = any(
        "classified" in volume or {"emission", "blackbody"} & set(volume.get("medium", {}))
        for volume in scene["volume"]
    )
    return glows or bool(scene.get("light")) or "ambient" in scene
