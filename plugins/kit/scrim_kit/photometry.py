# SPDX-License-Identifier: Apache-2.0
"""How strong a lamp is, by its photometric file (IES LM-63). Scrim reads the directions itself, relative to the largest
candela value; other programs multiply by candelas."""

from __future__ import annotations

import math
from pathlib import Path

from .failure import Failure


class Photometry:
    """A file of type C. `vertical`, `horizontal`: angles in degrees. `candelas`: for each horizontal angle, a list of
    the values at all vertical angles. `largest`: the largest of them."""

    def __init__(self, path: str | Path) -> None:
        try:
            text = Path(path).read_text(encoding="latin-1")
            at = next(i for i, line in enumerate(text.splitlines()) if line.lstrip().startswith("TILT"))
            lines = text.splitlines()[at:]
            words = " ".join(lines[1:]).replace(",", " ").replace("\x1a", " ").split()
            if lines[0].partition("=")[2].strip() == "INCLUDE":
                words = words[2 + 2 * int(words[1]) :]
            # The multiplier, the ballast factor, and the factor of the lamp with this ballast.
            factor = float(words[2]) * float(words[10]) * float(words[11])
            vertical, horizontal = int(words[3]), int(words[4])
            if words[5] != "1":
                raise ValueError("its photometric type is not C")
            values = [float(word) for word in words[13:]]
            self.vertical = values[:vertical]
            self.horizontal = values[vertical : vertical + horizontal]
            rest = values[vertical + horizontal :]
            self.candelas = [
                [factor * c for c in rest[h * vertical : (h + 1) * vertical]] for h in range(horizontal)
            ]
            self.largest = max(map(max, self.candelas))
            if len(rest) != vertical * horizontal:
                raise ValueError(f"it has {len(rest)} candela values, expected {vertical * horizontal}")
            if min(map(min, self.candelas)) < 0 or self.largest <= 0:
                raise ValueError("its candela values are below 0, or all 0")
        except (OSError, ValueError, IndexError, StopIteration) as error:
            raise Failure(f"{path}: not a photometric file (IES LM-63): {error}", 3) from error

    @property
    def power(self) -> float:
        """The integral of the candelas over all directions, by trapezoids in both angles."""
        rows = [self._around(v) for v in range(len(self.vertical))]
        total = 0.0
        for v in range(len(rows) - 1):
            # Candelas are linear in the angle t from a to b. Their weights are the integrals over t of
            # sin(t) (b - t) / (b - a) and sin(t) (t - a) / (b - a).
            a, b = (math.radians(x) for x in self.vertical[v : v + 2])
            first = math.cos(a) - (math.sin(b) - math.sin(a)) / (b - a)
            second = (math.sin(b) - math.sin(a)) / (b - a) - math.cos(b)
            total += first * rows[v] + second * rows[v + 1]
        return total

    @property
    def mean(self) -> float:
        """The mean of the candelas over the sphere, or over the half sphere that the vertical angles span. UsdLux'
        normalize divides by it: OpenUSD's pxrIES.cpp, which says that RenderMan and Karma do the same."""
        whole = math.radians(self.vertical[-1] - self.vertical[0]) > math.pi / 2 + 0.1
        return self.power / (math.pi * (4 if whole else 2))

    def _around(self, v: int) -> float:
        """Candelas at one vertical angle, integrated over the whole turn."""
        column = [row[v] for row in self.candelas]
        if len(column) == 1:
            return 2 * math.pi * column[0]
        angles, covered = self.horizontal, self.horizontal[-1] - self.horizontal[0]
        if covered > 180:  # a whole turn; files may leave out its last angle, 360, which is the first one
            angles, column, covered = [*angles, 360.0 + angles[0]], [*column, column[0]], 360.0
        pairs = zip(zip(angles, angles[1:]), zip(column, column[1:]))
        return sum(math.radians(b - a) * (p + q) / 2 for (a, b), (p, q) in pairs) * 360 / covered
