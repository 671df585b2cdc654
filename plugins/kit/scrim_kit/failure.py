# SPDX-License-Identifier: Apache-2.0
"""What a front end tells its user."""

from __future__ import annotations


class Failure(Exception):
    """Its text is one line for the user. `status` is the exit status that the program `scrim` has for its kind of
    error (see `program.Status`)."""

    def __init__(self, text: str, status: int = 2) -> None:
        super().__init__(text)
        self.status = status
