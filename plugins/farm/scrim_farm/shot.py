# SPDX-License-Identifier: Apache-2.0
"""Makes the folder of a job. What a render would choose by itself is chosen here, once for the shot, since tasks on
unlike machines and of unlike frames would not choose alike."""
import hashlib
import json
import os
import re
import shutil
import tomllib

from scrim_kit import Failure, program, toml_text
from scrim_kit.frames import at_frame, parse_range, pattern_of, without_frame

from .job import Job, crops_of, write_json

SIMD_FLAGS = {"sse4": ("sse4_1", "sse4_2"), "avx2": ("avx2", "fma", "bmi2", "f16c"),
              "avx512": ("avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512cd")}
GIB = 1 << 30
PART_SMALLEST = GIB // 2  # of merges and checks


def parse_size(text):
    match = re.fullmatch(r"(\d+)([KMGT]?)", text)
    if not match or int(match[1]) == 0:
        raise Failure(f"--memory {text}: expected a size such as 8G or 512M")
    return int(match[1]) << {"": 0, "K": 10, "M": 20, "G": 30, "T": 40}[match[2]]


def resolved_sets(render, given, simd):
    """--set arguments that leave a task nothing to choose. `render`: of `scrim plan --json`; `given`: of the scene."""
    if "tolerance" in given:  # a tolerance chooses dials anew for each picture
        render = {key: render[key] for key in ("cross_fade", "simd")}
    machine = "avx2" if render["simd"] == "auto" else render["simd"]
    return [toml_text.assignment(f"render.{key}", value) for key, value in (render | {"simd": simd or machine}).items()]


