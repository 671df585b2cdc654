# SPDX-License-Identifier: Apache-2.0
"""`python -m scrim ARGUMENTS`: the program `scrim` that this package holds, else the system's."""

import os
import sys


def program() -> str:
    """The path of the program."""
    own = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "scrim")
    return own if os.path.exists(own) else "/usr/bin/scrim"


def main() -> None:
    # It takes the place of this process: signals and the exit status are the program's own.
    os.environ.setdefault("SCRIM_PYTHON", sys.executable)  # what reads OpenUSD for it
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(program(), ["scrim", *sys.argv[1:]])


if __name__ == "__main__":
    main()
