# SPDX-License-Identifier: Apache-2.0
"""Volume materials that others write, as `density` and `medium` of a [[volume]].

Arnold's standard_volume, Karma's volume shaders and MaterialX's volume nodes, as UsdShade holds them: examples/USD.md
has the table. A warning names each input of a shader that is not mapped. Rates are per world unit at grid value 1; a
rate without a grid of its own goes with the density.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pxr import Usd, UsdShade

from ._reading import Reading
from ._shaders import Shader, Value, kind_of, triple

_CONTEXTS = ("mtlx", "arnold", "kma", "karma", "")  # of outputs:CONTEXT:volume, the first that is there counts
_FAR = 1000.0  # grid value up to which a coloured glow grows: a ramp is constant beyond its end
_LEAST = 1e-6  # smallest `transparent` and `transparent_depth` of Arnold's: the extinction is -log(t) / depth
_DEFAULT_TRANSPARENT = [math.exp(-1.0)] * 3  # with it the extinction, -density * log(transparent), is the density


@dataclass
class Material:
    """`density` and `medium`: keys of a [[volume]], in which grids have the names that the shader uses: channels of the
    Volume. `unsaid`: grids that only a default of the shader names; no warning is given where the Volume lacks them."""

    density: dict = field(default_factory=dict)
    medium: dict = field(default_factory=dict)
    unsaid: set[str] = field(default_factory=set)


# ---- from coefficients to keys


def _put_rates(out: Material, shader: Shader, scattering: Sequence[float], extinction: Sequence[float]) -> None:
    """`density.scale`, and the keys of a medium with these rates at grid value 1."""
    most = max(extinction)
    out.density["scale"] = most
    albedo = [min(s / e, 1.0) if e > 0 else 0.0 for s, e in zip(scattering, extinction)]
    out.medium["albedo"] = shader.scene_colour(albedo)
    if most > 0 and min(extinction) < most:
        out.medium["extinction_tint"] = shader.scene_colour([e / most for e in extinction])


def _put_phase(out: Material, g: float, second: float = 0.0, blend: float = 0.0) -> None:
    g, second = (min(max(v, -0.999), 0.999) for v in (g, second))
    if blend > 0:
        out.medium["phase"] = {"type": "two-lobe", "g1": g, "g2": second, "blend": min(blend, 1.0)}
    elif abs(g) < 1e-6:
        out.medium["phase"] = {"type": "isotropic"}
    else:
        out.medium["phase"] = {"type": "hg", "g": g}


def _put_glow(out: Material, shader: Shader, grid: str, strength: Sequence[float]) -> None:
    most = max(strength)
    if most <= 0 or not grid:
        return
    glow: dict = {"grid": grid, "scale": most}
    if min(strength) < most:
        far = [_FAR * max(c, 0.0) / most for c in strength]
        glow["ramp"] = [[0.0, [0.0, 0.0, 0.0]], [_FAR, shader.scene_colour(far)]]
    out.medium["emission"] = glow


# ---- the shaders


def _standard_volume(shader: Shader) -> Material:
    """Arnold's. Its defaults are those of its node: density 1, scatter_color 0.5, transparent exp(-1), ..."""
    out = Material()
    channel = shader.text("density_channel", "density")
    density = shader.value("density", 1.0)
    out.density["grid"] = density.grid or channel
    depth = max(shader.number("transparent_depth", 1.0), _LEAST)
    clear = shader.colour("transparent", _DEFAULT_TRANSPARENT)
    extinction = [density.number * -math.log(min(max(t, _LEAST), 1.0)) / depth for t in clear]
    scatter, colour = shader.number("scatter", 1.0), shader.value("scatter_color", 0.5)
    _put_rates(out, shader, [scatter * c * e for c, e in zip(colour.color, extinction)], extinction)
    grid = colour.grid or shader.text("scatter_color_channel", "")
    if grid:
        out.medium["albedo"] = {"grid": grid, "scale": scatter * colour.number}
    _put_phase(
        out,
        shader.number("scatter_anisotropy", 0.0),
        shader.number("scatter_secondary_anisotropy", 0.0),
        shader.number("scatter_secondary_anisotropy_mix", 0.0),
    )
    _arnold_emission(out, shader)
    return out


