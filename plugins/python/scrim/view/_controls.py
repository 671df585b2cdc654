# SPDX-License-Identifier: Apache-2.0
"""The controls of a scene, as data: one for each key that the page can change. The page draws them.

Ranges of sliders are usual values, not limits: the library checks a value when the scene is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from . import _code, _handles, _keys, _lens, _phases, _shading
from ._control_maker import Control, Group, Maker, is_triple, read
from ._document import name_of
from ._messages import is_number

_QUALITIES = ("draft", "standard", "high", "ultra")
# The errors that these qualities promise, first for media, then for classified volumes: `scrim help render`.
_PROMISES = (0.03, 0.01, 0.003, 0.001), (0.05, 0.02, 0.01, 0.005)
_WHITE = [1.0, 1.0, 1.0]
# What the intensity of a light is: `scrim help light`.
_QUANTITIES = {"distant": "irradiance", "area": "radiance", "dome": "radiance"} | dict.fromkeys(
    ("point", "spot", "projector"), "radiant intensity"
)


def _add_sky(make: Maker) -> None:
    """The place of the sun, and what is in the air."""
    place = ("sky", "sun_elevation")
    make.add("sun elevation", "number", place, _handles.SUN_ELEVATION, least=-10.0, most=90.0, unit="°")
    for part in ("air", "dust", "ozone"):
        make.add(part, "number", ("sky", f"{part}_density"), 1.0, least=0.0, most=10.0)
    make.add("altitude", "number", ("sky", "altitude"), 0.0, least=0.0, most=20000.0, unit="m")
    make.add("sun", "switch", ("sky", "sun_disc"), True)
    make.add("sun intensity", "number", ("sky", "sun_intensity"), 1.0, least=0.0, most=10.0)


def _light(index: int, light: Mapping, up: np.ndarray) -> Group:
    name = name_of("light", index, light)
    make = Maker(light, ("light", index), f"light.{name}")
    kind = light.get("type", "")
    factor, stops = ({"layer": f"light.{name}", "law": law} for law in ("factor", "stops"))
    usual = {"least": 0.01, "most": 1000.0, "log": True, "zero": True}
    make.add("intensity", "number", ("intensity",), 1.0, unit=_QUANTITIES.get(kind, ""), **usual, **factor)
    make.add("exposure", "number", ("exposure",), 0.0, least=-8.0, most=8.0, unit="stops", **stops)
    make.add("colour", "colour", ("color",), _WHITE, **factor)
    make.add("temperature", "number", ("temperature",), 6500.0, least=1000.0, most=15000.0, log=True, unit="K")
    if "target" not in light and "orbit" not in light:
        make.add_angles("from", "direction", up)
    for key in ("position", "target"):
        if make.has(key):
            make.add(key, "vector", (key,), None, unit="units")
    sizes = {
        "angle": ("distant",),
        "width": ("area",),
        "height": ("area",),
        "radius": ("area", "point", "spot", "projector"),
    }
    for key, kinds in sizes.items():
        if kind in kinds and (make.has(key) or key == "angle"):
            if key == "angle":
                make.add(key, "number", (key,), 0.0, least=0.05, most=90.0, log=True, zero=True, unit="°")
            else:
                usual["zero"] = key == "radius" and kind != "area"
                make.add(key, "number", (key,), 0.0, unit="units", **usual)
    if kind == "spot":
        make.add("cone", "number", ("cone",), 45.0, least=1.0, most=180.0, unit="°")
        make.add("blend", "number", ("blend",), 0.15)
    if kind == "dome":
        make.add("rotation", "number", ("rotation",), 0.0, least=-180.0, most=180.0, unit="°")
        if make.has("sky"):
            _add_sky(make)
    if kind == "area" and light.get("shape") in ("rectangle", "disk"):
        make.add("spread", "number", ("spread",), 180.0, least=1.0, most=180.0, unit="°")
    make.add("shadows", "switch", ("shadows",), True)
    return Group("light", name, f"{name} ({kind})", make.controls)


def _volume(index: int, volume: Mapping) -> Group:
    name = name_of("volume", index, volume)
    make = Maker(volume, ("volume", index), f"volume.{name}")
    make.add(
        "density", "number", ("density", "scale"), 1.0, least=1e-4, most=1e4, log=True, zero=True, unit="per unit"
    )
    make.add_curve("density curve", "ramp", ("density", "ramp"))
    if "classified" in volume:
        make.add_curve("transfer", "transfer", ("classified", "transfer"))
    else:
        make.add("albedo", "colour", ("medium", "albedo"), [0.9, 0.9, 0.9])
        make.add("extinction tint", "colour", ("medium", "extinction_tint"), _WHITE)
        _phases.add(make)
        usual = "octaves" if make.has("medium", "octaves") else "single"
        make.add("scattering", "choice", ("medium", "scattering"), usual, choices=("single", "octaves", "full"))
        for key in ("emission", "blackbody"):
            factor = "scale" if key == "emission" else "intensity"
            if make.has("medium", key):
                make.add(f"{key} {factor}", "number", ("medium", key, factor), 1.0, least=1e-3, most=1e3, log=True,
                         zero=True)  # fmt: skip
        if make.has("medium", "blackbody"):
            make.add("blackbody tint", "colour", ("medium", "blackbody", "tint"), _WHITE)
        if make.has("medium", "albedo", "ramp"):
            make.add_curve("albedo curve", "colours", ("medium", "albedo", "ramp"))
        if make.has("medium", "emission"):
            make.add_curve("emission curve", "colours", ("medium", "emission", "ramp"))
    return Group("volume", name, name, make.controls)


def _promises(scene: Mapping) -> tuple[float, ...]:
    """The errors that the qualities promise for this scene; () where the scene sets the dials by hand."""
    if any(key in scene.get("render", {}) for key in ("texel", "sheet_thickness")):
        return ()
    return _PROMISES[any("classified" in volume for volume in scene.get("volume", []))]


def promise_of(scene: Mapping) -> float | None:
    """The relative error that the scene's tolerance or preset promises; None where it promises none."""
    render, promises = scene.get("render", {}), _promises(scene)
    tolerance, quality = render.get("tolerance", 0), render.get("quality", "standard")
    if is_number(tolerance) and tolerance > 0:
        return float(tolerance)
    return promises[_QUALITIES.index(quality)] if promises and quality in _QUALITIES else None


