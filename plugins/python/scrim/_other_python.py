# SPDX-License-Identifier: Apache-2.0
"""What to do where Scrim's module was built for another Python than the one that runs."""

import pathlib
import re
import sys


def advice() -> str:
    folder = pathlib.Path(__file__).parent
    built = sorted(folder.glob("_scrim.*.so"))
    this = f"{sys.version_info.major}.{sys.version_info.minor}"
    if not built:
        return f"{folder} holds no module _scrim: build it with -DSCRIM_BUILD_PYTHON=ON, or install the wheel"
    found = re.search(r"cpython-(\d)(\d+)", built[0].name)
    other = f"{found[1]}.{found[2]}" if found else "another version"
    return (
        f"{built[0]} is for Python {other}, and this is Python {this} ({sys.executable}): run python{other}, or "
        f"configure with -DPython_EXECUTABLE={sys.executable} and build again"
    )