def memory_of(crops, plan_of):
    """For a task: what the plan of the tile in the middle needs, the grids thrice, since a child reads the next frame's
    meanwhile, and a reserve."""
    plan = plan_of("--crop=" + ",".join(map(str, crops[len(crops) // 2])))
    return int((plan["plan"]["bytes"] + 3 * plan["field_bytes"]) / 0.85) + GIB // 2


def arguments_of(options):
    """Options of scrim's that are passed on."""
    arguments = []
    for name in ("quality", "res", "ocio", "missing"):
        value = getattr(options, name)
        if value:
            arguments += [f"--{name}", os.path.abspath(value) if name == "ocio" else value]
    for value in options.set:
        arguments += ["--set", value]
    return arguments


def check_options(options):
    """Returns the program, columns and rows of tiles, frames, and the folder of the job."""
    if not options.frames:
        raise Failure("expected --frames 1-240")
    scrim = shutil.which(options.scrim)
    if scrim is None:
        raise Failure(f"there is no program '{options.scrim}'; --scrim PATH names it")
    if not os.path.isfile(options.scene) and options.scene.endswith(".toml"):
        raise Failure(f"there is no scene {options.scene}", 3)
    tiles = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", options.tiles)
    if not tiles:
        raise Failure(f"--tiles {options.tiles}: expected COLUMNSxROWS, such as 2x2")
    frames = sorted(parse_range(options.frames, "--frames"))
    folder = os.path.abspath(options.folder or stem_of(options.scene) + ".farm")
    if os.path.exists(os.path.join(folder, "job.json")):
        raise Failure(f"{folder} already holds a job; --resume {folder} continues it, --folder names another one")
    return os.path.abspath(scrim), (int(tiles[1]), int(tiles[2])), frames, folder


def stem_of(path):
    stem = os.path.splitext(os.path.basename(path))[0]
    return stem if os.path.exists(path) else without_frame(stem).rstrip(".")


def check_outputs(outputs, frames):
    """Raises Failure unless each frame has files of its own, whose names are known."""
    for pattern in (output["pattern"] for output in outputs.values()):
        if len(frames) > 1 and at_frame(pattern, 1) == at_frame(pattern, 2):
            raise Failure(f"all {len(frames)} frames would be written to '{pattern}'; put #### into its name")
        if "\ufffd" in pattern:
            raise Failure(f"the name of the output is not UTF-8: '{pattern}'")


class Shot:
    """The scene of a job, with the values that the program resolved."""

    def __init__(self, options, scrim, frame, folder):
        self.scrim, self.frame = scrim, frame
        self.path, self.arguments = os.path.abspath(options.scene), arguments_of(options)
        if not self.path.endswith(".toml"):
            self._frame_asset(options, os.path.join(folder, "shot.toml"))
        self.scene = tomllib.loads(self._ask("render", "--print-scene"))
        given = self.scene.get("render", {})
        if "tolerance" in given and options.tiles != "1x1":
            raise Failure("a tolerance is searched for picture by picture, so tiles of it would not fit together; "
                            "choose --tiles 1x1 or a preset: --set 'render.quality=\"standard\"'")
        planned = self.plan(*self._outputs_of(options))
        self.window, self.outputs = planned["plan"]["window"], planned["outputs"]
        for value in resolved_sets(planned["plan"]["render"], given, options.simd):
            self.arguments += ["--set", value]

    def _ask(self, command, *more):
        """The answer of the program. Raises Failure with its words where it refuses."""
        answer = program.ask([self.scrim, command, self.path, *self.arguments, f"--frames={self.frame}", *more])
        for text in answer.warnings:
            print("scrim: warning:", text)
        return answer.output

    def _frame_asset(self, options, path):
        """An asset's scene is made here, so that all frames are framed alike. It must name its files from the root of
        the file system on, since it is elsewhere."""
        if not os.path.exists(self.path):  # a sequence
            self.path = os.path.join(pattern_of(os.getcwd()), options.scene)
        text = self._ask("render", *(["--up", options.up] if options.up else []), "--print-scene")
        with open(path, "w", encoding="utf-8") as out:
            out.write(text)
        self.path, self.arguments = path, []

    def _output_tables(self):
        """The table [output] of the picture, and those of the further files."""
        output = self.scene.get("output", {})
        first, *others = output if isinstance(output, list) else [output]
        return [first, *first.get("files", []), *others]

    def _outputs_of(self, options):
        """The options of the command line that name outputs."""
        given = ["--deep", options.deep] if options.deep else []
        if options.output:
            return [*given, "-o", options.output]
        has_own = "file" in self._output_tables()[0]
        return given if has_own else [*given, "-o", pattern_of(stem_of(options.scene)) + ".####.exr"]

    def lossy_compressions(self):
        """The lossy compressions of the picture and of each further file; "": it is lossless."""
        stated = [output.get("compression") for output in self._output_tables()]
        return ["dwaa" if (it or stated[0]) == "dwaa" else "" for it in stated]

    def plan(self, *more):
        planned = json.loads(self._ask("plan", "--json", *more))
        if not planned:
            raise Failure(f"frame {self.frame} has no files; begin with one that has", 3)
        return planned[0]

    def digest(self):
        with open(self.path, "rb") as text:
            return hashlib.sha256(text.read()).hexdigest()


def make_job(options):
    """The folder of a new job, whose tasks are not submitted yet."""
    scrim, tiles, frames, folder = check_options(options)
    for name in ("", "state", "log", "tiles", "submitted"):
        os.makedirs(os.path.join(folder, name), exist_ok=True)
    shot = Shot(options, scrim, frames[0], folder)
    crops = crops_of(shot.window, *tiles)
    check_outputs(shot.outputs, frames)
    output, deep, preview = (shot.outputs.get(key, {"pattern": ""})["pattern"] for key in ("file", "deep", "preview"))
    files = [shot.outputs[key]["pattern"] for key in shot.outputs if key not in ("file", "deep", "preview")]
    memory = parse_size(options.memory) if options.memory else memory_of(crops, shot.plan)
    compression, *of_files = shot.lossy_compressions()
    job = {
        "name": os.path.splitext(os.path.basename(folder))[0], "on": options.on,
        "scrim": scrim, "scene": shot.path, "digest": shot.digest(), "arguments": shot.arguments,
        "frames": frames, "chunk": options.chunk, "crops": crops, "output": output, "deep": deep, "preview": preview,
        "files": files, "merge_compression": compression, "file_compressions": of_files,
        "memory": memory, "most_memory": parse_size(options.most_memory) if options.most_memory else 16 * memory,
        "cpus": options.cpus, "retries": options.retries, "pause": options.pause, "keep_tiles": options.keep_tiles,
        "at_once": options.at_once, "sbatch": options.sbatch, "time": options.time,
    }
    write_json(os.path.join(folder, "job.json"), job)
    for path in Job(folder).output_folders():
        os.makedirs(path, exist_ok=True)
    return folder
