# SPDX-License-Identifier: Apache-2.0
"""Rendered pictures, and the picture of a scene with other strengths of its lights, which is made of them.

Light adds up: a picture is the sum of a layer for each light, of ambient light and of emission, each in proportion to
its strength. So other strengths are other weights, and need no render.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ._document import name_of

LAYERS = ["light", "ambient", "emission", "depth"]
_OWN = "view"  # names of groups that hold a single light begin with it
_STRENGTHS = ("intensity", "exposure", "color", "temperature")
_HALF_MOST = 65504.0
_numbers = itertools.count(1)


@dataclass(frozen=True)
class Shape:
    """Everything in a scene but the strengths. `common`: what concerns the whole picture; `lights`: what
    concerns each light alone; `render`: how exact the picture is. Two scenes with equal shapes differ by weights. The
    strengths are a part of the shape where the camera sees meshes or skies."""

    common: Mapping
    lights: Mapping[str, Mapping]
    render: Mapping


@dataclass(frozen=True)
class Strengths:
    """Strengths in the working space: three numbers for each light, "ambient" and "emission"."""

    of: Mapping[str, np.ndarray]


def _emitter(scene: Mapping) -> dict | None:
    """The table whose factor is the strength of the layer "emission"; None where several add up in it."""
    found = [
        (volume["medium"], key)
        for volume in scene.get("volume", [])
        for key in ("emission", "blackbody")
        if isinstance(volume.get("medium"), Mapping) and isinstance(volume["medium"].get(key), Mapping)
    ]
    if len(found) != 1:
        return None
    medium, key = found[0]
    factor = "scale" if key == "emission" else "intensity"
    it = medium[key].get(factor, 1.0)
    return {"table": medium[key], "key": factor, "value": it} if isinstance(it, (int, float)) else None


def shape_of(scene: Mapping, view: Mapping, frame: int) -> Shape:
    """`view`: overrides of the camera."""
    common = copy.deepcopy(dict(scene))
    lit = common if _has_backdrop(scene) else {}  # no layer of a light holds what it gives the backdrop
    strengths = [{key: light[key] for key in _STRENGTHS if key in light} for light in lit.get("light", [])]
    strengths.append(copy.copy(lit.get("ambient")))
    lights = {
        name_of("light", index, light): {key: value for key, value in light.items() if key not in _STRENGTHS}
        for index, light in enumerate(common.pop("light", []))
    }
    common.pop("output", None)
    render = common.pop("render", {})
    if isinstance(common.get("ambient"), dict):
        common["ambient"].pop("color", None)
        if not common["ambient"]:
            del common["ambient"]
    if emitter := _emitter(common):
        emitter["table"].pop(emitter["key"], None)
    # Lights that come or go change the sums and the plan: they count as a change of everything.
    parts = {"scene": common, "view": dict(view), "frame": frame, "lights": list(lights), "strengths": strengths}
    return Shape(parts, lights, render)


def _has_backdrop(scene: Mapping) -> bool:
    """Whether the camera sees meshes or skies."""
    has_mesh = any(mesh.get("color") for mesh in scene.get("mesh", []))
    return has_mesh or any(light.get("visible") for light in scene.get("light", []))


def own_layers(lights: Iterable[str]) -> dict[str, str]:
    """Overrides that put each light into a group of its own, and so give it a layer whose name holds its number.
    Without them, lights share the layers of their groups, and names are changed to suit compositing programs."""
    return {f"light[{index}].group": f"{_OWN}{index}" for index, _ in enumerate(lights)}


def strengths_of(scene: Mapping, resolved: Mapping) -> Strengths:
    """`resolved`: what `Shot.resolved` says of the scene."""
    of = {f"light.{name}": np.array(rgb, float) for name, rgb in resolved["lights"].items()}
    of["ambient"] = np.array(resolved["ambient"], float)
    emitter = _emitter(scene)
    of["emission"] = np.full(3, float(emitter["value"]) if emitter else 1.0)
    return Strengths(of)


def weight(wanted: np.ndarray, rendered: np.ndarray) -> np.ndarray | None:
    """The factors on a layer, one for each channel; None where a channel that was rendered dark is to shine."""
    if np.any((rendered == 0) & (wanted != 0)):
        return None
    return np.divide(wanted, rendered, out=np.ones(3), where=rendered != 0)


@dataclass(frozen=True)
class Texture:
    """A picture as the page takes it: float16, (height, width, 2, 3 or 4). No other texture gets its number."""

    pixels: np.ndarray
    number: int = field(default_factory=lambda: next(_numbers))

    @staticmethod
    def of(pixels: np.ndarray) -> Texture:
        return Texture(np.clip(pixels, -_HALF_MOST, _HALF_MOST).astype(np.float16))


@dataclass(frozen=True)
class Layer:
    """What one light gives, with the strength and the shape that it was rendered with. `texture`: None where it is
    black."""

    texture: Texture | None
    strength: np.ndarray
    shape: Mapping
    stage: str


@dataclass(frozen=True)
class Depth:
    """`mean`: of what is visible, along the view, float32 (height, width), 0 where nothing is. `texture`: of the first
    thing visible, and the mean. `ends`: the nearest and the farthest of that."""

    mean: np.ndarray
    texture: Texture
    ends: tuple[float, float]

    @staticmethod
    def of(pixels: np.ndarray) -> Depth:
        first = pixels[..., 0]
        seen = first[first > 0]
        ends = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 1.0)
        return Depth(np.ascontiguousarray(pixels[..., 1]), Texture.of(pixels[..., :2]), ends)


@dataclass(frozen=True)
class Pictures:
    """The newest pictures of a scene. `beauty`: the picture itself, whose colours count while every weight is 1 and
    `is_whole` (no layer was rendered anew since). `layers`: None until they are rendered. `rest`: what the layers
    leave of the picture, None where that is nothing. `stage`: motion, draft or final, which is as exact as the scene
    asks for. `muted`: lights that were left out of the beauty. `region`: the
    pixels that are final, while the others are older. `depth`: comes with the layers. `frame`: the frame of
    the render that the scene's file makes, too,
    bit for bit; None until it was made. `camera`: the view, as the page projects by it. `plate`: what the
    scene's preview is laid over."""

    shape: Shape
    beauty: Texture
    layers: Mapping[str, Layer] | None
    rest: Texture | None
    stage: str
    strengths: Strengths
    muted: frozenset[str] = frozenset()
    region: tuple[int, int, int, int] | None = None
    depth: Depth | None = None
    is_whole: bool = True
    frame: object = None
    seconds: float = 0.0
    camera: Mapping = field(default_factory=dict)
    plate: Texture | None = None

    def weights(self, wanted: Strengths, muted: frozenset[str]) -> dict[str, list[float]] | None:
        """Factors of the layers for these strengths; None where the beauty is the picture."""
        if not self.layers:
            return None
        then = self.strengths.of
        is_beauty = self.is_whole and not any(name in muted for name in self.layers)
        is_beauty &= all(bool((rgb == then.get(name)).all()) for name, rgb in wanted.of.items() if name in self.layers)
        out = {}
        for name, layer in self.layers.items():
            factors = weight(wanted.of.get(name, layer.strength), layer.strength)
            if factors is None:
                factors = np.ones(3)  # until the light has been rendered anew
            if name in muted:
                factors = np.zeros(3)
            out[name] = [float(f) for f in factors]
        return None if is_beauty else out

    def differs_by_view(self, wanted: Shape) -> bool:
        """Whether these pictures show what is wanted, from another view."""
        same = {**self.shape.common, "view": wanted.common["view"]} == wanted.common
        return same and self.shape.common != wanted.common and self.shape.lights == wanted.lights

    def stale_lights(self, wanted: Shape, strengths: Strengths) -> list[str]:
        """Lights whose layers have to be rendered anew."""
        if not self.layers:
            return []
        stale = []
        for name, shape in wanted.lights.items():
            layer = self.layers.get(f"light.{name}")
            if layer is None or layer.shape != shape:
                stale.append(name)
            elif weight(strengths.of[f"light.{name}"], layer.strength) is None:
                stale.append(name)
        return stale

    def lacks(self, strengths: Strengths) -> bool:
        """Whether ambient light or emission is to shine, but was rendered dark."""
        layers = self.layers or {}
        pairs = [(strengths.of[n], layers[n].strength) for n in ("ambient", "emission") if n in layers]
        return any(weight(wanted, rendered) is None for wanted, rendered in pairs)


