# SPDX-License-Identifier: Apache-2.0
"""Runs one task on a machine of the farm, and keeps how it went."""
import hashlib
import os
import platform
import resource
import shlex
import signal
import sys
import time

from scrim_kit import toml_text
from scrim_kit.frames import at_frame, range_text
from scrim_kit.program import Child, Status

from .job import DONE, result_of
from .shot import SIMD_FLAGS

PART_OF_MEMORY = 0.85  # for volumes and buffers; the rest is the program itself


def machine_problem(job):
    """Why pictures of this machine would differ from those of the others; "": they would not."""
    try:
        with open(job["scene"], "rb") as text:
            if hashlib.sha256(text.read()).hexdigest() != job["digest"]:
                return f"{job['scene']} is not what it was when the job was submitted; submit it anew"
    except OSError as error:
        return f"cannot read the scene: {error}"
    simd = [a.split('"')[1] for a in job["arguments"] if a.startswith('render.simd="')]
    if platform.machine() == "x86_64" and simd and simd[-1] in SIMD_FLAGS:
        with open("/proc/cpuinfo", encoding="utf-8") as text:
            flags = next((line.split() for line in text if line.startswith("flags")), [])
        lacking = [flag for flag in SIMD_FLAGS[simd[-1]] if flag not in flags]
        if lacking:
            return f"{platform.node()} has no {simd[-1]} ({', '.join(lacking)}); submit with --simd sse4"
    return ""


def render_command(job, task, memory, progress):
    command = [job["scrim"], "render", job["scene"], *job["arguments"], f"--frames={range_text(task.frames)}",
               "--skip-existing", "--memory", str(int(memory * PART_OF_MEMORY)), "--progress", progress]
    if task.tile < 0:
        command += ["-o", job["output"]]
        if job["deep"]:
            command += ["--deep", job["deep"]]
        return command
    os.makedirs(job.path("tiles", str(task.tile)), exist_ok=True)
    command += ["--crop=" + ",".join(map(str, job["crops"][task.tile])),
                "-o", job.tile_pattern(task.tile, "flat.######.exr")]
    if job["deep"]:
        command += ["--deep", job.tile_pattern(task.tile, "deep.######.exr")]
    for pattern in job.file_patterns(task.tile):
        command += ["--file", pattern]
    if job["preview"]:  # only the merged picture gets a preview
        command += ["--preview", job.tile_pattern(task.tile, "preview.######.png")]
    for key, _ in job.lossy().values():
        command += ["--set", toml_text.assignment(key, "zip")]
    return command


def merge_commands(job, frame):
    """The commands that merge the tiles of a frame, and make its preview."""
    commands, lossy = [], job.lossy()
    for place, whole in enumerate(job.outputs(frame)):
        if os.path.isfile(whole):
            continue
        command = [job["scrim"], "merge", "-q", "-o", whole, *(job.parts(frame, tile)[place] for tile in job.tiles())]
        if place in lossy:
            command += ["--compression", lossy[place][1]]
        commands.append(command)
    if job["preview"]:
        commands.append([job["scrim"], "render", job["scene"], *job["arguments"], f"--frames={frame}", "-q",
                         "--skip-existing", "-o", job["output"], *(["--deep", job["deep"]] if job["deep"] else []),
                         "--preview", job["preview"]])
    return commands


def seconds_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def was_out_of_time(status, seconds):
    """Whether a program was killed since it took as much processor time as this process gives (ulimit -t)."""
    most = resource.getrlimit(resource.RLIMIT_CPU)[0]
    return -status in (signal.SIGKILL, signal.SIGXCPU) and most != resource.RLIM_INFINITY and seconds + 0.1 >= most


class Runner:
    """Runs one program after the other. A signal to stop is passed on to the program that runs."""

    def __init__(self):
        self.child = None
        self.stopped = 0
        self.last = ""
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._stop)

    def _stop(self, number, _frame):
        self.stopped = number
        if self.child is not None:
            self.child.signal(number)

    def _told(self, line):
        print(line, file=sys.stderr, flush=True)
        self.last = line.strip() or self.last

    def run(self, command):
        """Runs a program. Returns its exit status, 128 + N where signal N ended it. Keeps its last line on standard
        error in `last`."""
        if self.stopped:
            return 128 + self.stopped
        print("+", shlex.join(command), flush=True)
        before = seconds_of_children()
        self.child = Child(command, reads_output=False)
        if self.stopped:  # the signal came before the program was started
            self.child.signal(self.stopped)
        ended = self.child.wait(told=self._told)
        if was_out_of_time(ended.returncode, seconds_of_children() - before):
            self.last = "it exceeded the limit on CPU time; raise it (ulimit -t)"
            return Status.RENDER  # neither memory nor another attempt would help
        if ended.returncode < 0:
            self.last = f"killed by {signal.Signals(-ended.returncode).name}"
        return ended.status


def remove_tiles(job, frame):
    for tile in job.tiles():
        for path in job.parts(frame, tile) + [at_frame(job.tile_pattern(tile, "preview.######.png"), frame)]:
            if os.path.isfile(path):
                os.unlink(path)


def do_merge(job, task, runner):
    for frame in task.frames:
        for command in merge_commands(job, frame):
            status = runner.run(command)
            if status != 0:
                return status
        if not job["keep_tiles"] and all(map(os.path.isfile, job.outputs(frame))):
            remove_tiles(job, frame)
    return 0


def run_task(job, task, memory=0, progress="none"):
    """Returns the exit status for the farm: 0 where the pictures are there, with a warning or without."""
    memory = memory or job["memory"]
    array = os.environ.get("SLURM_ARRAY_JOB_ID")
    name = f"{array}_{os.environ.get('SLURM_ARRAY_TASK_ID')}" if array else os.environ.get("SLURM_JOB_ID", "")
    attempt = {"started": time.time(), "result": "running", "memory": memory, "host": platform.node(), "job": name,
               "pid": os.getpid(), "restarts": int(os.environ.get("SLURM_RESTART_COUNT", "0"))}
    runner = Runner()
    job.note(task, attempt)
    problem = machine_problem(job)
    if problem:
        status, runner.last = Status.INPUT, problem
        print("scrim-submit:", problem, file=sys.stderr)
    elif task.kind == "merge":
        status = do_merge(job, task, runner)
    else:
        status = runner.run(render_command(job, task, memory, progress))
    if runner.stopped and not runner.last:  # scrim writes no last line when it is told twice to stop
        runner.last = f"stopped by {signal.Signals(runner.stopped).name}"
    attempt |= {"ended": time.time(), "status": status, "result": result_of(status), "last": runner.last}
    job.note(task, attempt)
    job.log(f"{task.key} {name} on {attempt['host']}: status {status}, {attempt['result']}: {runner.last}")
    if progress == "openjd":
        tell_openjd(attempt)
    return 0 if attempt["result"] in DONE else status


def tell_openjd(attempt):
    if attempt["result"] == "warned":
        print("openjd_status: done, with a warning:", attempt["last"], flush=True)
    elif attempt["result"] not in DONE:
        print(f"openjd_fail: {attempt['result']} (status {attempt['status']}): {attempt['last']}", flush=True)
