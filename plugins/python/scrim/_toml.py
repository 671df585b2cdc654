# SPDX-License-Identifier: Apache-2.0
"""Scenes and overrides in Python's words as TOML. What has no text in TOML is a UsageError."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from scrim_kit import Failure, toml_text

from ._errors import UsageError


def _said(write: Callable[..., str], *arguments: object) -> str:
    try:
        return write(*arguments)
    except Failure as failure:
        raise UsageError(str(failure)) from None


def assignments(overrides: Mapping[str, object] | Sequence[str] | None) -> list[str]:
    """Overrides as the library takes them: "camera.fov=20.0"."""
    if overrides is None:
        return []
    if isinstance(overrides, Mapping):
        for key in overrides:
            if not isinstance(key, str):
                raise UsageError(f"an override is called {key!r}, expected a string such as 'camera.fov'")
        return [_said(toml_text.assignment, key, it) for key, it in overrides.items()]
    if isinstance(overrides, (str, bytes)) or not all(isinstance(it, str) for it in overrides):
        raise UsageError("overrides: expected a dict such as {'camera.fov': 20}, or a list of 'camera.fov=20'")
    return list(overrides)


def document(scene: Mapping[str, object] | str) -> str:
    """A scene as TOML text: in sections, since a picture's header shows it."""
    if isinstance(scene, str):
        return scene
    if not isinstance(scene, Mapping):
        raise UsageError(f"a scene is of type {type(scene).__name__}; expected TOML text or a dict")
    return _said(toml_text.document, scene)
