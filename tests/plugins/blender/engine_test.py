# SPDX-License-Identifier: Apache-2.0
# What the engine tells of a run comes from the numbers and words that the program writes for machines. Runs with and
# without Blender.
import json
import os
import subprocess
import sys
from types import ModuleType, SimpleNamespace
from unittest import mock

import pytest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "plugins", "blender"))


def stand_ins():
    """Modules in place of Blender's, as far as the engine's own need them to be imported."""
    bpy = mock.MagicMock(types=SimpleNamespace(RenderEngine=object))
    names = ("gpu", "gpu_extras", "gpu_extras.presets", "mathutils")
    return {"bpy": bpy, **{name: mock.MagicMock() for name in names}}


@pytest.fixture
def engine():
    try:
        import bpy  # noqa: F401
    except ImportError:
        with mock.patch.dict(sys.modules, stand_ins()):
            from scrim import engine as module

            assert isinstance(module, ModuleType)
            yield module
    else:
        from scrim import engine as module

        yield module


def ran(engine, folder, program):
    """What the engine shows after a run of a program, and the statistics that the run wrote."""
    path, stats = folder / "scrim", folder / "stats.json"
    path.write_text(f"#!/bin/sh\n{program}\n")
    path.chmod(0o755)
    shown = []
    run = SimpleNamespace(
        warn=shown.append,
        cancelled=lambda: False,
        update_progress=shown.append,
        update_stats=lambda _, text: shown.append(text),
        update_memory_stats=lambda **values: shown.append(values),
    )
    engine.ScrimRenderEngine.run(run, [str(path), str(stats)], str(stats))
    return shown


def test_the_pages_recipe_for_light_linking_is_what_the_program_takes(engine, tmp_path):
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
    with open(os.path.join(root, "examples", "BLENDER.md"), encoding="utf-8") as file:
        page = file.read()
    recipe = page[page.index("**Light linking**") :].split("```\n")[1].strip()
    settings = SimpleNamespace(tolerance=0.0, quality="DRAFT", verify=0, overrides=recipe)
    scene = SimpleNamespace(scrim=settings, render=SimpleNamespace(threads_mode="AUTO"))
    with mock.patch.object(engine.colour, "config_file", return_value=""):
        arguments = engine.arguments_for(scene, str(tmp_path))
    assert arguments[-4:] == [
        "--set", 'volume.Smoke.lights=["Key", "Rim"]', "--set", 'volume.Smoke.shadows=["Key"]'
    ]  # fmt: skip
    lights = "".join(
        f'[[light]]\nname = "{name}"\ntype = "distant"\ndirection = [0, 0, -1]\n' for name in ("Key", "Rim", "World")
    )
    (tmp_path / "shot.toml").write_text(
        '[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\nresolution = [8, 8]\n[[volume]]\nname = "Smoke"\n'
        f'source = "noise"\nparameters = {{ resolution = 8 }}\n{lights}'
    )
    done = subprocess.run(
        [os.environ["SCRIM"], "plan", str(tmp_path / "shot.toml"), *arguments[-4:]],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_a_run_is_summed_up_by_its_statistics(engine, tmp_path):
    told = {"frame": 1, "summary": "0.20 s; error 0.5 %", "peak_memory_bytes": 3 * 2**20}
    shown = ran(engine, tmp_path, f"""
echo 'frame 1: /tmp/a, b/picture.exr 8x8, another sentence' >&2
echo '{json.dumps([told])}' >"$1"
""")
    assert engine.last_run["text"] == told["summary"]
    assert f"Scrim: {told['summary']}" in shown
    assert {"memory_used": 3.0, "memory_peak": 3.0} in shown
