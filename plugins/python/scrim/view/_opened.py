# SPDX-License-Identifier: Apache-2.0
"""What a viewer looks at, before anything of it is rendered."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scrim_kit import toml_text
from scrim_kit.frames import at_frame, pattern_of

from .._errors import OutputError

if TYPE_CHECKING:
    from ._document import Change, Place


@dataclass(frozen=True)
class Opened:
    """What a viewer looks at.

    `text`: the scene.  `file`: the file of the scene; "": it has none yet.  `folder`: paths of the scene are relative
    to it, and the scene may be saved there.  `input`, `options`: what a command line names as its input, and its
    further words.  `frames`, `frame`: all frames, and the first one to show.  `ocio`: the config of OpenColorIO, "":
    that of the environment.  `others`: files of the same folder that the page may open. `text_at(frame)`: the scene
    of a frame of a stage; None: all frames have one scene.  `keeps`: an object that owns files of the scene: the shot
    of a stage, or the user's.  `temporary`: the folder of the files that are removed with `keeps`; "": there are
    none.  `cameras`: paths of the stage's cameras, for `keeps.through`. `grids`: grids made in code, by names of
    volumes.  `loaded`: a shot that has loaded the volumes of the scene, and that nobody else uses."""

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

    def temporary_files(self, scene: Mapping) -> dict[str, str]:
        """Paths of the scene's files in the folder `temporary`, by their names in the scene. Any key may name one: of
        meshes, volumes, grids, pictures of domes, profiles of lights."""
        if not self.temporary:
            return {}
        texts = {text for whole in _texts(scene) for text in (whole, whole.rpartition(":")[0])}  # FILE or FILE:GRID
        paths = {text: at_frame(text, 1) for text in texts}  # names of single files, written as patterns
        begin = self.temporary + os.sep
        return {text: path for text, path in paths.items() if path.startswith(begin) and os.path.isfile(path)}

    def check_new(self, name: str) -> None:
        """Raises OutputError where a scene of this name, or the folder for its files, exists."""
        for path in (os.path.join(self.folder, name), self._files_of(name)):
            if os.path.lexists(path):
                raise OutputError(f"{path}: there is such a file already; choose another name")

    def copied(self, files: Mapping[str, str], name: str) -> dict[str, str]:
        """Copies files into the folder for the files of the scene `name`. Returns their new names, by their names in
        the present scene. A file keeps its place below the temporary folder, so equal names stay apart. Raises
        OutputError."""
        folder, names = self._files_of(name), {}
        try:
            os.mkdir(folder)
            for text, path in files.items():
                inside = os.path.relpath(path, self.temporary)
                os.makedirs(os.path.dirname(os.path.join(folder, inside)), exist_ok=True)
                shutil.copy(path, os.path.join(folder, inside))
                names[text] = pattern_of(os.path.join(os.path.basename(folder), inside))
        except OSError as error:
            if not isinstance(error, FileExistsError):
                self.forget_copies(name)
            raise OutputError(f"cannot write to '{folder}': {error.strerror}") from error
        return names

    def forget_copies(self, name: str) -> None:
        """Removes the files that were copied for a scene that could not be saved."""
        shutil.rmtree(self._files_of(name), ignore_errors=True)

    def _files_of(self, name: str) -> str:
        return os.path.join(self.folder, name.removesuffix(".toml") + ".files")

    def command(self, file: str, sets: list[str], overrides: Mapping[str, object], frame: int | None) -> str:
        """The command line that renders the scene. `file`: of the saved scene; "": `input`. `sets`: texts for --set."""
        sets = sets + [toml_text.assignment(key, value) for key, value in overrides.items()]
        words = ["scrim", "render", file or self.input, *self.options]
        words += [word for one in sets for word in ("--set", one)]
        words += ["--frames", str(frame)] if frame is not None else []
        return shlex.join([*words, "-o", "picture.exr"])


def _texts(value: object) -> Iterator[str]:
    """All strings in a scene."""
    if isinstance(value, str):
        yield value
    for one in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        yield from _texts(one)


def renamed_files(value: object, names: Mapping[str, str], place: Place = ()) -> Iterator[Change]:
    """The changes that give the files in a scene other names."""
    if isinstance(value, Mapping):
        for key, one in value.items():
            yield from renamed_files(one, names, (*place, key))
    elif isinstance(value, list) and any(isinstance(one, Mapping) for one in value):
        for index, one in enumerate(value):
            yield from renamed_files(one, names, (*place, index))
    elif (new := _renamed(value, names)) != value:
        yield place, new


def _renamed(value: object, names: Mapping[str, str]) -> object:
    if isinstance(value, list):
        return [_renamed(one, names) for one in value]
    if not isinstance(value, str):
        return value
    file, colon, grid = value.rpartition(":")
    return names.get(value) or (names[file] + colon + grid if file in names else value)
