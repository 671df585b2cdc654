# SPDX-License-Identifier: Apache-2.0
"""The folder of a job: what it renders, which tasks that takes, and how they went."""
import dataclasses
import json
import os
import time

from scrim_kit import Failure
from scrim_kit.frames import at_frame, pattern_of
from scrim_kit.program import Status

PROGRAM = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "scrim-submit")
# Options of Python on the farm: it imports nothing from the current folder or PYTHONPATH, where modules may have the
# names of its own. Only modules of Python itself are needed.
ISOLATED = "-I"

# Results by the exit status of scrim. `lost`: something outside killed it, often the kernel, which lacked memory.
RESULTS = {Status.DONE: "done", Status.RENDER: "fatal", Status.USAGE: "fatal", Status.INPUT: "fatal",
           Status.OUTPUT: "retry", Status.INACCURATE: "warned", Status.MEMORY: "memory", 130: "cancelled",
           143: "cancelled", 137: "lost"}
DONE = ("done", "warned")
AGAIN = ("retry", "memory", "lost", "crashed", "running")  # `running` after all has ended: the machine went down
SQUARE = 16  # pixels


def result_of(status):
    """What becomes of a task whose program ended with an exit status, 128 + N where signal N ended it."""
    return RESULTS.get(status, "crashed")


def write_json(path, value):
    """Writes a file. Readers see the whole content, or that of before."""
    beside = f"{path}.{os.getpid()}.part"
    with open(beside, "w", encoding="utf-8") as out:
        json.dump(value, out, indent=1)
        out.write("\n")
        out.flush()
        os.fsync(out.fileno())
    os.replace(beside, path)


def crops_of(picture, columns, rows):
    """Boxes that share `picture` about evenly, from left to right and top to bottom. Their edges lie where the squares
    that scrim renders at a time have theirs in the whole picture: then each pixel is that of the whole, bit by bit."""
    x0, y0, x1, y1 = picture

    def edges(begin, end, count):
        inner = [begin + round((end - begin) * i / count / SQUARE) * SQUARE for i in range(1, count)]
        return [begin, *inner, end]

    xs, ys = edges(x0, x1, columns), edges(y0, y1, rows)
    if any(a >= b for line in (xs, ys) for a, b in zip(line, line[1:])):
        raise Failure(f"--tiles {columns}x{rows}: a picture of {x1 - x0} x {y1 - y0} pixels has no tiles of at least "
                        f"{SQUARE} x {SQUARE}")
    return [[xs[i], ys[j], xs[i + 1], ys[j + 1]] for j in range(rows) for i in range(columns)]


@dataclasses.dataclass(frozen=True)
class Task:
    """Some frames of a tile (-1: of the picture, where there are no tiles), or the merge of some frames."""

    kind: str  # "render" or "merge"
    frames: tuple
    tile: int = -1

    @property
    def key(self):
        tile = "" if self.tile < 0 else f"-tile{self.tile}"
        return f"{self.kind}-{self.frames[0]}-{self.frames[-1]}{tile}"

    def as_json(self):
        return {"kind": self.kind, "frames": list(self.frames), "tile": self.tile}

    @staticmethod
    def from_json(value):
        return Task(value["kind"], tuple(value["frames"]), value["tile"])


