# SPDX-License-Identifier: Apache-2.0
"""Makes the folder of a job. What a render would choose by itself is chosen here, once for the shot, since tasks on
unlike machines and of unlike frames would not choose alike."""
import hashlib
import json
import os
import re
import shutil
import subprocess
import tomllib

from .job import FarmError, at_frame, crops_of, parse_frames, write_json

SIMD_FLAGS = {"sse4": ("sse4_1", "sse4_2"), "avx2": ("avx2", "fma", "bmi2", "f16c"),
              "avx512": ("avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512cd")}
GIB = 1 << 30
PART_SMALLEST = GIB // 2  # of merges and checks


def run_scrim(command):
    """Its standard output; what it refuses is refused here in its words."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"{command[0]} ended with status {done.returncode}"]
        raise FarmError(lines[-1].removeprefix("scrim: error: "), done.returncode if done.returncode > 0 else 1)
    for line in done.stderr.splitlines():
        if "warning" in line:
            print(line)
    return done.stdout


def parse_size(text):
    match = re.fullmatch(r"(\d+)([KMGT]?)", text)
    if not match or int(match[1]) == 0:
        raise FarmError(f"--memory {text}: expected a size such as 8G or 512M")
    return int(match[1]) << {"": 0, "K": 10, "M": 20, "G": 30, "T": 40}[match[2]]


def render_block(plan):
    """What the preset chose, of the text of `scrim plan`: lines 'key = value' behind [render]."""
    lines = plan.splitlines()
    if "[render]" not in lines:
        return {}
    chosen = {}
    for line in lines[lines.index("[render]") + 1 :]:
        match = re.fullmatch(r"(\w+) = (.+)", line)
        if not match:
            break
        chosen[match[1]] = match[2]
    return chosen


def resolved_sets(plan, scene, simd):
    """--set arguments that leave a task nothing to choose."""
    given = scene.get("render", {})
    sets = render_block(plan)
    if "cross_fade" not in given or given["cross_fade"] == "auto":
        still = re.search(r"^cross-fade .*nothing moves, or the dial is 0", plan, re.MULTILINE)
        sets["cross_fade"] = "0" if still else '"always"'
    if given.get("simd", "auto") == "auto" or simd:
        sets["simd"] = f'"{simd or "avx2"}"'
    return [f"render.{key}={value}" for key, value in sets.items()]


def picture_of(plan):
    """The pixels of the picture, with its overscan: x0, y0, x1, y1, of `scrim plan --json`, which has rays."""
    reasons = [effect["reason"] for effect in plan["effects"] if effect["name"] == "antialiasing"]
    rays = int(re.match(r"(\d+) x \1 rays a pixel", reasons[0])[1])
    return [edge // rays for edge in plan["region"]]


def memory_of(crops, plan_of):
    """For a task: what the plan of the tile in the middle needs, the grids thrice, since a child reads the next frame's
    meanwhile, and a reserve."""
    plan = plan_of("--crop=" + ",".join(map(str, crops[len(crops) // 2])))
    return int((plan["plan"]["bytes"] + 3 * plan["field_bytes"]) / 0.85) + GIB // 2


def output_of(scene, key, folder, default):
    """The pattern that the scene gives, from the root of the file system on."""
    pattern = scene.get("output", {}).get(key, default)
    if isinstance(pattern, dict):
        pattern = pattern.get("file", "")
    if not pattern:
        return ""
    if re.search(r"\$(?!F\d?)", pattern):
        raise FarmError(f"the scene's output.{key} is '{pattern}'; a farm may have other variables: give it as an "
                        "option")
    return os.path.normpath(os.path.join(folder, pattern))


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
        raise FarmError("expected --frames 1-240")
    scrim = shutil.which(options.scrim)
    if scrim is None:
        raise FarmError(f"there is no program '{options.scrim}'; --scrim PATH names it")
    if not os.path.isfile(options.scene) and options.scene.endswith(".toml"):
        raise FarmError(f"there is no scene {options.scene}", 3)
    tiles = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", options.tiles)
    if not tiles:
        raise FarmError(f"--tiles {options.tiles}: expected COLUMNSxROWS, such as 2x2")
    frames = parse_frames(options.frames)
    folder = os.path.abspath(options.folder or stem_of(options.scene) + ".farm")
    if os.path.exists(os.path.join(folder, "job.json")):
        raise FarmError(f"{folder} holds a job already; --resume {folder} goes on with it, --folder names another one")
    return os.path.abspath(scrim), (int(tiles[1]), int(tiles[2])), frames, folder


def stem_of(path):
    return os.path.splitext(os.path.basename(path))[0].replace("#", "").rstrip(".")


class Shot:
    """The scene of a job, with all that is resolved of it."""

    def __init__(self, options, scrim, frame, folder):
        self.scrim, self.frame = scrim, str(frame)
        self.path, self.arguments = os.path.abspath(options.scene), arguments_of(options)
        self.folder = os.path.dirname(self.path)  # that its pictures are relative to
        if not self.path.endswith(".toml"):
            self._frame_asset(options, os.path.join(folder, "shot.toml"))
        self.scene = tomllib.loads(self._ask("render", "--print-scene"))
        if "tolerance" in self.scene.get("render", {}) and options.tiles != "1x1":
            raise FarmError("a tolerance is searched for picture by picture, so tiles of it would not fit together; "
                            "choose --tiles 1x1 or a preset: --set 'render.quality=\"standard\"'")
        for value in resolved_sets(self._ask("plan"), self.scene, options.simd):
            self.arguments += ["--set", value]

    def _ask(self, command, *more):
        return run_scrim([self.scrim, command, self.path, *self.arguments, "--frames", self.frame, *more])

    def _frame_asset(self, options, path):
        """An asset's scene is made here, so that all frames are framed alike."""
        text = self._ask("render", *(["--up", options.up] if options.up else []), "--print-scene")
        with open(path, "w", encoding="utf-8") as out:
            out.write(text)
        self.path, self.arguments = path, []

    def plan(self, *more):
        planned = json.loads(self._ask("plan", "--json", *more))
        if not planned:
            raise FarmError(f"frame {self.frame} has no files; begin with one that has", 3)
        return planned[0]

    def digest(self):
        with open(self.path, "rb") as text:
            return hashlib.sha256(text.read()).hexdigest()

    def outputs(self, options, frames):
        """Patterns of the flat, the deep and the preview pictures; "" where there are none."""
        usual = os.path.join(os.getcwd(), stem_of(options.scene) + ".####.exr")
        output = os.path.abspath(options.output or output_of(self.scene, "file", self.folder, usual))
        deep = os.path.abspath(options.deep) if options.deep else output_of(self.scene, "deep", self.folder, "")
        preview = output_of(self.scene, "preview", self.folder, "")
        for pattern in filter(None, (output, deep, preview)):
            if len(frames) > 1 and at_frame(pattern, 1) == at_frame(pattern, 2):
                raise FarmError(f"all {len(frames)} frames would be written to '{pattern}'; put #### into its name")
        return output, deep, preview


