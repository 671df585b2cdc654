# SPDX-License-Identifier: Apache-2.0
"""Controls for the keys of shading (examples/guide/shading.md) that are numbers."""

from __future__ import annotations

from ._control_maker import Maker


def add(make: Maker) -> bool:
    """Adds the controls of a volume. Returns whether the scene has any of these keys. A control of an absent key
    begins at the value that changes nothing; controls of further numbers, such as a noise's frequency, come once the
    key is there."""
    remap, noise, displacement = ("density", "remap"), ("density", "noise"), ("displacement",)
    make.add("resample", "number", ("resample",), 1.0, least=0.25, most=4.0, log=True)
    _noise(make, "displace", displacement)
    make.add_pair("remap from", (*remap, "from"), (0.0, 1.0))
    if make.has(*remap):
        make.add_pair("remap to", (*remap, "to"), (0.0, 1.0), ends=("high",))
    make.add("remap gamma", "number", (*remap, "gamma"), 1.0, least=0.1, most=10.0, log=True)
    make.add("remap contrast", "number", (*remap, "contrast"), 1.0, least=0.1, most=10.0, log=True)
    make.add_pair("edge", ("density", "edge"), (0.0, 0.0))
    _mask(make, "mask", ("density", "mask"))
    _noise(make, "noise", noise)
    if make.has(*noise):
        make.add("noise mode", "choice", ("density", "noise_mode"), "multiply", choices=("multiply", "erode"))
    for key in ("emission", "blackbody"):
        _mask(make, f"{key} mask", ("medium", key, "mask"))
    keys = (("resample",), displacement, remap, ("density", "edge"), ("density", "mask"), noise)
    return any(make.has(*one) for one in keys)


def _noise(make: Maker, label: str, keys: tuple[str, ...]) -> None:
    is_there = make.has(*keys)
    make.add(f"{label} amount", "number", (*keys, "amount"), 1.0 if is_there else 0.0, most=2.0)
    if not is_there:
        return
    make.add(f"{label} frequency", "number", (*keys, "frequency"), 1.0, least=0.01, most=100.0, log=True)
    make.add(f"{label} octaves", "number", (*keys, "octaves"), 4, least=1, most=8, whole=True)
    make.add(f"{label} roughness", "number", (*keys, "roughness"), 0.5)
    make.add(f"{label} lacunarity", "number", (*keys, "lacunarity"), 2.0, least=1.0, most=4.0)
    make.add(f"{label} evolution", "number", (*keys, "evolution"), 0.0, least=-4.0, most=4.0)
    make.add(f"{label} offset", "vector", (*keys, "offset"), [0.0, 0.0, 0.0])


def _mask(make: Maker, label: str, keys: tuple[str, ...]) -> None:
    if make.has(*keys):
        make.add_pair(f"{label} from", (*keys, "from"), (0.0, 1.0))
        make.add_pair(f"{label} to", (*keys, "to"), (0.0, 1.0), ascends=False)
