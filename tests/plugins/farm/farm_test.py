# SPDX-License-Identifier: Apache-2.0
"""scrim-submit without a farm: what it resolves, what an exit status makes of a task, what is submitted anew."""
import contextlib
import io
import json
import os
import resource
import stat
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

HERE = os.path.dirname(os.path.realpath(__file__))
FARM = os.path.join(HERE, "..", "..", "..", "plugins", "farm")
KIT = os.path.join(HERE, "..", "..", "..", "plugins", "kit")
sys.path[:0] = [FARM, KIT, HERE]
from job_tasks import SCENE, SCRIM, run_tasks, submit  # noqa: E402
from scrim_farm import slurm  # noqa: E402
from scrim_farm.job import Job, Task, crops_of, result_of  # noqa: E402
from scrim_farm.shot import resolved_sets  # noqa: E402
from scrim_farm.status import next_tasks  # noqa: E402
from scrim_farm.task import merge_commands  # noqa: E402
from scrim_kit import Failure  # noqa: E402

# Stands for scrim: ends with the next status of the file `statuses`, and writes its pictures where that is 0 or 5.
FAKE = """#!/usr/bin/python3
import re, sys
if sys.argv[1] == "merge" and "--check" in sys.argv: sys.exit(0)
path = {folder!r} + "/statuses"
statuses = open(path).read().split()
status = int(statuses.pop(0)) if statuses else 0
open(path, "w").write(" ".join(statuses))
print("scrim: error: reason", status, file=sys.stderr)
while status == 99: pass
if status in (0, 5):
    files = [file for word, file in zip(sys.argv, sys.argv[1:]) if word in ("-o", "--file")]
    frames = next((word[9:] for word in sys.argv if word.startswith("--frames=")), "1")
    for frame in frames.split(","):
        for file in files: open(re.sub("#+", lambda m: frame.zfill(len(m[0])), file), "w").write("picture")
sys.exit(status)
"""


def write(path, text=""):
    with open(path, "w", encoding="utf-8") as out:
        out.write(text)


def planned(folder, *arguments):
    """What `scrim plan` says of SCENE there."""
    with open(os.path.join(folder, "shot.toml"), "w", encoding="utf-8") as out:
        out.write(SCENE)
    done = subprocess.run([SCRIM, "plan", "shot.toml", "--json", *arguments], capture_output=True, text=True,
                          check=False, timeout=60, cwd=folder)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return json.loads(done.stdout)