class Job:
    def __init__(self, folder):
        self.folder = os.path.abspath(folder)
        path = os.path.join(self.folder, "job.json")
        try:
            with open(path, encoding="utf-8") as text:
                self.data = json.load(text)
        except (OSError, ValueError) as error:
            raise Failure(f"{folder} is not the folder of a job: {path}: {error}") from None

    def __getitem__(self, key):
        return self.data[key]

    def path(self, *names):
        return os.path.join(self.folder, *names)

    @property
    def tiled(self):
        return len(self["crops"]) > 1

    def chunks(self):
        frames, size = self["frames"], self["chunk"]
        return [tuple(frames[i : i + size]) for i in range(0, len(frames), size)]

    def tiles(self):
        return range(len(self["crops"])) if self.tiled else (-1,)

    @property
    def files(self):
        """The patterns of further files. Jobs of earlier versions have none."""
        return self.data.get("files", [])

    def outputs(self, frame):
        """The finished pictures of a frame: flat, deep, further files."""
        return [at_frame(p, frame) for p in (self["output"], self["deep"], *self.files) if p]

    def results(self, frame):
        """All finished files of a frame: `outputs`, and the preview, which is made last."""
        return self.outputs(frame) + ([at_frame(self["preview"], frame)] if self["preview"] else [])

    def is_finished(self, frame):
        return all(map(os.path.isfile, self.results(frame)))

    def output_folders(self):
        patterns = [p for p in (self["output"], self["deep"], self["preview"], *self.files) if p]
        return sorted({os.path.dirname(at_frame(p, frame)) for p in patterns for frame in self["frames"]})

    def parts(self, frame, tile):
        """The pictures that a render task makes of a frame: those of `outputs`, or tiles of them."""
        if tile < 0:
            return self.outputs(frame)
        deep = [self.tile_pattern(tile, "deep.######.exr")] if self["deep"] else []
        patterns = [self.tile_pattern(tile, "flat.######.exr"), *deep, *self.file_patterns(tile)]
        return [at_frame(pattern, frame) for pattern in patterns]

    def file_patterns(self, tile):
        """The patterns of the further files of a tile."""
        return [self.tile_pattern(tile, f"file{place}.######.exr") for place in range(2, len(self.files) + 2)]

    def lossy(self):
        """The lossy compressions that merges apply, by the place in `outputs`, with the keys of the scene that set
        them: what a tile loses by compression the whole would lose again."""
        found = {0: ("output.compression", self["merge_compression"])}
        for place, compression in enumerate(self.data.get("file_compressions", [])):
            found[len(self.outputs(0)) - len(self.files) + place] = (f"output.files[{place}].compression", compression)
        return {place: pair for place, pair in found.items() if pair[1]}

    def tile_pattern(self, tile, name):
        return os.path.join(pattern_of(self.path("tiles", str(tile))), name)

    def is_done(self, task, frame):
        """Whether a render task has nothing left to do of a frame. A tile has no preview: the merge makes that."""
        if task.tile < 0:
            return self.is_finished(frame)
        return any(all(map(os.path.isfile, files)) for files in (self.outputs(frame), self.parts(frame, task.tile)))

    def missing(self):
        """Render tasks with the frames that they still have to do, and merges."""
        renders, merges = [], []
        for chunk in self.chunks():
            for tile in self.tiles():
                task = Task("render", chunk, tile)
                left = tuple(f for f in chunk if not self.is_done(task, f))
                if left:
                    renders.append(Task("render", left, tile))
            left = tuple(f for f in chunk if not self.is_finished(f))
            if self.tiled and left:
                merges.append(Task("merge", left))
        return renders, merges

    def note(self, task, attempt):
        """Keeps how a task goes: the attempts of a task are a list, and the last of them may be changed."""
        path = self.path("state", task.key + ".json")
        state = read_state(path) or {**task.as_json(), "attempts": []}
        attempts = state["attempts"]
        if attempts and attempts[-1]["started"] == attempt["started"]:
            attempts.pop()
        attempts.append(attempt)
        write_json(path, state)

    def attempts(self):
        """All attempts, in their order, by (kind, frame, tile)."""
        found = {}
        folder = self.path("state")
        for name in sorted(os.listdir(folder)):
            state = read_state(os.path.join(folder, name)) if name.endswith(".json") else None
            for frame in state["frames"] if state else ():
                found.setdefault((state["kind"], frame, state["tile"]), []).extend(state["attempts"])
        for attempts in found.values():
            attempts.sort(key=lambda attempt: attempt["started"])
        return found

    def log(self, text):
        """Appends a line to the log of the job."""
        with open(self.path("log", "farm.log"), "a", encoding="utf-8") as out:
            out.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")


def read_state(path):
    try:
        with open(path, encoding="utf-8") as text:
            return json.load(text)
    except (OSError, ValueError):
        return None
