# SPDX-License-Identifier: Apache-2.0
# The add-on as users of a Blender before 4.2 get it: a zip that is installed, enabled, and there in the next session.
# BLENDER: the program.
import os
import subprocess
import sys

import numpy as np
import pytest

HERE = os.path.dirname(os.path.abspath(__file__))
PLUGINS = os.path.join(HERE, "..", "..", "..", "plugins", "blender")
sys.path.insert(0, PLUGINS)
from scrim import exr  # noqa: E402

BLENDER, SCRIM = os.environ["BLENDER"], os.environ["SCRIM"]
INSTALL = """
import bpy
assert bpy.ops.preferences.addon_install(filepath={zipped!r}) == {{"FINISHED"}}
assert bpy.ops.preferences.addon_enable(module="scrim") == {{"FINISHED"}}
bpy.context.preferences.addons["scrim"].preferences.program = {program!r}
bpy.ops.wm.save_userpref()
"""
SAVE = """
import bpy, os, sys
import scrim
assert os.path.dirname(scrim.__file__) == os.path.join({home!r}, "scripts", "addons", "scrim"), scrim.__file__
import scenes as s
s.cleared()
s.volume({smoke!r}, Density=4.0)
s.light("SUN", (3, -2, 3), energy=4.0, angle=0.0)
settings = bpy.context.scene.render.image_settings
settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "32", "NONE"
bpy.context.scene.scrim.overrides = {overrides!r}
bpy.ops.wm.save_as_mainfile(filepath={target!r})
"""
RENDER = """
import bpy
bpy.context.scene.render.filepath = {target!r}
bpy.ops.render.render(write_still=True)
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """What the user has: the add-on from a zip, and its preferences."""
    home = tmp_path_factory.mktemp("home")
    folder = tmp_path_factory.mktemp("zip")
    zipped = str(folder / "scrim.zip")
    subprocess.run([sys.executable, os.path.join(PLUGINS, "make_zip.py"), zipped], check=True, timeout=60)
    done = blender(home, "--python-expr", INSTALL.format(zipped=zipped, program=SCRIM))
    assert done.returncode == 0, done.stdout
    smoke = str(home / "ball.vdb")
    subprocess.run([SCRIM, "make", "noise", "resolution=32", "shape=ball", "-o", smoke, "-q"], check=True, timeout=60)
    for name, overrides in (("good", ""), ("bad", "render.texel=1000")):
        text = SAVE.format(home=str(home), smoke=smoke, overrides=overrides, target=str(home / f"{name}.blend"))
        done = blender(home, "--python-expr", text)
        assert done.returncode == 0, done.stdout
    return home


def blender(home, *words):
    env = {name: value for name, value in os.environ.items() if name != "SCRIM"}
    for kind in ("CONFIG", "SCRIPTS", "DATAFILES"):
        env[f"BLENDER_USER_{kind}"] = str(home / kind.lower())
    env["PYTHONPATH"] = HERE
    command = [BLENDER, "--background", "--python-use-system-env", "--python-exit-code", "9", *words]
    return subprocess.run(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120)


def test_it_is_installed_and_renders(home):
    target = home / "good.exr"
    done = blender(home, str(home / "good.blend"), "--python-expr", RENDER.format(target=str(target)))
    assert done.returncode == 0, done.stdout
    got = exr.read(str(target)).channels
    assert 0.05 < got["R"].max() < 2 and got["A"].max() > 0.9
    assert np.all(got["A"][0] == 0)


def test_a_render_that_fails_ends_with_a_status_and_leaves_no_file(home):
    target = home / "bad.exr"
    done = blender(home, str(home / "bad.blend"), "--python-expr", RENDER.format(target=str(target)))
    assert done.returncode == 9 and "Scrim: " in done.stdout and "'texel' is 1000" in done.stdout, done.stdout
    assert not target.exists()


def test_frames_on_the_command_line(home):
    """As farms call it: here too, no picture where it failed."""
    for name in ("good", "bad"):
        done = blender(home, str(home / f"{name}.blend"), "-o", str(home / f"{name}_"), "-f", "1")
        assert (home / f"{name}_0001.exr").exists() == (name == "good"), done.stdout
        assert ("'texel' is 1000" in done.stdout) == (name == "bad"), done.stdout
        assert (done.returncode == 0) == (name == "good"), done.stdout
