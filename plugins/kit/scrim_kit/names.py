# SPDX-License-Identifier: Apache-2.0
"""Names for volumes, lights and meshes of a scene."""

from __future__ import annotations

import re


class Names:
    """Names of one scene, each of which is given once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def of(self, *candidates: str) -> str:
        """The first of the candidates that is free, else the last with a number behind it: "Key_2". Names consist of
        letters, digits and underscores; other characters become underscores."""
        plain = [re.sub(r"[^A-Za-z0-9_]", "_", text) or "_" for text in candidates]
        name = next((text for text in plain if text not in self._taken), plain[-1])
        number = 1
        while name in self._taken:
            number += 1
            name = f"{plain[-1]}_{number}"
        self._taken.add(name)
        return name
