# SPDX-License-Identifier: Apache-2.0
"""Pictures as arrays of NumPy, for tools that write no EXR and for what compares frames: the reader and writer of the
add-on for Blender."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "plugins" / "blender"))
from scrim.exr import read as read_channels  # noqa: E402
from scrim.exr import write  # noqa: E402, F401


def read(path):
    """(height, width, 3) of the display window; `path` is an uncompressed scan-line file."""
    picture = read_channels(path)
    x0, y0, x1, y1 = picture.display_window
    names = {name.split(".")[-1]: name for name in picture.channels}
    return np.stack([picture.region(names[c], x0, y0, x1 - x0 + 1, y1 - y0 + 1) for c in "RGB"], axis=-1)
