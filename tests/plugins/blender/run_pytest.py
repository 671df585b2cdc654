# SPDX-License-Identifier: Apache-2.0
# pytest, and then the end at once: bpy may hang where Python takes it apart.
import os
import sys

import pytest

# In a Blender, whose own options come first, those behind "--" are ours.
status = pytest.main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)
