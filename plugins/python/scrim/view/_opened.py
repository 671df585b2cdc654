# SPDX-License-Identifier: Apache-2.0
"""What a viewer looks at, before anything of it is rendered."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Opened:
    """What is looked at. `text`: the scene; `file`: its own file, "" where it has none yet; `folder`: what its paths
    are relative to, and where it may be saved; `input`: what a command line names; `options`: further words of it;
    `others`: files beside it that the page may open; `keeps`: what the scene's files live as long as."""

    text: str
    file: str
    folder: str
    input: str
    frames: list[int]
    frame: int = 1
    ocio: str = ""
    options: list[str] = field(default_factory=list)
    others: list[str] = field(default_factory=list)
    keeps: object = None