def alive(pid):
    """Whether a process runs; one that nobody has waited for yet does not."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as text:
            return text.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


class Texts(unittest.TestCase):
    def test_crops_share_the_picture(self):
        crops = crops_of([-2, -1, 65, 40], 3, 2)
        self.assertEqual(sum((c[2] - c[0]) * (c[3] - c[1]) for c in crops), 67 * 41)
        self.assertEqual([crops[0][:2], crops[-1][2:]], [[-2, -1], [65, 40]])
        self.assertTrue(all((edge - corner) % 16 == 0 for c in crops[:1] for edge, corner in ((c[2], -2), (c[3], -1))))
        with self.assertRaisesRegex(Failure, "--tiles 3x2: a picture of 20 x 40 pixels has no tiles of at least 16"):
            crops_of([0, 0, 20, 40], 3, 2)

    def test_what_tasks_would_choose_is_resolved(self):
        render = {"texel": 0.4, "cross_fade": 0, "splat": "shared", "simd": "auto"}
        self.assertEqual(resolved_sets(render, {}, ""), ["render.texel=0.4", "render.cross_fade=0",
                                                         'render.splat="shared"', 'render.simd="avx2"'])
        self.assertEqual(resolved_sets(render, {"tolerance": 0.01}, "sse4"),
                         ["render.cross_fade=0", 'render.simd="sse4"'])
        self.assertIn('render.simd="avx512"', resolved_sets(render | {"simd": "avx512"}, {}, ""))

    def test_the_plan_says_what_a_render_chooses(self):
        with tempfile.TemporaryDirectory() as folder:
            [still] = planned(folder, "--set", "render.antialias=3", "--crop=3,2,20,22", "--quality", "draft")
            [moves] = planned(folder, "--set", "camera.position={keys=[[1, [0, 0, 3]], [2, [0, 1, 3]]]}")
            [again] = planned(folder, *(word for key, value in moves["plan"]["render"].items()
                                        for word in ("--set", f"render.{key}={json.dumps(value)}")))
        self.assertEqual(still["plan"]["window"], [3, 2, 20, 22])
        self.assertEqual(still["plan"]["render"]["antialias"], 3)
        self.assertEqual([plan["plan"]["render"]["cross_fade"] for plan in (still, moves)], [0, "always"])
        self.assertEqual(again["plan"]["render"], moves["plan"]["render"])

    def test_an_exit_status_says_what_becomes_of_a_task(self):
        wanted = {0: "done", 1: "fatal", 2: "fatal", 3: "fatal", 4: "retry", 5: "warned", 33: "memory",
                  130: "cancelled", 143: "cancelled", 137: "lost", 139: "crashed"}
        self.assertEqual({status: result_of(status) for status in wanted}, wanted)


class Folder(unittest.TestCase):
    """A job of four frames whose program is a fake."""

    def setUp(self):
        self.temp = tempfile.TemporaryDirectory()
        self.addCleanup(self.temp.cleanup)
        self.folder = self.temp.name
        for name in ("state", "log", "tiles", "submitted", "out"):
            os.mkdir(os.path.join(self.folder, name))
        fake = os.path.join(self.folder, "scrim")
        with open(fake, "w", encoding="utf-8") as out:
            out.write(FAKE.format(folder=self.folder))
        os.chmod(fake, stat.S_IRWXU)
        scene = os.path.join(self.folder, "shot.toml")
        with open(scene, "w", encoding="utf-8") as out:
            out.write("")
        self.data = {
            "name": "shot", "on": "slurm", "scrim": fake, "scene": scene,
            "frames": [1, 2, 3, 4], "chunk": 1, "arguments": [],
            "digest": "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", "crops": [[0, 0, 9, 9]],
            "output": os.path.join(self.folder, "out", "a.####.exr"), "deep": "", "preview": "",
            "merge_compression": "", "memory": 1 << 30, "most_memory": 4 << 30, "cpus": 1, "retries": 2, "pause": 0,
            "keep_tiles": False, "at_once": 0, "sbatch": "", "time": ""}

    def job(self, **more):
        with open(os.path.join(self.folder, "job.json"), "w", encoding="utf-8") as out:
            json.dump(self.data | more, out)
        return Job(self.folder)

    def code(self, frame, tile, kind, memory):
        return (f"import sys; sys.path[:0] = [{FARM!r}, {KIT!r}]\n"
                "from scrim_farm.job import *\nfrom scrim_farm.task import *\n"
                f"sys.exit(run_task(Job({self.folder!r}), Task({kind!r}, ({frame},), {tile}), {memory}))")

    def run_frame(self, frame, *statuses, memory=1 << 30, tile=-1, kind="render", before=lambda: None):
        """Runs a task in a process of its own, as farms do, once for each status."""
        with open(os.path.join(self.folder, "statuses"), "w", encoding="utf-8") as out:
            out.write(" ".join(map(str, statuses)))
        command = [sys.executable, "-B", "-c", self.code(frame, tile, kind, memory)]
        return [subprocess.run(command, capture_output=True, check=False, timeout=60, preexec_fn=before).returncode
                for _ in statuses]

    def start_frame(self, folder):
        """Starts a task whose program does not end by itself. Gives both processes once the program is there."""
        with open(os.path.join(folder, "statuses"), "w", encoding="utf-8") as out:
            out.write("99")
        task = subprocess.Popen([sys.executable, "-B", "-c", self.code(1, -1, "render", 1 << 30)],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for undo in (task.wait, task.kill, task.stderr.close):  # the last is called first
            self.addCleanup(undo)
        self.assertIn("reason 99", task.stderr.readline())
        with open(f"/proc/{task.pid}/task/{task.pid}/children", encoding="utf-8") as text:
            return task, int(text.read())

    def next(self, job):
        again, merges, given_up = next_tasks(job, job.attempts())
        return ({t.frames[0]: m >> 30 for t, m in again}, [t.frames[0] for t in merges],
                {t.frames[0]: text for t, text in given_up})

    def status(self):
        done = subprocess.run([os.path.join(FARM, "scrim-submit"), "--status", self.folder], capture_output=True,
                              text=True, check=False, timeout=60)
        return done.returncode, done.stdout

    def test_statuses_are_done_warned_retried_or_fatal(self):
        job = self.job()
        self.assertEqual([self.run_frame(1, 0), self.run_frame(2, 5), self.run_frame(3, 4), self.run_frame(4, 3)],
                         [[0], [0], [4], [3]])
        self.assertEqual(self.next(job), ({3: 1}, [], {4: "fatal: scrim: error: reason 3"}))
        code, text = self.status()
        self.assertEqual(code, 1)
        self.assertIn("2 of 4 frames are complete", text)
        self.assertIn("missing: frames 3, picture: retry, attempt 1: scrim: error: reason 4", text)
        self.assertIn("missing: frames 4, picture: fatal, attempt 1: scrim: error: reason 3", text)
        self.assertIn("warning: frames 2: scrim: error: reason 5", text)

    def test_memory_grows_to_its_limit(self):
        job = self.job()
        self.run_frame(1, 33)
        self.assertEqual(self.next(job)[0][1], 2)
        self.run_frame(1, 33, memory=2 << 30)
        self.assertEqual(self.next(job)[0][1], 4)
        self.run_frame(1, 33, memory=4 << 30)
        again, _, given_up = self.next(job)
        self.assertNotIn(1, again)
        self.assertEqual(given_up[1], "memory: scrim: error: reason 33")

    def test_a_limit_of_time_is_no_want_of_memory(self):
        job = self.job()
        for frame, limits in ((1, (1, 1)), (2, (1, 9))):
            def limit(most=limits):
                resource.setrlimit(resource.RLIMIT_CPU, most)

            self.assertEqual(self.run_frame(frame, 99, before=limit), [1])
            self.assertEqual(self.next(job)[2][frame], "fatal: it exceeded the limit on CPU time; raise it "
                                                       "(ulimit -t)")

    def test_a_signal_to_a_task_reaches_its_program(self):
        job = self.job()
        task, program = self.start_frame(self.folder)
        task.terminate()
        self.assertEqual(task.wait(20), 143)
        with self.assertRaises(ProcessLookupError):
            os.kill(program, 0)
        self.assertEqual(self.next(job)[2][1], "cancelled: killed by SIGTERM")

    def test_a_task_that_is_killed_takes_its_program_along(self):
        self.job()
        task, program = self.start_frame(self.folder)
        task.kill()
        self.assertEqual(task.wait(20), -9)
        for _ in range(200):
            if not alive(program):
                return
            time.sleep(0.05)
        os.kill(program, 9)
        self.fail("the program goes on, and would write what another task does anew")

    def test_retries_end(self):
        job = self.job()
        self.run_frame(1, 4, 4)
        self.assertIn(1, self.next(job)[0])
        self.run_frame(1, 4)
        self.assertEqual(self.next(job)[2][1], "retry: scrim: error: reason 4")

    def test_a_frame_is_done_with_all_of_its_files(self):
        job = self.job(files=[os.path.join(self.folder, "z.####.exr")])
        picture, depth = job.outputs(3)
        self.assertEqual(depth, os.path.join(self.folder, "z.0003.exr"))
        self.assertFalse(job.is_done(Task("render", (3,), -1), 3))
        for path in (picture, depth):
            self.assertFalse(job.is_done(Task("render", (3,), -1), 3))
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8"):
                pass
        self.assertTrue(job.is_done(Task("render", (3,), -1), 3))

    def test_a_frame_without_its_preview_is_not_done(self):
        out = os.path.join(self.folder, "out")
        for crops, kinds in (([[0, 0, 9, 9]], ([1], [])), ([[0, 0, 4, 9], [4, 0, 9, 9]], ([], [1]))):
            job = self.job(frames=[1], crops=crops, preview=os.path.join(out, "a.####.png"))
            write(os.path.join(out, "a.0001.exr"))  # a task that was killed before its preview
            self.assertEqual(tuple([t.frames[0] for t in tasks] for tasks in job.missing()), kinds)
            self.assertIn("0 of 1 frames are complete", self.status()[1])
            write(os.path.join(out, "a.0001.png"))
            self.assertEqual(job.missing(), ([], []))
            self.assertIn("1 of 1 frames are complete", self.status()[1])
            os.unlink(os.path.join(out, "a.0001.png"))

    def test_cancelled_tasks_are_left_alone_and_killed_ones_are_not(self):
        job = self.job()
        self.run_frame(1, 143)
        self.run_frame(2, 137)
        again, _, given_up = self.next(job)
        self.assertEqual(list(given_up), [1])
        self.assertEqual(again[2], 2)
        self.assertEqual((again[3], again[4]), (1, 1))  # never begun

    def test_a_merge_waits_for_tiles_that_can_come(self):
        job = self.job(crops=[[0, 0, 4, 9], [4, 0, 9, 9]])
        for frame in (1, 2):
            self.run_frame(frame, 0, tile=0)
        self.run_frame(1, 0, tile=1)
        self.run_frame(2, 2, tile=1)
        again, merges, given_up = self.next(job)
        self.assertEqual((sorted(again), merges, list(given_up)), ([3, 4], [1, 3, 4], [2]))
        self.assertEqual(self.run_frame(1, 0, kind="merge"), [0])
        self.assertFalse(any(os.path.isfile(path) for tile in (0, 1) for path in job.parts(1, tile)))

    def test_a_merge_makes_each_file_of_its_own_tiles(self):
        files = [os.path.join(self.folder, "out", f"{name}.####.exr") for name in "yz"]
        job = self.job(frames=[1], crops=[[0, 0, 4, 9], [4, 0, 9, 9]], files=files, file_compressions=["", "dwaa"])
        for tile in (0, 1):
            self.run_frame(1, 0, tile=tile)
        parts = [job.parts(1, tile) for tile in (0, 1)]
        self.assertEqual([len(set(of)) for of in parts], [3, 3])
        os.unlink(parts[1][2])  # a tile without one of its files is not done
        self.assertEqual(self.next(job)[:2], ({1: 1}, [1]))
        self.run_frame(1, 0, tile=1)
        self.assertEqual(self.next(job)[:2], ({}, [1]))
        commands = merge_commands(job, 1)
        self.assertEqual([(c[c.index("-o") + 1], c[c.index("-o") + 2 :]) for c in commands],
                         [(whole, [of[place] for of in parts] + (["--compression", "dwaa"] if place == 2 else []))
                          for place, whole in enumerate(job.outputs(1))])
        # The third file fails once: what is there by then is left alone, and tiles stay until all is there.
        self.assertEqual(self.run_frame(1, 0, 0, 4, kind="merge"), [4, 0, 0])
        self.assertEqual(self.next(job)[1], [])
        self.assertFalse(any(map(os.path.isfile, parts[0] + parts[1])))

    def test_a_scene_that_changed_is_fatal(self):
        self.job(digest="0")
        self.assertEqual(self.run_frame(1, 0), [3])
        self.assertIn("shot.toml is not what it was when the job was submitted; submit it anew", self.status()[1])

    def test_a_machine_without_the_instructions_is_told(self):
        self.job(arguments=["--set", 'render.simd="avx512"'])
        with open("/proc/cpuinfo", encoding="utf-8") as text:
            has = "avx512f" in text.read()
        self.assertEqual(self.run_frame(1, 0), [0 if has else 3])
        if not has:
            self.assertIn("submit with --simd sse4", self.status()[1])

    def test_arrays_are_no_larger_than_slurm_allows(self):
        job = self.job(frames=list(range(1, 1502)), crops=[[0, 0, 4, 9], [4, 0, 9, 9]])
        with contextlib.redirect_stdout(io.StringIO()):
            ids = slurm.submit_first(job, True)
        self.assertEqual(ids, [
            "<r1-render-tile0>", "<r1-render-tile1>", "<r1-merge>", "<r1-render-tile0-part1>",
            "<r1-render-tile1-part1>", "<r1-merge-part1>", "<r1-check>"])
        self.assertEqual(slurm.task_of(job, "r1-merge-part1", 0)[0], Task("merge", (1001,)))
        self.assertEqual(slurm.indices_of("1,4-6%2"), [1, 4, 5, 6])


class FakeSlurm(unittest.TestCase):
    """A job that was submitted to a Slurm that gives it number 71. Its other commands print what they are told."""

    job = Folder.job

    def setUp(self):
        Folder.setUp(self)
        self.data["name"] = "my shot"
        commands = os.path.join(self.folder, "commands")
        os.mkdir(commands)
        for name, text in (("sbatch", "echo 71"), ("squeue", f"cat {self.folder}/queue"),
                           ("scontrol", f'cat "{self.folder}/$*" 2>/dev/null')):
            path = os.path.join(commands, name)
            write(path, f"#!/bin/sh\n{text}\n")
            os.chmod(path, stat.S_IRWXU)
        self.enterContext(unittest.mock.patch.dict(os.environ, {"PATH": f"{commands}:{os.environ['PATH']}"}))

    def tell(self, name, text):
        write(os.path.join(self.folder, name), text)

    def submitted(self):
        job = self.job()
        slurm.submit_first(job, False)
        return job

    def test_a_job_in_the_queue_is_not_submitted_once_more_whatever_its_name(self):
        job = self.submitted()
        self.tell("queue", "8\n71\n")
        with self.assertRaisesRegex(Failure, "jobs of my shot are still in Slurm's queue"):
            slurm.resume(job, False)

    def test_the_jobs_of_others_are_not_its_own(self):
        self.data["name"] = "plume"
        job = self.submitted()
        self.tell("queue", "8\nplume-red\nplume-r1-render\n")
        with contextlib.redirect_stdout(io.StringIO()) as said:
            slurm.resume(job, False)
        self.assertIn("submitted: 71", said.getvalue())

    def test_tasks_that_somebody_cancelled_under_the_same_name_are_not_cancelled(self):
        job = self.submitted()
        line = "JobId={0} ArrayJobId={0} ArrayTaskId={1} JobName=my shot-r1-render JobState={2} Reason=None " \
               "Command=/a b/JobState=RUNNING\n"
        ours = line.format(71, 2, "CANCELLED") + line.format(71, 3, "COMPLETED")
        self.tell("--oneliner show job 71", ours)
        self.tell("--oneliner show jobs", ours + line.format(8, 0, "CANCELLED"))
        self.assertEqual(slurm.keep_faults(job, 1), {"render-3-3"})
        with open(job.path("log", "faults.log"), encoding="utf-8") as text:
            self.assertEqual([line.split(":")[0] for line in text], ["r1-render 2"])


class HostileFolder(unittest.TestCase):
    """What runs in a folder of somebody else runs none of its code."""

    NAMES = ("json", "numpy", "sitecustomize", "usercustomize", "re", "os", "scrim_farm", "scrim_kit", "linecache")

    def test_no_module_of_the_current_folder_or_of_an_empty_entry_of_the_path_is_run(self):
        with tempfile.TemporaryDirectory() as folder:
            write(os.path.join(folder, "shot.toml"), SCENE)
            submit(folder, "shot.toml", "--frames", "1", "--folder", "of.farm")
            for name in self.NAMES:
                write(os.path.join(folder, f"{name}.py"), f"open({folder + '/owned'!r}, 'a').write(__name__)")
            python = ["/usr/bin/python3", slurm.ISOLATED, slurm.PROGRAM]
            with open(os.path.join(folder, "of.farm", "template.json"), encoding="utf-8") as text:
                of_openjd = json.load(text)["steps"][-1]["script"]["actions"]["onRun"]
            self.assertEqual(of_openjd["args"][:2], [slurm.ISOLATED, "{{Param.Submit}}"])
            job = Job(os.path.join(folder, "of.farm"))
            with contextlib.redirect_stdout(io.StringIO()):
                slurm.submit_first(job, True)
            for command in (python + ["--status", job.folder], [slurm.PROGRAM, "--status", job.folder],
                            ["env", "SLURM_ARRAY_TASK_ID=0", "sh", job.path("submitted", "r1-render.sh")]):
                for path in ("", ":", f"{folder}:"):
                    subprocess.run(command, cwd=folder, env={**os.environ, "PYTHONPATH": path}, check=False, timeout=60,
                                   capture_output=True)
                    self.assertFalse(os.path.exists(os.path.join(folder, "owned")), (command, path))
            self.assertTrue(os.path.exists(os.path.join(folder, "shot.0001.exr")))  # the task did its work


class Command(unittest.TestCase):
    def refuses(self, arguments, status, text):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "a.toml"), "w", encoding="utf-8") as out:
                out.write('[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\nresolution = [32, 24]\n[[volume]]\n'
                          'source = "noise"\nparameters = { resolution = 16 }\n')
            with open(os.path.join(folder, "bad.toml"), "w", encoding="utf-8") as out:
                out.write("[camera]\ntype = 3\n")
            done = subprocess.run([os.path.join(FARM, "scrim-submit"), *arguments], capture_output=True, text=True,
                                  cwd=folder, check=False, timeout=120)
        self.assertIn(text, done.stderr)
        self.assertEqual(done.returncode, status, done.stderr)

    def test_refuses_what_cannot_be_submitted(self):
        on = ["--on", "slurm", "--scrim", SCRIM, "--dry-run"]
        self.refuses([], 2, "expected a scene, or --status or --resume and the folder of a job")
        self.refuses(["a.toml", "--frames", "1-3"], 2, "expected --on slurm or --on openjd")
        self.refuses(["a.toml", *on], 2, "expected --frames 1-240")
        self.refuses(["a.toml", "--frames", "1:3", *on], 2, "--frames 1:3: expected a range such as 1-48x2,60")
        self.refuses(["a.toml", "--frames", "1", "--tiles", "2", *on], 2,
                     "--tiles 2: expected COLUMNSxROWS, such as 2x2")
        self.refuses(["b.toml", "--frames", "1", *on], 3, "there is no scene b.toml")
        self.refuses(["a.toml", "--frames", "1", "--on", "slurm", "--scrim", "scram"], 2, "there is no program 'scram'")
        self.refuses(["--status", "."], 2, ". is not the folder of a job: ")
        self.refuses(["bad.toml", "--frames", "1", *on], 3, "bad.toml:2:8: 'type' is 3; expected '")
        self.refuses(["a.toml", "--frames", "1-2", "-o", "a.exr", *on], 2, "put #### into its name")
        self.refuses(["a.toml", "--frames", "1", "--tiles", "40x1", *on], 2,
                     "--tiles 40x1: a picture of 32 x 24 pixels has no tiles of")
        self.refuses(["a.toml", "--frames", "1", "--tiles", "2x1", "--set", "render.tolerance=0.01", *on], 2,
                     "a tolerance is searched for picture by picture")
        self.refuses(["a.toml", "--frames", "1-2", "--tiles", "2x1", "--set",
                      'output.files=[{file="z.exr",layers=["depth"]}]', *on], 2, "would be written to '")
        self.refuses(["a.toml", "--frames", "1", "--memory", "8 GB", *on], 2,
                     "--memory 8 GB: expected a size such as 8G or 512M")
        self.refuses(["a.toml", "--frames", "1", "--set", 'output.file="${SHOT}.exr"', *on], 3, "SHOT")


class Submitted(unittest.TestCase):
    """Jobs whose tasks are run one after the other, as Open Job Description would."""

    def test_folders_and_frames_may_have_any_name(self):
        with tempfile.TemporaryDirectory() as folder:
            place = os.path.join(folder, "a##b %04d do$lar")
            os.mkdir(place)
            with open(os.path.join(place, "shot.toml"), "w", encoding="utf-8") as out:
                out.write(SCENE + '[output]\nfile = "out$$%02d/p.$F4.exr"\ndeep = "deep.####.exr"\n'
                                  'preview = "${NAME}.%03d.png"\n[variables]\nNAME = "small"\n')
            submit(place, "shot.toml", "--frames=-2--1", "--tiles", "2x1", "--chunk", "2", "--quality", "draft")
            said = run_tasks(os.path.join(place, "shot.farm"), "-2--1")
            self.assertIn("2 of 2 frames are complete", said)
            self.assertEqual(os.listdir(folder), ["a##b %04d do$lar"])
            self.assertEqual(sorted(os.listdir(place)), [
                "deep.-001.exr", "deep.-002.exr", "out$-1", "out$-2", "shot.farm", "shot.toml", "small.-01.png",
                "small.-02.png"])
            self.assertEqual(os.listdir(os.path.join(place, "out$-2")), ["p.-002.exr"])

    def test_a_sequence_of_files_is_found_from_the_folder_of_the_job(self):
        with tempfile.TemporaryDirectory() as folder:
            place = os.path.join(folder, "do$lar##")
            os.mkdir(place)
            for frame in (1, 2):
                subprocess.run([SCRIM, "make", "noise", "resolution=16", "-q", "-o", f"s#.{frame}.vdb"], check=True,
                               cwd=place, timeout=60)
            submit(place, "s#.1.vdb", "--frames", "1", "--res", "32x24")
            self.assertIn("1 of 1 frames are complete", run_tasks(os.path.join(place, "s#.1.farm"), "1"))
            submit(place, "s$#.#.vdb", "--frames", "1-2", "--chunk", "2", "--res", "32x24")
            self.assertIn("2 of 2 frames are complete", run_tasks(os.path.join(place, "s#.farm"), "1-2"))
            self.assertEqual(os.listdir(folder), ["do$lar##"])
            self.assertEqual(sorted(os.listdir(place)), [
                "s#.0001.exr", "s#.0002.exr", "s#.1.0001.exr", "s#.1.farm", "s#.1.vdb", "s#.2.vdb", "s#.farm"])


if __name__ == "__main__":
    unittest.main()
