# SPDX-License-Identifier: Apache-2.0
"""Controls for the phase function of a medium, and for the numbers that it has."""

from __future__ import annotations

from ._control_maker import Control, Maker
from ._document import Change

# For each function its numbers, which begin with usual ones: smoke for `hg`, clouds for the others.
KINDS: dict[str, dict[str, float]] = {
    "isotropic": {},
    "hg": {"g": 0.3},
    "two-lobe": {"g1": 0.7, "g2": -0.2, "blend": 0.4},
    "rayleigh": {},
    "draine": {"g": 0.7, "alpha": 1.0},
    "droplets": {"size": 10.0},
}
_KEYS = ("medium", "phase")
_RANGES = {
    "blend": {},
    "alpha": {"least": 0.01, "most": 100.0, "log": True, "zero": True},
    "size": {"least": 0.1, "most": 50.0, "log": True, "unit": "µm"},
}
_LOBE = {"least": -0.95, "most": 0.95}


def add(make: Maker) -> None:
    """Adds the controls of a volume."""
    kind = make.value(*_KEYS, "type") or "isotropic"
    place = (*make.place, *_KEYS)

    def changes(new: str) -> list[Change]:
        gone = {key for numbers in KINDS.values() for key in numbers} - KINDS[new].keys()
        added = [((*place, key), value) for key, value in KINDS[new].items() if not make.has(*_KEYS, key)]
        return [*(((*place, key), None) for key in sorted(gone)), ((*place, "type"), new), *added]

    make.controls.append(
        Control(f"{make.path}.medium.phase.type", "phase", "choice", kind, changes, choices=tuple(KINDS))
    )
    for key, usual in KINDS.get(kind, {}).items():
        make.add(f"phase {key}", "number", (*_KEYS, key), usual, **_RANGES.get(key, _LOBE))
