# SPDX-License-Identifier: Apache-2.0
"""The volumes of a shot by name, and what may be set of each: `shot.volumes["smoke"].ax = "f@density *= 2;"`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, overload

from ._errors import UsageError

if TYPE_CHECKING:
    from ._scrim import Shot


class Volumes(list):
    """The names of a shot's volumes, in the scene's order. `volumes[name]` is the Volume of this name."""

    def __init__(self, shot: Shot, names: list[str]) -> None:
        super().__init__(names)
        self._shot = shot

    @overload
    def __getitem__(self, index: str) -> Volume: ...
    @overload
    def __getitem__(self, index: int) -> str: ...

    def __getitem__(self, index):  # noqa: ANN001, ANN204
        if not isinstance(index, str):
            return super().__getitem__(index)
        if index not in self:
            names = " or ".join(f"'{name}'" for name in self) or "none"
            raise UsageError(f"{self._shot.path}: there is no volume {index!r}; there is {names}")
        return Volume(self._shot, index)


class Volume:
    """A volume of a shot. Assignments override the scene in all frames, as `Shot.set` does."""

    def __init__(self, shot: Shot, name: str) -> None:
        self._shot = shot
        self.name = name

    @property
    def ax(self) -> str:
        """The expression in OpenVDB AX that runs over the volume; "" where there is none."""
        return self._shot._code(self.name)[0]

    @ax.setter
    def ax(self, code: str) -> None:
        self._shot.set({f"volume.{self.name}.ax": code})

    @property
    def parameters(self) -> Parameters:
        """Numbers and vectors that expressions know as `$name` and `v$name`, and those of a source."""
        return Parameters(self._shot, self.name)

    @parameters.setter
    def parameters(self, values: Mapping[str, object]) -> None:
        self._shot.set({f"volume.{self.name}.parameters": dict(values)})

    @property
    def grids(self) -> dict[str, object]:
        """What the volume is put together from, by the names of its grids: "FILE:GRID", {"add": ["FILE:GRID", ...]},
        {"max": [...]} or {"multiply": [...]}, with absolute paths. {} where it has one file, or a source."""
        return self._shot._grids_of(self.name)

    @grids.setter
    def grids(self, grids: Mapping[str, object]) -> None:
        self._shot.set({f"volume.{self.name}.grids": dict(grids)})

    def __repr__(self) -> str:
        return f"<volume '{self.name}' of '{self._shot.path}'>"


class Parameters(Mapping):
    """The parameters of a volume. Keyed ones have the value of the frame at which the scene was read; those of a source
    are text. A parameter that no expression uses is not among them."""

    def __init__(self, shot: Shot, volume: str) -> None:
        self._shot, self._volume = shot, volume

    def __getitem__(self, name: str) -> object:
        return self._shot._code(self._volume)[1][name]

    def __setitem__(self, name: str, value: object) -> None:
        self._shot.set({f"volume.{self._volume}.parameters.{name}": value})

    def __iter__(self) -> Iterator[str]:
        return iter(self._shot._code(self._volume)[1])

    def __len__(self) -> int:
        return len(self._shot._code(self._volume)[1])

    def __repr__(self) -> str:
        return repr(dict(self))
