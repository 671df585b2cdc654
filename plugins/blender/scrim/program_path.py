# SPDX-License-Identifier: Apache-2.0
# Where the add-on finds the program scrim.
import os
import shutil

from .scrim_kit import Failure


def program_path(preference=""):
    """The path of the program that the add-on's preferences name, else $SCRIM, else that in PATH. Raises Failure."""
    for where, named in (
        ("the add-on's preferences name", preference),
        ("$SCRIM names", os.environ.get("SCRIM", "")),
    ):
        if named:
            found = shutil.which(os.path.expanduser(named))
            if not found:
                raise Failure(f"{where} '{named}' as the program scrim, which cannot be run")
            return found
    found = shutil.which("scrim")
    if not found:
        raise Failure(
            "the program scrim was not found: name it in the add-on's preferences, in $SCRIM, or add it to PATH"
        )
    return found
