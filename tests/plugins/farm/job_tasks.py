# SPDX-License-Identifier: Apache-2.0
"""Jobs for tests: a small scene, its job in a folder, and the job's tasks one after the other, as Open Job Description
would run them."""
import json
import os
import subprocess

HERE = os.path.dirname(os.path.realpath(__file__))
SUBMIT = os.path.join(HERE, "..", "..", "..", "plugins", "farm", "scrim-submit")
SCRIM = os.environ.get("SCRIM", "scrim")

SCENE = """[camera]
position = [0, 0, 3]
target = [0, 0, 0]
resolution = [32, 24]
[[volume]]
source = "noise"
parameters = { resolution = 16 }
"""


def told(command, place):
    """What a command that must succeed prints."""
    done = subprocess.run(command, capture_output=True, text=True, cwd=place, check=False, timeout=60)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout


def submit(place, *arguments):
    told([SUBMIT, *arguments, "--on", "openjd", "--scrim", SCRIM, "--cpus", "1"], place)


def task_commands(folder, frames):
    """Those of all steps of the template: renders, merges, and the check."""
    with open(os.path.join(folder, "template.json"), encoding="utf-8") as text:
        template = json.load(text)
    commands = []
    for step in template["steps"]:
        space = step.get("parameterSpace", {"taskParameterDefinitions": []})["taskParameterDefinitions"]
        tiles = next((int(p["range"].split("-")[1]) + 1 for p in space if p["name"] == "Tile"), 1)
        for tile in range(tiles):
            words = step["script"]["actions"]["onRun"]["args"][2:]
            for name, value in (("Param.Folder", folder), ("Task.Param.Frame", frames), ("Task.Param.Tile", str(tile))):
                words = [word.replace("{{" + name + "}}", value) for word in words]
            commands.append([SUBMIT, *words])
    return commands


def run_tasks(folder, frames):
    """Returns what the check prints."""
    return [told(command, folder) for command in task_commands(folder, frames)][-1]
