# SPDX-License-Identifier: Apache-2.0
"""`python -m scrim.usd FILE FOLDER --frames LIST`: the scenes of a stage as TOML files in FOLDER, for the program.

What was made is told on stdout, a line each, in fields with tabs between: `stage FIRST LAST`, `scene FRAME FILE CROP`,
`warning TEXT`, `note TEXT`, and `error KIND TEXT`, after which it ends with status 1.
"""

from __future__ import annotations

import argparse
import os
import sys

from .. import _errors, _toml
from . import _DISTANT, _MESHES, _PURPOSES, _chosen, _need_openusd


def _say(*fields: object) -> None:
    print("\t".join(" ".join(str(f).split()) for f in fields))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m scrim.usd", description="Scenes of an OpenUSD stage.")
    parser.add_argument("file")
    parser.add_argument("folder", help="where scenes and meshes go")
    parser.add_argument("--frames", metavar="LIST", help="a file that holds 1,2,5; without it the first of the stage")
    parser.add_argument("--camera")
    parser.add_argument("--settings")
    parser.add_argument("--purpose")
    parser.add_argument("--sidecar")
    parser.add_argument("--distant", default="radiance")
    parser.add_argument("--meshes", default="holdout")
    parser.add_argument("--res", help="WxH")
    return parser.parse_args()


def _frames(path: str) -> list[int]:
    with open(path, encoding="utf-8") as file:
        return [int(frame) for frame in file.read().split(",")]


def _write(given: argparse.Namespace) -> None:
    _need_openusd()
    from . import _own, _reading
    from ._scene import scene_at

    purpose = tuple(_chosen("--purpose", p, _PURPOSES) for p in given.purpose.split(",")) if given.purpose else None
    options = _reading.Options(
        given.camera,
        given.settings,
        purpose,
        given.sidecar,
        _chosen("--distant", given.distant, _DISTANT),
        _chosen("--meshes", given.meshes, _MESHES),
        tuple(int(side) for side in given.res.split("x")) if given.res else None,
    )
    stage = _reading.opened_stage(given.file)
    sidecar = _own.Sidecar(given.sidecar)
    sidecar.check(stage)
    there = _reading.frames_of(stage)
    _say("stage", there[0], there[-1])
    messages = _reading.Messages()
    for frame in _frames(given.frames) if given.frames else there[:1]:
        made = scene_at(stage, frame, options, sidecar, messages, given.folder)
        path = os.path.join(given.folder, f"{frame}.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(_toml.document(made.scene))
        _say("scene", frame, os.path.basename(path), ",".join(map(str, made.crop or ())))
    for kind, lines in (("warning", messages.warnings), ("note", messages.notes)):
        for line in lines:
            _say(kind, line)


def main() -> int:
    given = _arguments()
    try:
        _write(given)
    except _errors.Error as problem:
        _say("error", "usage" if isinstance(problem, _errors.UsageError) else "input", problem)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
