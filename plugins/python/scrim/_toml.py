# SPDX-License-Identifier: Apache-2.0
"""Scenes and overrides as TOML. A value that TOML cannot hold is a UsageError."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from scrim_kit import Failure, toml_text

from ._errors import UsageError


def _said(write: Callable[..., str], *arguments: object) -> str:
    try:
        return write(*arguments)
    except Failure as failure:
        raise UsageError(str(failure)) from None


def _whole(text: str, what: str) -> str:
    """A text whose characters are whole: Python's may be halves of those beyond 16 bits, or bytes of a file's name."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        before = text[: error.start]
        place = f"line {before.count(chr(10)) + 1}, column {error.start - before.rfind(chr(10))}"
        raise UsageError(
            f"{what}: {text[error.start]!a} at {place} is no whole character; expected text that UTF-8 can hold"
        ) from None
    return text


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
    return [_whole(it, f"override {number}") for number, it in enumerate(overrides, 1)]


def document(scene: Mapping[str, object] | str) -> str:
    """A scene as TOML text: in sections, since a picture's header shows it."""
    if isinstance(scene, str):
        return _whole(scene, "the scene")
    if not isinstance(scene, Mapping):
        raise UsageError(f"a scene is of type {type(scene).__name__}; expected TOML text or a dict")
    return _said(toml_text.document, scene)
