# SPDX-License-Identifier: Apache-2.0
"""The files of a job that are there, those that are missing, and why."""
import os

from scrim_kit import program
from scrim_kit.frames import range_text

from .job import AGAIN, DONE


def broken_files(job):
    """Pictures that are there, but not whole: a copy was interrupted, or a disk failed."""
    there = [path for frame in job["frames"] for path in job.outputs(frame) if os.path.isfile(path)]
    broken = []
    for i in range(0, len(there), 500):
        broken += program.run([job["scrim"], "merge", "--check", *there[i : i + 500]]).output.splitlines()
    return broken


def reason_of(attempts, task, frame):
    """How the last attempt at a frame of a task ended: (result, text)."""
    tried = attempts.get((task.kind, frame, task.tile), [])
    if not tried:
        return "waiting", "not begun"
    last = tried[-1]
    if last["result"] in DONE:
        return "lost", "its file is gone"
    text = last.get("last") or f"since {last['host']} took it"
    return last["result"], f"{last['result']}, attempt {len(tried)}: {text}"


def warnings_of(job, attempts):
    """Frames that ended with exit status 5, by the text of their warning."""
    said = {}
    for (kind, frame, _tile), tried in attempts.items():
        if kind == "render" and tried[-1]["result"] == "warned" and frame in job["frames"]:
            said.setdefault(tried[-1]["last"], set()).add(frame)
    return {text: sorted(frames) for text, frames in said.items()}


def print_status(job):
    """0 where all frames are complete."""
    broken = broken_files(job)
    attempts = job.attempts()
    there = [f for f in job["frames"] if job.is_finished(f) and not set(broken) & set(job.outputs(f))]
    print(f"{job['name']}: {len(there)} of {len(job['frames'])} frames are complete")
    reasons = {}
    renders, merges = job.missing()
    for task in renders + merges:
        for frame in task.frames:
            result, text = reason_of(attempts, task, frame)
            if task.kind == "merge" and result == "waiting":
                continue  # the reasons of its tiles are printed
            what = "merge" if task.kind == "merge" else "picture" if task.tile < 0 else f"tile {task.tile}"
            reasons.setdefault((what, text), []).append(frame)
    for (what, text), frames in sorted(reasons.items()):
        print(f"  missing: frames {range_text(frames)}, {what}: {text}")
    for path in broken:
        print(f"  incomplete: {path}; remove it, and --resume")
    for text, frames in sorted(warnings_of(job, attempts).items()):
        print(f"  warning: frames {range_text(frames)}: {text}")
    if len(there) < len(job["frames"]):
        if job["on"] == "slurm":
            print(f"scrim-submit --resume {job.folder} submits what is missing")
        else:
            print(f"{job.path('template.json')}, run again, does what is missing")
        return 1
    return 0


def next_tasks(job, attempts, is_cancelled=lambda task, last: False):
    """([(task to submit anew, its memory)], [merge to submit anew], [(task that is given up, why)])."""
    again, given_up, stuck = [], [], set()
    renders, merges = job.missing()
    for task in renders:
        tried = [attempts.get(("render", frame, task.tile), []) for frame in task.frames]
        last = max((t[-1] for t in tried if t), key=lambda attempt: attempt["started"], default=None)
        result = last["result"] if last else "lost"
        if is_cancelled(task, last):
            result = "cancelled"
        memory = last["memory"] if last else job["memory"]
        if result in ("memory",) or (result == "lost" and last and last["result"] == "lost"):
            if result == "memory" and memory >= job["most_memory"]:
                result = "fatal"
            memory = min(2 * memory, job["most_memory"])
        failures = max(sum(a["result"] in AGAIN and a["result"] != "memory" for a in t) for t in tried)
        if (result in AGAIN or result in DONE) and failures <= job["retries"]:
            again.append((task, memory))
        else:
            given_up.append((task, last["result"] + ": " + last.get("last", "") if last else "cancelled"))
            stuck |= set(task.frames)
    ready = []
    for task in merges:
        if stuck & set(task.frames):
            continue
        tried = [a for frame in task.frames for a in attempts.get(("merge", frame, -1), [])]
        failed = [a for a in tried if a["result"] not in DONE and a["result"] != "cancelled"]
        if len(failed) // len(task.frames) > job["retries"]:
            given_up.append((task, failed[-1]["last"]))
        else:
            ready.append(task)
    return again, ready, given_up
