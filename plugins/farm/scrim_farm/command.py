# SPDX-License-Identifier: Apache-2.0
"""The command line of scrim-submit."""
import argparse
import os
import re
import sys

from scrim_kit import Failure
from scrim_kit.frames import parse_range

from . import openjd, slurm
from .job import Job, Task
from .man_page import man_page
from .shot import make_job
from .status import print_status
from .task import run_task

EPILOG = """examples:
  scrim-submit plume.toml --frames 1-240 --tiles 2x2 --on slurm
  scrim-submit plume.toml --frames 1-240 --on openjd
  scrim-submit --status plume.farm
  scrim-submit --resume plume.farm"""


def positive(text):
    if not re.fullmatch(r"[1-9]\d{0,5}", text):
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number from 1 on")
    return int(text)


def count(text):
    return 0 if text == "0" else positive(text)


def parser():
    out = argparse.ArgumentParser(prog="scrim-submit", epilog=EPILOG, allow_abbrev=False,
                                  formatter_class=argparse.RawDescriptionHelpFormatter,
                                  description="Submits a shot to a render farm, and reports what is missing.")
    out.add_argument("scene", nargs="?", metavar="SCENE", help="a scene (.toml), or an asset alone")
    out.add_argument("--frames", metavar="RANGE", help="frames: 1-48x2,60")
    out.add_argument("--tiles", default="1x1", metavar="CxR", help="columns and rows that each picture is cut into")
    out.add_argument("--on", choices=("slurm", "openjd"), help="the farm")
    out.add_argument("--dry-run", action="store_true", help="only show what would be submitted")
    out.add_argument("--folder", help="folder of the job, which all machines share (default: SCENE.farm, here)")
    out.add_argument("-o", "--output", metavar="FILE.exr", help="pictures to write, in place of the scene's")
    out.add_argument("--deep", metavar="FILE.exr", help="deep pictures to write, in place of the scene's")
    out.add_argument("--chunk", type=positive, default=1, metavar="N", help="frames of a task")
    out.add_argument("--memory", metavar="SIZE", help="memory of a task: 8G (default: what the first frame needs)")
    out.add_argument("--most-memory", metavar="SIZE",
                     help="largest memory of a task that ran out of it (default: 16 times --memory)")
    out.add_argument("--cpus", type=positive, default=4, metavar="N", help="processors of a task (default: 4)")
    out.add_argument("--retries", type=count, default=3, metavar="N", help="retries of a task that failed (default: 3)")
    out.add_argument("--pause", type=count, default=60, metavar="SECONDS",
                     help="pause before a failed write is tried again")
    out.add_argument("--at-once", type=count, default=0, metavar="N", help="tasks of an array that may run at once")
    out.add_argument("--time", default="", metavar="LIMIT", help="time limit of a task, in the form of Slurm: 2:00:00")
    out.add_argument("--sbatch", default="", metavar="OPTIONS", help="more options for sbatch: '--partition=render'")
    out.add_argument("--keep-tiles", action="store_true", help="do not remove tiles that were merged")
    out.add_argument("--simd", choices=("sse4", "avx2", "avx512"),
                     help="instruction set of all machines (default: avx2)")
    out.add_argument("--scrim", default="scrim", metavar="PATH", help="the program")
    for name, text in (("quality", "preset"), ("res", "WxH"), ("ocio", "config"), ("missing", "error, black or skip"),
                       ("up", "up axis of an asset")):
        out.add_argument(f"--{name}", metavar="X", help=f"as in scrim render: {text}")
    out.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as in scrim render")
    out.add_argument("--status", metavar="FOLDER", help="report what is missing of a job, and why")
    out.add_argument("--resume", metavar="FOLDER", help="submit what is missing of a job on Slurm")
    out.add_argument("--man", action="store_true", help=argparse.SUPPRESS)
    # What the farm calls.
    out.add_argument("--task", nargs=3, metavar=("FOLDER", "ARRAY", "INDEX"), help=argparse.SUPPRESS)
    out.add_argument("--openjd-task", nargs="+", metavar="FOLDER KIND [TILE]", help=argparse.SUPPRESS)
    out.add_argument("--follow", nargs=2, metavar=("FOLDER", "ROUND"), help=argparse.SUPPRESS)
    return out


def openjd_task(words, frames):
    folder, kind = words[:2]
    job = Job(folder)
    tile = int(words[2]) if len(words) > 2 else -1
    # Chunks may be written as 1,2,3 or 1-3:2.
    chunk = sorted(parse_range(frames.replace(":", "x"), "--frames"))
    return run_task(job, Task(kind, tuple(chunk), tile), progress="openjd")


def submit(options):
    if options.on is None:
        raise Failure("expected --on slurm or --on openjd")
    folder = make_job(options)
    job = Job(folder)
    print(f"{folder}: {len(job['frames'])} frames, {len(job['crops'])} tiles each, "
          f"{job['memory'] >> 20} MB and {job['cpus']} processors a task")
    print("for every task:", " ".join(a for a in job["arguments"] if a.startswith("render.")))
    if options.on == "openjd":
        for path in openjd.write_bundle(job, sys.executable or "/usr/bin/python3"):
            print(path)
        return 0
    ids = slurm.submit_first(job, options.dry_run)
    if options.dry_run:
        os.unlink(job.path("job.json"))  # so that the same command without --dry-run works
    else:
        print("submitted:", " ".join(ids))
    return 0


def run(options):
    if options.man:
        print(man_page(parser()), end="")
        return 0
    if options.task:
        folder, array, index = options.task
        job = Job(folder)
        task, memory = slurm.task_of(job, array, int(index))
        return run_task(job, task, memory)
    if options.openjd_task:
        return openjd_task(options.openjd_task, options.frames)
    if options.follow:
        return slurm.follow(Job(options.follow[0]), int(options.follow[1]))
    if options.status:
        return print_status(Job(options.status))
    if options.resume:
        slurm.resume(Job(options.resume), options.dry_run)
        return 0
    if not options.scene:
        raise Failure("expected a scene, or --status or --resume and the folder of a job")
    return submit(options)


def main(arguments):
    try:
        return run(parser().parse_args(arguments))
    except Failure as error:
        print(f"scrim-submit: error: {error}", file=sys.stderr)
        return error.status