def pictures_of(
    frame: object, shape: Shape, strengths: Strengths, stage: str, seconds: float, has_layers: bool = False
) -> Pictures:
    """The pictures of a rendered `scrim.Frame`; with layers, if they were asked for by `own_layers`."""
    inside = _inside(frame)
    beauty = frame.image[inside]
    if not has_layers:
        return Pictures(shape, Texture.of(beauty), None, None, stage, strengths, seconds=seconds)
    layers, rest = {}, beauty[..., :3].copy()
    named = {f"light.{_OWN}{index}": f"light.{light}" for index, light in enumerate(shape.lights)}
    for there in frame.layers:
        name = named.get(there, there)
        if there in named or there in ("ambient", "emission"):
            pixels = frame[there][inside][..., :3]
            rest -= pixels
            own = shape.lights[name.removeprefix("light.")] if there in named else {}
            texture = Texture.of(pixels) if pixels.any() else None
            layers[name] = Layer(texture, strengths.of.get(name, np.ones(3)), own, stage)
    depth = Depth.of(frame["depth"][inside]) if "depth" in frame.layers else None
    # The picture less its layers is rounding, unless a light has no layer.
    something = layers and float(np.abs(rest).max(initial=0)) > 1e-4 * max(float(beauty.max(initial=0)), 1e-6)
    left = Texture.of(rest) if something else None
    return Pictures(shape, Texture.of(beauty), layers, left, stage, strengths, depth=depth, seconds=seconds)


def with_region(pictures: Pictures, frame: object, region: tuple[int, int, int, int], size: tuple[int, int]) -> Texture:
    """The picture in its full size, with the pixels of a region from the frame that was cropped to it."""
    before = pictures.beauty.pixels
    rows, columns = (
        np.arange(full) * now // full for full, now in ((size[1], before.shape[0]), (size[0], before.shape[1]))
    )
    whole = before[rows][:, columns]
    x0, y0, x1, y1 = region
    whole[y0:y1, x0:x1] = Texture.of(frame.image).pixels
    return Texture(whole)


def _inside(frame: object) -> tuple[slice, slice]:
    """The pixels of the display window, without overscan."""
    x0, y0, _, _ = frame.window
    height, width = frame.image.shape[:2]
    return slice(max(-y0, 0), height + min(y0, 0)), slice(max(-x0, 0), width + min(x0, 0))
