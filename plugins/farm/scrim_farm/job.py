# SPDX-License-Identifier: Apache-2.0
"""The folder of a job: what it renders, which tasks that takes, and how they went."""
import dataclasses
import json
import os
import re
import time


class FarmError(Exception):
    """Told in one line; `status` is the exit status."""

    def __init__(self, message, status=2):
        super().__init__(message)
        self.status = status


# What an exit status of scrim means here. `lost`: killed from outside, often by the kernel for want
# of memory.
RESULTS = {0: "done", 1: "fatal", 2: "fatal", 3: "fatal", 4: "retry", 5: "warned", 33: "memory", 130: "cancelled",
           143: "cancelled", 137: "lost"}
DONE = ("done", "warned")
AGAIN = ("retry", "memory", "lost", "crashed", "running")  # `running` where nothing runs any more: a machine went down
SQUARE = 16  # pixels


def result_of(status):
    if status < 0:  # by a signal, as subprocess tells it
        status = 128 - status
    return RESULTS.get(status, "crashed")


def write_json(path, value):
    """Whole or not at all."""
    beside = f"{path}.{os.getpid()}.part"
    with open(beside, "w", encoding="utf-8") as out:
        json.dump(value, out, indent=1)
        out.write("\n")
        out.flush()
        os.fsync(out.fileno())
    os.replace(beside, path)


def parse_frames(text):
    """"1-48x2,60": as scrim's --frames has it."""
    frames = []
    for part in text.split(","):
        match = re.fullmatch(r"(-?\d+)(?:-(-?\d+)(?:x(\d+))?)?", part.strip(" "), re.ASCII)
        if not match or (match[3] and int(match[3]) == 0) or (match[2] and int(match[2]) < int(match[1])):
            raise FarmError(f"--frames {text}: expected a range such as 1-48x2,60")
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        frames += range(first, last + 1, step)
    return sorted(set(frames))


def frames_text(frames):
    """The shortest text for sorted frames: "1-12,20"."""
    parts, i = [], 0
    while i < len(frames):
        j = i
        while j + 1 < len(frames) and frames[j + 1] == frames[j] + 1:
            j += 1
        parts.append(str(frames[i]) if i == j else f"{frames[i]}-{frames[j]}")
        i = j + 1
    return ",".join(parts)


# Of a pattern, as scrim has it (scene/frame_path.h): a plain character, or what stands for the frame.
PLACE = re.compile(r"\$([$#%])|(#+)|\$F(\d*)|%(0\d+)?d", re.ASCII)
MOST_DIGITS = 20


def at_frame(pattern, frame):
    """The path of a frame: ####, %04d and $F4 stand for it, $$, $# and $% for the second of these characters."""

    def piece(match):
        plain, hashes, houdini, printf = match.groups()
        if plain:
            return plain
        digits = len(hashes) if hashes else int(houdini or printf or 1)
        digits = 1 if not hashes and digits > 0x7FFFFFFF else min(max(digits, 1), MOST_DIGITS)
        return format(frame, f"0{digits}d")

    return PLACE.sub(piece, pattern)


def pattern_of(path):
    """The pattern that names `path`, whatever is in it."""
    return re.sub(r"[$#%]", r"$\g<0>", path)


def without_frame(pattern):
    return PLACE.sub(lambda match: match[1] or "", pattern)


def crops_of(picture, columns, rows):
    """Boxes that share `picture` about evenly, from left to right and top to bottom. Their edges lie where the squares
    that scrim renders at a time have theirs in the whole picture: then each pixel is that of the whole, bit by bit."""
    x0, y0, x1, y1 = picture

    def edges(begin, end, count):
        inner = [begin + round((end - begin) * i / count / SQUARE) * SQUARE for i in range(1, count)]
        return [begin, *inner, end]

    xs, ys = edges(x0, x1, columns), edges(y0, y1, rows)
    if any(a >= b for line in (xs, ys) for a, b in zip(line, line[1:])):
        raise FarmError(f"--tiles {columns}x{rows}: a picture of {x1 - x0} x {y1 - y0} pixels has no tiles of at least "
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
            raise FarmError(f"{folder} is no folder of a job: {path}: {error}") from None

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

    def outputs(self, frame):
        """The pictures of a frame that the shot ends with."""
        return [at_frame(p, frame) for p in (self["output"], self["deep"]) if p]

    def output_folders(self):
        patterns = [p for p in (self["output"], self["deep"], self["preview"]) if p]
        return sorted({os.path.dirname(at_frame(p, frame)) for p in patterns for frame in self["frames"]})

    def parts(self, frame, tile):
        """The pictures that a render task makes of a frame: those of `outputs`, or tiles of them."""
        if tile < 0:
            return self.outputs(frame)
        names = ["flat.######.exr"] + (["deep.######.exr"] if self["deep"] else [])
        return [at_frame(self.tile_pattern(tile, name), frame) for name in names]

    def tile_pattern(self, tile, name):
        return os.path.join(pattern_of(self.path("tiles", str(tile))), name)

    def is_done(self, task, frame):
        if all(map(os.path.isfile, self.outputs(frame))):
            return True
        return task.kind == "render" and all(map(os.path.isfile, self.parts(frame, task.tile)))

    def missing(self):
        """Render tasks with the frames that they still have to do, and merges."""
        renders, merges = [], []
        for chunk in self.chunks():
            for tile in self.tiles():
                task = Task("render", chunk, tile)
                left = tuple(f for f in chunk if not self.is_done(task, f))
                if left:
                    renders.append(Task("render", left, tile))
            left = tuple(f for f in chunk if not all(map(os.path.isfile, self.outputs(f))))
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
        """For each kind, frame and tile all attempts there were, in their order."""
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
        """A line of the job's own log."""
        with open(self.path("log", "farm.log"), "a", encoding="utf-8") as out:
            out.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")


def read_state(path):
    try:
        with open(path, encoding="utf-8") as text:
            return json.load(text)
    except (OSError, ValueError):
        return None
