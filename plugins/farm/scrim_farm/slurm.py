# SPDX-License-Identifier: Apache-2.0
"""Slurm: arrays of tasks, tiles before merges before a check. The check submits anew what may still succeed, with more
memory where that was wanting, so nothing is asked of Slurm but sbatch: neither accounting nor rights to change jobs."""
import os
import re
import shlex
import subprocess
import sys

from scrim_kit import Failure
from scrim_kit.frames import range_text

from .job import ISOLATED, PROGRAM, Task, read_state, write_json
from .shot import PART_SMALLEST
from .status import next_tasks, print_status

SBATCH_SECONDS = 120


def clean_environment():
    """A job's own SLURM_ variables would count as options of the jobs that it submits."""
    return {k: v for k, v in os.environ.items() if k == "SLURM_CONF" or not k.startswith(("SLURM_", "SBATCH_"))}


def ask(command):
    """The standard output of a command of Slurm's; "" where the command fails or is missing."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=SBATCH_SECONDS, check=False,
                              env=clean_environment()).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""


class Submission:
    """The submission of a round: round 1 is the user's, those after it are the checks'."""

    def __init__(self, job, round_number, dry):
        self.job, self.round, self.dry = job, round_number, dry
        self.ids = []
        most = re.search(r"MaxArraySize\s*=\s*(\d+)", "" if dry else ask(["scontrol", "show", "config"]))
        self.most_tasks = max(1, int(most[1]) - 1) if most else 1000

    def _script(self, name, arguments):
        path = self.job.path("submitted", f"{name}.sh")
        with open(path, "w", encoding="utf-8") as out:
            words = shlex.join([sys.executable or "/usr/bin/python3", ISOLATED, PROGRAM, *arguments])
            # With exec, the task is the process that gets the job's signals.
            out.write(f'#!/bin/sh\nexec {words}{" $SLURM_ARRAY_TASK_ID" if "--task" in arguments else ""}\n')
        return path

    def _sbatch(self, name, arguments, options):
        folder = self.job.path("log").replace("%", "%%")  # Slurm takes % for patterns of its own
        log = os.path.join(folder, f"{name}-%A_%a.log" if "--task" in arguments else f"{name}-%j.log")
        command = ["sbatch", "--parsable", f"--job-name={self.job['name']}-{name}", f"--output={log}",
                   "--open-mode=append", "--requeue", "--nodes=1", "--ntasks=1", *options]
        if self.job["time"]:
            command.append(f"--time={self.job['time']}")
        command += [*shlex.split(self.job["sbatch"]), self._script(name, arguments)]
        if self.dry:
            print(shlex.join(command))
            self.ids.append(f"<{name}>")
            return self.ids[-1]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=SBATCH_SECONDS, check=False,
                                  env=clean_environment())
        except (OSError, subprocess.TimeoutExpired) as error:
            raise Failure(f"cannot submit to Slurm: {error}", 1) from None
        if done.returncode != 0:
            raise Failure(f"sbatch refused {name}: {done.stderr.strip()}", 1)
        identifier = done.stdout.strip().split(";")[0]
        with open(self.job.path("submitted", f"{name}.id"), "w", encoding="utf-8") as out:
            out.write(identifier)
        self.ids.append(identifier)
        self.job.log(f"round {self.round}: {name} is job {identifier}")
        return identifier

    def array(self, name, tasks, memory, options=()):
        """Submits an array, and returns its id. No more tasks than an array may have."""
        name = f"r{self.round}-{name}"
        write_json(self.job.path("submitted", f"{name}.json"),
                   {"memory": memory, "tasks": [task.as_json() for task in tasks]})
        limit = f"%{self.job['at_once']}" if self.job["at_once"] else ""
        return self._sbatch(name, ["--task", self.job.folder, name],
                            [f"--array=0-{len(tasks) - 1}{limit}", f"--mem={-(-memory // (1 << 20))}M",
                             f"--cpus-per-task={self.job['cpus']}", *options])

    def check(self, after):
        self._sbatch(f"r{self.round}-check", ["--follow", self.job.folder, str(self.round)],
                     [f"--mem={PART_SMALLEST >> 20}M", "--cpus-per-task=1", f"--dependency=afterany:{':'.join(after)}"])


def blocks(tasks, size):
    return [tasks[i : i + size] for i in range(0, len(tasks), size)]


def submit_first(job, dry):
    """All of the shot: an array for each tile, so that a merge waits for its own tiles alone."""
    sub = Submission(job, 1, dry)
    last = []
    for n, chunks in enumerate(blocks(job.chunks(), sub.most_tasks)):
        part = f"-part{n}" if n else ""
        tiles = []
        for tile in job.tiles():
            name = "render" + (f"-tile{tile}" if tile >= 0 else "") + part
            tiles.append(sub.array(name, [Task("render", c, tile) for c in chunks], job["memory"]))
        if job.tiled:
            # If a tile fails, Slurm cancels its merge; the check submits both anew.
            last.append(sub.array("merge" + part, [Task("merge", c) for c in chunks], PART_SMALLEST,
                                  [f"--dependency=aftercorr:{':'.join(tiles)}", "--kill-on-invalid-dep=yes"]))
        last += tiles
    sub.check(last)
    return sub.ids


def submit_again(job, again, merges, round_number, delay=0, dry=False):
    """Submits tasks anew, in an array for each amount of memory."""
    sub = Submission(job, round_number, dry)
    begin = [f"--begin=now+{delay}"] if delay else []
    ids = []
    for memory in sorted({memory for _, memory in again}):
        tasks = [task for task, wanted in again if wanted == memory]
        for n, some in enumerate(blocks(tasks, sub.most_tasks)):
            ids.append(sub.array(f"render-{memory >> 20}M" + (f"-part{n}" if n else ""), some, memory, begin))
    after = [f"--dependency=afterany:{':'.join(ids)}"] if ids else begin
    for n, some in enumerate(blocks(merges, sub.most_tasks)):
        ids.append(sub.array("merge" + (f"-part{n}" if n else ""), some, PART_SMALLEST, after))
    sub.check(ids)
    return sub.ids


def task_of(job, name, index):
    """The task of an array, and its memory."""
    array = read_state(job.path("submitted", f"{name}.json"))
    if array is None or not 0 <= index < len(array["tasks"]):
        raise Failure(f"there is no task {index} of {name}", 1)
    return Task.from_json(array["tasks"][index]), array["memory"]


def submitted(job):
    """Slurm's number of each array and check, by its name. Slurm is asked by these numbers: others may have jobs of the
    same names, whose blanks nothing tells from those between Slurm's words."""
    numbers = {}
    for file in sorted(os.listdir(job.path("submitted"))):
        name, extension = os.path.splitext(file)
        if extension == ".id":
            with open(job.path("submitted", file), encoding="utf-8") as text:
                numbers[name] = text.read().strip()
    return numbers


