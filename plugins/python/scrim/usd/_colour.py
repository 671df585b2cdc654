# SPDX-License-Identifier: Apache-2.0
"""Colours of a stage, with the space that they are given in."""

from __future__ import annotations

from pxr import Gf, Usd, UsdLux

from ._reading import Reading, numbers

DEFAULT = "lin_rec709_scene"
KNOWN = ("lin_rec709_scene", "lin_ap1_scene", "lin_ap0_scene")  # of all configs; Scrim converts them itself
_RAW = ("raw", "data", "unknown", "identity")


def space_of(reading: Reading, attribute: Usd.Attribute) -> str:
    """The colour space of an attribute: its own, else that of its prim or of the next ancestor with one, else linear
    Rec.709."""
    name = attribute.GetColorSpace() if attribute else ""
    prim = attribute.GetPrim()
    while not name and prim and not prim.IsPseudoRoot():
        if prim.HasAPI(Usd.ColorSpaceAPI):
            name = Usd.ColorSpaceAPI(prim).GetColorSpaceNameAttr().Get() or ""
        prim = prim.GetParent()
    return name or DEFAULT


def temperature(kelvin: float, space: str) -> list[float]:
    """USD's own colour of a black body, which is linear Rec.709, in another space."""
    rgb = Gf.Vec3f(UsdLux.BlackbodyTemperatureAsRgb(kelvin))
    if space == DEFAULT or space in _RAW:
        return numbers(rgb)
    return [max(c, 0.0) for c in numbers(Gf.ColorSpace(space).Convert(Gf.ColorSpace(DEFAULT), rgb).GetRGB())]


def value(reading: Reading, attribute: Usd.Attribute, rgb: list[float]) -> object:
    """`rgb` as a scene says it. A grey is the same in all spaces."""
    prim = attribute.GetPrim()
    if any(c < 0 for c in rgb):
        reading.warn(prim, f"{attribute.GetName()} is {rgb}; what is below 0 is taken as 0")
        rgb = [max(c, 0.0) for c in rgb]
    space = space_of(reading, attribute)
    if rgb[0] == rgb[1] == rgb[2] or space in _RAW:
        return rgb
    if space in KNOWN:
        return {"rgb": rgb, "colorspace": space}
    if not Gf.ColorSpace.IsValid(space):
        reading.warn(prim, f"{attribute.GetName()}: colour space '{space}' is not known, and taken as {DEFAULT}")
        return {"rgb": rgb, "colorspace": DEFAULT}
    # ACES2065-1 holds all visible colours, so no component of one is below 0.
    converted = numbers(Gf.ColorSpace("lin_ap0_scene").Convert(Gf.ColorSpace(space), Gf.Vec3f(rgb)).GetRGB())
    return {"rgb": [max(c, 0.0) for c in converted], "colorspace": "lin_ap0_scene"}