def make_job(options):
    """The folder of a new job, whose tasks are not submitted yet."""
    scrim, tiles, frames, folder = check_options(options)
    for name in ("", "state", "log", "tiles", "submitted"):
        os.makedirs(os.path.join(folder, name), exist_ok=True)
    shot = Shot(options, scrim, frames[0], folder)
    crops = crops_of(picture_of(shot.plan()["plan"]), *tiles)
    output, deep, preview = shot.outputs(options, frames)
    memory = parse_size(options.memory) if options.memory else memory_of(crops, shot.plan)
    compression = shot.scene.get("output", {}).get("compression", "zip")
    job = {
        "name": os.path.splitext(os.path.basename(folder))[0], "on": options.on,
        "scrim": scrim, "scene": shot.path, "digest": shot.digest(), "arguments": shot.arguments,
        "frames": frames, "chunk": options.chunk, "crops": crops, "output": output, "deep": deep, "preview": preview,
        # What a tile loses by compression the whole would lose again.
        "merge_compression": compression if compression == "dwaa" else "",
        "memory": memory, "most_memory": parse_size(options.most_memory) if options.most_memory else 16 * memory,
        "cpus": options.cpus, "retries": options.retries, "pause": options.pause, "keep_tiles": options.keep_tiles,
        "at_once": options.at_once, "sbatch": options.sbatch, "time": options.time,
    }
    for pattern in filter(None, (output, deep)):
        os.makedirs(os.path.dirname(pattern), exist_ok=True)
    write_json(os.path.join(folder, "job.json"), job)
    return folder