def fields_of(line, job_name):
    """What a line of scontrol says: JobId=7 JobState=FAILED. Of what is there twice the first is Slurm's own; the rest
    is in paths and commands, which come last."""
    return dict(reversed(re.findall(r"(\S+?)=(\S*)", line.replace(f"JobName={job_name} ", "", 1))))


def keep_faults(job, round_number):
    """Writes into faults.log what Slurm says of tasks that did not succeed, while Slurm still knows them. Returns the
    keys of the tasks that were cancelled."""
    cancelled, text = set(), ""
    for name, number in submitted(job).items():
        if not name.startswith(f"r{round_number}-") or name.endswith("-check"):
            continue
        for line in ask(["scontrol", "--oneliner", "show", "job", number]).splitlines():
            fields = fields_of(line, f"{job['name']}-{name}")
            if fields.get("JobState", "COMPLETED") == "COMPLETED":
                continue
            text += f"{name} {fields.get('ArrayTaskId', '')}: {line}\n"
            if fields["JobState"] != "CANCELLED" or fields.get("Reason") == "DependencyNeverSatisfied":
                continue
            for index in indices_of(fields.get("ArrayTaskId", "")):
                cancelled.add(task_of(job, name, index)[0].key)
    if text:
        with open(job.path("log", "faults.log"), "a", encoding="utf-8") as out:
            out.write(text)
    return cancelled


def indices_of(text):
    """"3", "2-5", "1,4-6%2": of an array."""
    indices = []
    for part in re.sub(r"%\d+$", "", text).split(","):
        match = re.fullmatch(r"(\d+)(?:-(\d+))?", part)
        if match:
            indices += range(int(match[1]), int(match[2] or match[1]) + 1)
    return indices


def follow(job, round_number):
    """The check after a round. Returns 0 where everything is there, or where tasks were submitted anew."""
    cancelled = keep_faults(job, round_number)

    def is_cancelled(task, last):
        return task.key in cancelled and (last is None or last["result"] == "running")

    again, merges, given_up = next_tasks(job, job.attempts(), is_cancelled)
    for task, text in given_up:
        job.log(f"given up: {task.kind} of frames {range_text(task.frames)}, tile {task.tile}: {text}")
    if again or merges:
        attempts = job.attempts()
        waits = any(a[-1]["result"] == "retry" for a in attempts.values())
        for task, memory in again:
            job.log(f"again: {task.key} with {memory >> 20} MB")
        submit_again(job, again, merges, round_number + 1, job["pause"] if waits else 0)
        return 0
    status = print_status(job)
    job.log("complete" if status == 0 else "not complete; see --status")
    return status


def resume(job, dry):
    """Submits everything that is missing, even tasks that were given up."""
    rounds = [int(m[1]) for n in os.listdir(job.path("submitted")) if (m := re.match(r"r(\d+)-", n))]
    running = ask(["squeue", "--noheader", "--format=%F"]).split()  # %F: the id of the whole array
    if set(running) & set(submitted(job).values()):
        raise Failure(f"jobs of {job['name']} are still in Slurm's queue; wait, or scancel them", 1)
    attempts = job.attempts()
    renders, merges = job.missing()
    if not renders and not merges:
        print("nothing is missing")
        return
    again = []
    for task in renders:
        tried = [a for frame in task.frames for a in attempts.get(("render", frame, task.tile), [])]
        again.append((task, max([a["memory"] for a in tried], default=job["memory"])))
    print("submitted:", " ".join(submit_again(job, again, merges, max(rounds, default=0) + 1, dry=dry)))
