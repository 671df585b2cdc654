# SPDX-License-Identifier: Apache-2.0
"""Open Job Description (2023-09, with TASK_CHUNKING): a job bundle, which Deadline Cloud and openjd-cli run."""
import os

from scrim_kit.frames import range_text

from .job import ISOLATED, PROGRAM, write_json


def action(arguments, timeout):
    return {"command": "{{Param.Python}}", "args": [ISOLATED, "{{Param.Submit}}", *arguments], "timeout": timeout,
            # The first signal lets scrim leave no half file.
            "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 30}}


def render_step(job, timeout):
    definitions = [{"name": "Frame", "type": "CHUNK[INT]", "range": "{{Param.Frames}}",
                    "chunks": {"defaultTaskCount": job["chunk"], "rangeConstraint": "CONTIGUOUS"}}]
    arguments = ["--frames={{Task.Param.Frame}}", "--openjd-task", "{{Param.Folder}}", "render"]
    if job.tiled:
        definitions.append({"name": "Tile", "type": "INT", "range": f"0-{len(job['crops']) - 1}"})
        arguments.append("{{Task.Param.Tile}}")
    return {"name": "Render", "parameterSpace": {"taskParameterDefinitions": definitions},
            "script": {"actions": {"onRun": action(arguments, timeout)}},
            "hostRequirements": {"amounts": [{"name": "amount.worker.vcpu", "min": job["cpus"]},
                                             {"name": "amount.worker.memory", "min": -(-job["memory"] >> 20)}]}}


def merge_step(job, timeout):
    definitions = [{"name": "Frame", "type": "CHUNK[INT]", "range": "{{Param.Frames}}",
                    "chunks": {"defaultTaskCount": job["chunk"], "rangeConstraint": "CONTIGUOUS"}}]
    arguments = ["--frames={{Task.Param.Frame}}", "--openjd-task", "{{Param.Folder}}", "merge"]
    return {"name": "Merge", "dependencies": [{"dependsOn": "Render"}],
            "parameterSpace": {"taskParameterDefinitions": definitions},
            "script": {"actions": {"onRun": action(arguments, timeout)}}}


def template_of(job, python):
    timeout = 24 * 3600
    steps = [render_step(job, timeout)] + ([merge_step(job, timeout)] if job.tiled else [])
    steps.append({"name": "Check", "dependencies": [{"dependsOn": steps[-1]["name"]}],
                  "script": {"actions": {"onRun": action(["--status", "{{Param.Folder}}"], timeout)}}})

    def text(name, default, what):
        return {"name": name, "type": "STRING", "default": default, "description": what}

    return {
        "specificationVersion": "jobtemplate-2023-09", "extensions": ["TASK_CHUNKING"], "name": job["name"],
        "parameterDefinitions": [
            text("Frames", range_text(job["frames"]), "frames to do"),
            # Relative to the template, as the specification wants it.
            {"name": "Folder", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT", "default": ".",
             "description": "the folder of the job"},
            text("Submit", PROGRAM, "scrim-submit on the workers"),
            text("Python", python, "Python on the workers, 3.11 or later"),
        ],
        "steps": steps,
    }


def write_bundle(job, python):
    """The folder of the job is the bundle, since paths of a template may not leave its folder. Returns the files."""
    files = {"template.json": template_of(job, python),
             "parameter_values.json": {"parameterValues": [{"name": "Frames", "value": range_text(job["frames"])}]},
             "asset_references.json": {"assetReferences": {
                 "inputs": {"filenames": [job["scene"]], "directories": [os.path.dirname(job["scene"])]},
                 "outputs": {"directories": job.output_folders()}}}}
    for name, content in files.items():
        write_json(job.path(name), content)
    return [job.path(name) for name in files]
