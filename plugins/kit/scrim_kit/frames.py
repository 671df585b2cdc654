# SPDX-License-Identifier: Apache-2.0
"""Ranges of frames, and file names with the frame in them, as the program has them.

A range is "1-48x2,60": frames, first and last ones, and steps. In a pattern of file names `####`, `%04d` and `$F4`
stand for the frame with at least four digits, `%d` and `$F` for the bare number, and `$$`, `$#` and `$%` for the second
of these characters. src/scrim/scene/frame_range.h and frame_path.h say the same for the program, and
tests/plugins/python/test_kit_frames.py compares the two.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from .failure import Failure

_PART = re.compile(r"(-?\d+)(?:-(-?\d+)(?:x(\d+))?)?", re.ASCII)
_LARGEST = 1_000_000_000  # frame
_MOST = 1_000_000  # frames of a range
# Of a pattern: a plain character, or what stands for the frame.
_PLACE = re.compile(r"\$([$#%])|(#+)|\$F(\d*)|%(0\d+)?d", re.ASCII)
_MOST_DIGITS = 20
_LARGEST_INT = 0x7FFFFFFF


def parse_range(text: str, where: str) -> list[int]:
    """The frames of a range, each once, in the order in which it names them. `where` is what a message calls it:
    "--frames". Raises Failure."""
    frames: dict[int, None] = {}
    for part in text.split(","):
        match = _PART.fullmatch(part.strip(" "))
        if not match:
            raise Failure(f"{where} {text}: expected a range such as 1-48x2,60")
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if step < 1 or last < first:
            raise Failure(f"{where} {text}: expected a range such as 1-48x2,60")
        if max(-first, last, step) > _LARGEST:
            raise Failure(f"{where} {text}: expected frames and steps up to {_LARGEST}")
        some = range(first, last + 1, step)
        if len(some) <= _MOST:
            frames.update(dict.fromkeys(some))
        if max(len(some), len(frames)) > _MOST:
            raise Failure(f"{where} {text}: expected at most {_MOST} frames")
    return list(frames)


def range_text(frames: Sequence[int]) -> str:
    """The shortest range of ascending frames without steps: "1-12,20"."""
    parts, i = [], 0
    while i < len(frames):
        j = i
        while j + 1 < len(frames) and frames[j + 1] == frames[j] + 1:
            j += 1
        parts.append(str(frames[i]) if i == j else f"{frames[i]}-{frames[j]}")
        i = j + 1
    return ",".join(parts)


def at_frame(pattern: str, frame: int) -> str:
    """The path that a pattern has at a frame. Negative frames are written as printf does: "-005"."""

    def piece(match: re.Match[str]) -> str:
        plain, hashes, houdini, printf = match.groups()
        if plain:
            return plain
        digits = len(hashes) if hashes else int(houdini or printf or 1)
        if not hashes and digits > _LARGEST_INT:  # what the program cannot read as a width
            digits = 1
        return format(frame, f"0{min(max(digits, 1), _MOST_DIGITS)}d")

    return _PLACE.sub(piece, pattern)


def without_frame(pattern: str) -> str:
    """The pattern without what stands for the frame, and with plain characters as they are in a path."""
    return _PLACE.sub(lambda match: match[1] or "", pattern)


def pattern_of(path: str) -> str:
    """The pattern that names `path` at all frames, whatever characters are in it."""
    return re.sub(r"[$#%]", r"$\g<0>", path)
