# SPDX-License-Identifier: Apache-2.0
"""Values that a scene animates, { keys = [[frame, value], ...] }: what they are at a frame, and how to set them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .. import _scrim
from ._document import Change, Place
from ._messages import is_number


def is_keyed(value: object) -> bool:
    return isinstance(value, Mapping) and isinstance(value.get("keys"), list)


def at(value: object, frame: int) -> object:
    """A scene, or a part of it, with the values that its keys have at a frame. Keys whose values are neither numbers
    nor lists of numbers stay."""
    if is_keyed(value):
        found = _value_of(value, frame)
        return value if found is None else found
    if isinstance(value, Mapping):
        return {key: at(one, frame) for key, one in value.items()}
    if isinstance(value, list) and any(isinstance(one, Mapping) for one in value):
        return [at(one, frame) for one in value]
    return value


def _value_of(keyed: Mapping, frame: int) -> object:
    keys = keyed["keys"]
    if not keys or not all(isinstance(key, list) and len(key) == 2 and is_number(key[0]) for key in keys):
        return None
    frames, values = [float(key[0]) for key in keys], [key[1] for key in keys]
    smooth = keyed.get("interpolation") == "smooth"

    def number(each: list) -> float:
        return _scrim.value_at(frames, [float(one) for one in each], frame, smooth)

    if all(is_number(one) for one in values):
        return number(values)
    if all(isinstance(one, list) and all(is_number(part) for part in one) for one in values):
        return [number(list(parts)) for parts in zip(*values)]
    return None


def found(scene: object, place: Place) -> object:
    """What a scene says at a place; None where it says nothing."""
    for name in place:
        if isinstance(scene, Mapping):
            scene = scene.get(name)
        else:
            scene = scene[name] if isinstance(scene, list) and isinstance(name, int) and name < len(scene) else None
    return scene


def mark(scene: Mapping, place: Place, frame: int) -> str:
    """"": the value at a place has no keys. "here": it has one at the frame. "between": it has others."""
    value = found(scene, place)
    if not is_keyed(value):
        return ""
    return "here" if any(key[0] == frame for key in value["keys"]) else "between"


def kept(scene: Mapping, changes: Iterable[Change], frame: int) -> list[Change]:
    """The changes of a scene, where those of keyed values set the key of the frame instead."""
    return [_kept(found(scene, place), place, value, frame) for place, value in changes]


def _kept(before: object, place: Place, value: object, frame: int) -> Change:
    if not is_keyed(before) or value is None or isinstance(value, Mapping):
        return place, value
    others = [key for key in before["keys"] if key[0] != frame]
    return (*place, "keys"), sorted([*others, [frame, value]], key=lambda key: key[0])


def frames(scene: object) -> list[float]:
    """The frames of all keys in a scene."""
    if is_keyed(scene):
        return [key[0] for key in scene["keys"] if isinstance(key, list) and key and is_number(key[0])]
    inside = scene.values() if isinstance(scene, Mapping) else scene if isinstance(scene, list) else ()
    return [frame for one in inside for frame in frames(one)]