def _arnold_emission(out: Material, shader: Shader) -> None:
    mode = {"0": "none", "1": "channel", "2": "density", "3": "blackbody"}.get(
        mode := shader.text("emission_mode", "blackbody"), mode
    )
    weight, colour = shader.number("emission", 1.0), shader.colour("emission_color", [1.0] * 3)
    if mode in ("channel", "density"):
        grid = shader.text("emission_channel", "heat") if mode == "channel" else out.density["grid"]
        _put_glow(out, shader, grid, [weight * c for c in colour])
    elif mode == "blackbody":
        grid = shader.text("temperature_channel", "temperature")
        intensity = weight * shader.number("blackbody_intensity", 1.0)
        kelvin = shader.number("temperature", 1.0) * shader.number("blackbody_kelvin", 5000.0)
        if colour != [1.0] * 3:
            shader.warn(
                "standard_volume: emission_color is not mapped on a black body, whose temperature is its colour"
            )
        if not (shader.has("emission_mode") or shader.has("temperature_channel")):
            out.unsaid.add(grid)
        if grid and intensity > 0 and kelvin > 0:
            out.medium["blackbody"] = {"grid": grid, "scale": kelvin, "intensity": intensity}


def _vdf(out: Material, shader: Shader) -> None:
    """Absorption and scattering rates with a phase: MaterialX's VDFs, and Karma's volume."""
    absorption = shader.value("absorption", 0.0)
    scattering = shader.value("scattering", 0.0) if shader.kind != "ND_absorption_vdf" else Value([0.0] * 3)
    grids = [v.grid for v in (scattering, absorption) if v.grid]
    if grids:
        out.density["grid"] = grids[0]
        if len(set(grids)) > 1:
            shader.warn(
                f"{shader.kind}: absorption goes with the grid '{grids[0]}' of the scattering, not with its own"
            )
    extinction = [a + s for a, s in zip(absorption.color, scattering.color)]
    _put_rates(out, shader, scattering.color, extinction)
    if shader.kind != "ND_absorption_vdf":
        _put_phase(
            out,
            shader.number("anisotropy", 0.0),
            shader.number("anisotropy2", 0.0),
            shader.number("anisotropymix", 0.0),
        )


def _glow_of(out: Material, shader: Shader, name: str) -> None:
    value = shader.value(name, 0.0)
    _put_glow(out, shader, value.grid or out.density.get("grid", "density"), value.color)


def _karma_volume(shader: Shader) -> Material:
    out = Material()
    _vdf(out, shader)
    _glow_of(out, shader, "emission")
    return out


def _materialx_volume(shader: Shader) -> Material:
    out = Material()
    vdf, edf = shader.node("vdf"), shader.node("edf")
    for part, kinds in ((vdf, ("ND_anisotropic_vdf", "ND_absorption_vdf")), (edf, ("ND_uniform_edf",))):
        if part is None:
            continue
        inner = Shader(shader.reading, part)
        if inner.kind not in kinds:
            inner.warn(f"{inner.kind or 'a node without a kind'} is not mapped")
            continue
        if part == vdf:
            _vdf(out, inner)
        else:
            _glow_of(out, inner, "color")
        inner.say_what_is_not()
    return out


def _ramp(shader: Shader, name: str) -> list[tuple[float, list[float]]]:
    """A ramp of Houdini: arrays of places and of values."""
    values = shader.array(f"{name}_values") or shader.array(f"{name}_vals")
    places = shader.array(f"{name}_keys") or shader.array(f"{name}_pos") or shader.array(f"{name}_knots")
    for rest in ("_basis", "_interpolation"):
        shader.text(name + rest, "")
    shader.text(name, "")  # how many points there are
    return sorted(zip(map(float, places), map(triple, values)), key=lambda point: point[0])