def _volume_shading(index: int, volume: Mapping) -> Group:
    name = name_of("volume", index, volume)
    make = Maker(volume, ("volume", index), f"volume.{name}")
    is_used = _shading.add(make)
    return Group("shading", name, f"{name}: shading", make.controls, not is_used)


def _volume_code(index: int, volume: Mapping) -> Group:
    """The expression of a volume, and the parameters that it uses."""
    name, place = name_of("volume", index, volume), ("volume", index)
    make = Maker(volume, place, f"volume.{name}")
    code = volume.get("ax", "")
    make.controls.append(
        Control(f"volume.{name}.ax", "code", "code", code, lambda it: _code.changes(volume, place, it),
                is_fixed="ax_file" in volume)
    )  # fmt: skip
    for key, value in _code.parameters(volume):
        if is_triple(value):
            make.add(f"${key}", "vector", ("parameters", key), None)
        elif _keys.is_keyed(value):
            make.add(f"${key}", "number", ("parameters", key), None)
        elif is_number(value):
            least, most = _code.range_of(value)
            make.add(f"${key}", "number", ("parameters", key), None, least=least, most=most)
    return Group("code", name, f"{name}: code", make.controls, not code)


def _render(scene: Mapping) -> Group:
    make = Maker(scene, (), "scene")
    labels = tuple(f"{q} ({100 * p:g} % of error)" for q, p in zip(_QUALITIES, _promises(scene)))
    make.add("quality", "choice", ("render", "quality"), "standard", choices=_QUALITIES, labels=labels)
    return Group("render", "render", "Picture", make.controls)


def groups_of(scene: Mapping, up: np.ndarray, frame: int = 1, distance: float = 1.0) -> list[Group]:
    """The controls of a scene, with the values of a frame. `up`: the axis of the world about which azimuths of lights
    are measured. `distance`: where the view's pivot is, which a new lens focuses on."""
    now = _keys.at(scene, frame)
    groups = [_light(i, light, up) for i, light in enumerate(now.get("light", []))]
    ambient = Maker(now, (), "scene")
    ambient.add("colour", "colour", ("ambient", "color"), [0.0, 0.0, 0.0], layer="ambient", law="factor")
    groups.append(Group("ambient", "ambient", "Ambient light", ambient.controls))
    for index, volume in enumerate(now.get("volume", [])):
        groups += [make(index, volume) for make in (_volume, _volume_shading, _volume_code)]
    groups += [_lens.group_of(now, distance), _render(now)]
    return [replace(group, controls=[_marked(one, scene, frame) for one in group.controls]) for group in groups]


def _marked(control: Control, scene: Mapping, frame: int) -> Control:
    if control.kind not in ("number", "colour", "vector") or control.is_fixed:
        return control
    marks = [_keys.mark(scene, place, frame) for place, _ in control.changes(control.value)]
    return replace(control, key=next(filter(None, marks), ""))
