# SPDX-License-Identifier: Apache-2.0
"""UsdRender: settings and products become resolution, crop, [output] and the way in which the film fits."""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Sdf, Usd, UsdRender

from .._errors import InputError
from . import _own
from ._reading import Reading

_BEAUTY = ("color", "ci", "beauty", "rgba", "a", "alpha", "c", "rgb")
_DEPTH = ("z", "depth", "zback")


@dataclass
class Settings:
    """What a render wants of the camera and of its output."""

    prim: Usd.Prim | None = None
    camera: Sdf.Path | None = None
    resolution: tuple[int, int] | None = None
    pixel_aspect: float = 1.0
    policy: str = "expandAperture"
    window: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)
    blur: bool = True
    depth_of_field: bool = True


def _only(reading: Reading, schema: type, what: str) -> Usd.Prim | None:
    """The stage's only prim of this schema. Where there are several, they are listed, and none is read."""
    there = [p for p in reading.stage.Traverse() if p.IsA(schema)]
    if len(there) > 1:
        paths = ", ".join(str(p.GetPath()) for p in there)
        reading.warn(what, f"the stage has {len(there)} and names none: {paths}; none is read")
    return there[0] if len(there) == 1 else None


def prim_of(reading: Reading) -> Usd.Prim | None:
    """The RenderSettings that the caller asked for, else that of the stage's metadata, else the stage's only one.
    Without any, the stage's only RenderProduct, which also has resolution, camera and window."""
    wanted = reading.options.settings
    if wanted is None:
        settings = UsdRender.Settings.GetStageRenderSettings(reading.stage)
        if settings:
            return settings.GetPrim()
        if any(p.IsA(UsdRender.Settings) for p in reading.stage.Traverse()):
            return _only(reading, UsdRender.Settings, "RenderSettings")
        return _only(reading, UsdRender.Product, "RenderProduct")
    prim = reading.stage.GetPrimAtPath(wanted) if Sdf.Path.IsValidPathString(wanted) else None
    if not prim or not prim.IsA(UsdRender.Settings):
        there = [str(p.GetPath()) for p in reading.stage.Traverse() if p.IsA(UsdRender.Settings)]
        raise InputError(f"'{wanted}' is not a RenderSettings of the stage; expected {' or '.join(there) or 'none'}")
    return prim


def _product_paths(reading: Reading, prim: Usd.Prim) -> list[Sdf.Path]:
    if prim.IsA(UsdRender.Product):
        return [prim.GetPath()]
    products = UsdRender.Settings(prim).GetProductsRel()
    if products.HasAuthoredTargets():
        return products.GetForwardedTargets()
    only = _only(reading, UsdRender.Product, "RenderProduct")
    return [only.GetPath()] if only else []


def _products(reading: Reading, prim: Usd.Prim) -> tuple[Usd.Prim | None, Usd.Prim | None]:
    """The picture and the deep picture."""
    found: dict[str, Usd.Prim] = {}
    for path in _product_paths(reading, prim):
        product = reading.stage.GetPrimAtPath(path)
        if not product or not product.IsA(UsdRender.Product):
            reading.warn(prim, f"product {path} is not a RenderProduct, and is not read")
            continue
        kind = reading.get(UsdRender.Product(product).GetProductTypeAttr(), otherwise="raster")
        if kind not in ("raster", "deepRaster"):
            reading.warn(product, f"products of type '{kind}' are not written")
        elif kind in found:
            reading.warn(product, f"a second product of type '{kind}' is not written; render it by settings of its own")
        else:
            found[kind] = product
    return found.get("raster"), found.get("deepRaster")


def _value(reading: Reading, settings: Usd.Prim, product: Usd.Prim | None, name: str) -> object:
    """The value of an attribute: authored by the product, else that of the settings."""
    for prim in (product, settings):
        attribute = prim.GetAttribute(name) if prim else None
        if attribute and (attribute.HasAuthoredValue() or prim is settings):
            return reading.get(attribute)
    return None


def _camera(settings: Usd.Prim, product: Usd.Prim | None) -> Sdf.Path | None:
    for prim in (product, settings):
        targets = UsdRender.SettingsBase(prim).GetCameraRel().GetForwardedTargets() if prim else []
        if targets:
            return targets[0]
    return None


def _vars(reading: Reading, product: Usd.Prim, output: dict) -> None:
    layers: list[str] = []
    for path in UsdRender.Product(product).GetOrderedVarsRel().GetForwardedTargets():
        prim = reading.stage.GetPrimAtPath(path)
        if not prim or not prim.IsA(UsdRender.Var):
            reading.warn(product, f"render var {path} is not a RenderVar, and is not read")
            continue
        var = UsdRender.Var(prim)
        source = reading.get(var.GetSourceNameAttr(), otherwise="") or prim.GetName()
        if source.lower() in _DEPTH:
            layers.append("depth")
        elif source.lower() not in _BEAUTY:
            text = "is not written; scrim:output:layers of the settings names layers"
            reading.warn(prim, f"render var '{source}' {text}")
        elif var.GetDataTypeAttr().HasAuthoredValue():  # a fallback is no wish for floats
            kind = str(reading.get(var.GetDataTypeAttr()))
            output["type"] = "half" if kind.endswith("h") or kind.startswith("half") else "float"
    if layers:
        output["layers"] = sorted(set(layers))


def read(reading: Reading, scene: dict) -> Settings:
    """Puts [output], and the attributes `scrim:*` of the settings, into `scene`."""
    prim = prim_of(reading)
    if prim is None:
        return Settings(resolution=reading.options.resolution)
    raster, deep = _products(reading, prim)
    output = scene.setdefault("output", {})
    for product, key in ((raster, "file"), (deep, "deep")):
        name = reading.get(UsdRender.Product(product).GetProductNameAttr(), otherwise="") if product else ""
        if name:
            output[key] = name
    if raster:
        _vars(reading, raster, output)
    space = reading.get(prim.GetAttribute("renderingColorSpace"))
    if space:
        output["colorspace"] = str(space)
    first = raster or deep
    size = _value(reading, prim, first, "resolution")
    window = tuple(float(v) for v in _value(reading, prim, first, "dataWindowNDC"))
    still = _value(reading, prim, first, "disableMotionBlur") or _value(reading, prim, first, "instantaneousShutter")
    if first and deep and first != deep:
        for name in ("resolution", "pixelAspectRatio", "aspectRatioConformPolicy", "dataWindowNDC"):
            if _value(reading, prim, deep, name) != _value(reading, prim, first, name):
                reading.warn(deep, f"its {name} is not that of {first.GetPath()}, which is taken for both")
    included = reading.get(prim.GetAttribute("includedPurposes"))
    if reading.options.purpose is None and included is not None:
        reading.options.purpose = tuple(str(p) for p in included)
    _own.merge(scene, _own.attributes(reading, prim))
    return Settings(
        prim,
        _camera(prim, first),
        reading.options.resolution or (int(size[0]), int(size[1])),
        float(_value(reading, prim, first, "pixelAspectRatio")),
        str(_value(reading, prim, first, "aspectRatioConformPolicy")),
        window,
        not still,
        not _value(reading, prim, first, "disableDepthOfField"),
    )