def _pyro(shader: Shader) -> Material:
    """Karma's kma_pyroshader, and kma_pyropreview."""
    out = Material()
    scale = shader.number("densityscale", 1.0)
    out.density["grid"] = shader.text("density_volumename", "density")
    albedo = shader.colour("smokecolor", [1.0] * 3)
    scatters = shader.number("enablescatter", 1.0) > 0
    _put_rates(out, shader, [scale * c if scatters else 0.0 for c in albedo], [scale] * 3)
    _put_phase(out, shader.number("anisotropy", 0.0))
    if shader.number("enablefire", 0.0) > 0:
        _fire(out, shader)
    else:
        for name in ("fireintscale", "fireint_volumename", "firecolor_volumename", "firecolormode"):
            shader.text(name, "")
        _ramp(shader, "firecolorramp")
    return out


def _fire(out: Material, shader: Shader) -> None:
    """Glow = fireintscale * (grid fireint_volumename) * (colour of the ramp at the grid firecolor_volumename)."""
    strength = shader.number("fireintscale", 1.0)
    grid = shader.text("fireint_volumename", "flame")
    coloured = shader.text("firecolor_volumename", grid)
    mode = shader.text("firecolormode", "0")
    ramp = _ramp(shader, "firecolorramp")
    if mode not in ("0", "ramp") or not ramp or coloured != grid:
        why = "has no ramp of colours that can be read" if not ramp else f"is by the grid '{coloured}'"
        why = f"is of mode {mode}" if mode not in ("0", "ramp") else why
        shader.warn(f"{shader.kind}: the colour of its fire {why}, and is taken as white")
        _put_glow(out, shader, grid, [strength] * 3)
        return
    # The glow is a value v times the ramp's colour at v: between two points of the ramp it is quadratic in v. Three
    # more points between them follow the curve.
    places = sorted(
        {p for p, _ in ramp} | {_mixed(a[0], b[0], i / 4) for a, b in zip(ramp, ramp[1:]) for i in range(4)}
    )
    last = ramp[-1][1]
    points = [(p, _at(ramp, p)) for p in places if p > 0] + [(_FAR, last)]
    lit = [[p, shader.scene_colour([p * c for c in colour])] for p, colour in points]
    out.medium["emission"] = {"grid": grid, "scale": strength, "ramp": [[0.0, [0.0, 0.0, 0.0]], *lit]}


def _mixed(a: float, b: float, part: float) -> float:
    return a + (b - a) * part


def _at(ramp: Sequence[tuple[float, list[float]]], place: float) -> list[float]:
    if place <= ramp[0][0]:
        return ramp[0][1]
    for (p, before), (q, after) in zip(ramp, ramp[1:]):
        if place <= q:
            part = (place - p) / (q - p) if q > p else 1.0
            return [_mixed(a, b, part) for a, b in zip(before, after)]
    return ramp[-1][1]


SHADERS: dict[str, Callable[[Shader], Material]] = {
    "standard_volume": _standard_volume,
    "kma_pyroshader": _pyro,
    "kma_pyropreview": _pyro,
    "kma_volume": _karma_volume,
    "ND_volume": _materialx_volume,
}


def _terminal(material: UsdShade.Material) -> Usd.Prim | None:
    for context in _CONTEXTS:
        outputs = [material.GetVolumeOutput(context)]
        if context == "arnold":
            outputs.append(material.GetSurfaceOutput(context))  # where older exporters put standard_volume
        for output in outputs:
            made = UsdShade.Utils.GetValueProducingAttributes(output) if output else []
            if made and (output == outputs[0] or kind_of(made[0].GetPrim()) == "standard_volume"):
                return made[0].GetPrim()
    return None


def of(reading: Reading, prim: Usd.Prim) -> Material | None:
    """The material that is bound to a Volume. None: no material is bound, or it cannot be mapped; then a warning says
    why."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("full")[0]
    if not bound:
        return None
    terminal = _terminal(bound)
    if terminal is None:
        reading.warn(prim, f"material {bound.GetPath()} has no volume shader, and is not read")
        return None
    shader = Shader(reading, terminal)
    if shader.kind not in SHADERS:
        kind = UsdShade.Shader(terminal).GetIdAttr().Get() or terminal.GetTypeName()
        reading.warn(prim, f"material {bound.GetPath()}: shader '{kind}' is not mapped; expected one of "
                           f"{', '.join(SHADERS)}")  # fmt: skip
        return None
    out = SHADERS[shader.kind](shader)
    shader.say_what_is_not()
    return out
