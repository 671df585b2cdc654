# SPDX-License-Identifier: Apache-2.0
"""What a viewer looks at, before anything of it is rendered."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scrim_kit import toml_text

from .._errors import OutputError

if TYPE_CHECKING:
    from ._document import Change


@dataclass(frozen=True)
class Opened:
    """What is looked at. `text`: the scene; `file`: its own file, "" where it has none yet; `folder`: what its paths
    are relative to, and where it may be saved; `input`: what a command line names; `options`: further words of it;
    `others`: files beside it that the page may open; `text_at`: the scene of another frame, where each has one of its
    own; `keeps`: what the scene's files live as long as; `temporary`: the folder of those that end with it; `cameras`:
    paths of a stage's cameras, through which `keeps` can look; `grids`: made in code, by the names of volumes;
    `loaded`: a shot whose volumes need not be loaded again, and which nobody uses any more."""

    text: str
    file: str
    folder: str
    input: str
    frames: list[int]
    frame: int = 1
    ocio: str = ""
    options: list[str] = field(default_factory=list)
    others: list[str] = field(default_factory=list)
    text_at: Callable[[int], str] | None = None
    keeps: object = None
    temporary: str = ""
    cameras: list[str] = field(default_factory=list)
    grids: Mapping[str, object] = field(default_factory=dict)
    loaded: object = None

    def with_files(self, scene: Mapping, name: str) -> list[Change]:
        """Copies the scene's temporary files into a folder beside the scene that will have this name: what must be
        changed in it then. Raises OutputError."""
        beside, changes = name.removesuffix(".toml") + ".files", []
        for kind in ("mesh", "volume"):
            for index, table in enumerate(scene.get(kind, [])):
                file = table.get("file")
                if isinstance(file, str) and os.path.abspath(file).startswith(self.temporary + os.sep):
                    changes.append(((kind, index, "file"), f"{beside}/{os.path.basename(file)}"))
                    self._copy(file, beside)
        return changes

    def _copy(self, file: str, beside: str) -> None:
        try:
            os.makedirs(os.path.join(self.folder, beside), exist_ok=True)
            shutil.copy(file, os.path.join(self.folder, beside))
        except OSError as error:
            raise OutputError(f"cannot write to '{beside}': {error.strerror}") from error

    def command(
        self, file: str, sets: list[str], view: Mapping[str, object], muted: Iterable[str], frame: int | None
    ) -> str:
        """The command line that renders a scene of this: `file` "" is what was opened; `sets` are texts for --set."""
        sets = sets + [toml_text.assignment(key, value) for key, value in view.items()]
        sets += [f"{name}.intensity=0.0" for name in sorted(muted) if name.startswith("light.")]
        sets += ["ambient.color=[0.0, 0.0, 0.0]"] if "ambient" in muted else []
        words = ["scrim", "render", file or self.input, *self.options]
        words += [word for one in sets for word in ("--set", one)]
        words += ["--frames", str(frame)] if frame is not None else []
        return shlex.join([*words, "-o", "picture.exr"])
