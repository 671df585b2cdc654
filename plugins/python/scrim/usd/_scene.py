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
    """`crop`: x0, y0, x1, y1, the part of the picture that UsdRender asks for; None: all of it."""

    scene: dict
    crop: tuple[int, int, int, int] | None


def _drawn(prim: Usd.Prim) -> bool:
    return prim.IsA(UsdVol.Volume) or _meshes.is_solid(prim) or _lights.is_light(prim)


def _link(reading: Reading, light: _lights.Light, name: str, lit: list[tuple[Item, dict]], solids: list[Item]) -> bool:
    """Adds the light to `lights` and `shadows` of the volumes that its lightLink and shadowLink include. Returns
    whether any solid or volume casts shadows in it."""
    for key, link in zip(("lights", "shadows"), light.links(), strict=True):
        for item, volume in lit:
            if item.included(link) and name not in volume[key]:
                volume[key].append(name)
    casting = [item.included(link) for item in solids]
    casts = any(casting) or any(name in volume["shadows"] for _, volume in lit)
    if casts and not all(casting):
        reading.warn(light.prim, "its shadowLink leaves out some solids; all of them cast shadows")
    return casts


def _linked(reading: Reading, lights: list[tuple[dict, _lights.Light]], volumes: list, solids: list[Item]) -> None:
    keys = ("lights", "shadows")
    said = {(volume["name"], key): volume[key] for _, volume in volumes for key in keys if key in volume}
    for _, volume in volumes:
        volume.update({key: [] for key in keys})
    for table, light in lights:
        if not _link(reading, light, table["name"], volumes, solids):
            table["shadows"] = False
    names = {"lights": [table["name"] for table, _ in lights],
             "shadows": [table["name"] for table, _ in lights if table.get("shadows", True)]}
    looks = [volume.get(key, {}) for _, volume in volumes for key in ("medium", "classified")]
    full = any(look.get("scattering") == "full" for look in looks)
    for item, volume in volumes:
        for key in keys:
            if (volume["name"], key) in said:
                volume[key] = said[volume["name"], key]
            elif set(volume[key]) >= set(names[key]):
                del volume[key]
            elif key == "shadows" and full:
                reading.warn(item.prim, "a shadowLink leaves it out; beside full scattering it casts all shadows")
                del volume[key]


def _volumes_at(reading: Reading, frame: int, sidecar: _own.Sidecar) -> list[dict]:
    """Tables of the volumes at another frame, without warnings."""
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
        shines, solid = _lights.is_light(item.prim), _meshes.is_solid(item.prim)
        if item.prim.IsA(UsdVol.Volume):
            if shines:
                reading.warn(item.prim, "the light that it gives as a volume is not rendered")
            volume = _volumes.read(reading, item, exposure, sidecar)
            if volume:
                volumes.append((item, volume))
        elif solid and (shines or reading.options.meshes != "none"):
            mesh = _meshes.read(reading, item, sidecar)
            if mesh:
                meshes.append(mesh)
                solids.append(item)
                if shines:
                    lights.append(_lights.of_mesh(reading, item, exposure, mesh["name"]))
        elif shines and not solid:
            light = _lights.read(reading, item, exposure, sidecar)
            if light:
                lights.append(light)
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
    """Whether anything in the scene gives light."""
    glows = any(
        "classified" in volume or {"emission", "blackbody"} & set(volume.get("medium", {}))
        for volume in scene["volume"]
    )
    return glows or bool(scene.get("light")) or "ambient" in scene
