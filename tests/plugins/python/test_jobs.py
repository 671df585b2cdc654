# SPDX-License-Identifier: Apache-2.0
"""Long work: progress, threads, cancelling, Ctrl-C."""

import gc
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy
import pytest

import scrim

# Verifying every pixel takes far longer than any of these tests waits.
LONG = {"camera.resolution": [800, 600], "volume.smoke.parameters.resolution": 96}


def test_progress_is_heard_in_the_thread_that_waits(smoke):
    heard = []
    frame = scrim.open(smoke, LONG).render(
        progress=lambda part: heard.append((part, threading.get_ident())), verify=400
    )
    assert frame.error > 0 and len(heard) >= 2
    assert {thread for _, thread in heard} == {threading.get_ident()}
    assert all(0 <= part <= 1 for part, _ in heard)


def test_what_progress_raises_cancels_and_is_raised_again(smoke):
    def stop(part):
        raise LookupError(f"enough at {part}")

    shot = scrim.open(smoke, LONG)
    started = time.monotonic()
    with pytest.raises(LookupError, match="enough at"):
        shot.render(verify="all", progress=stop)
    assert time.monotonic() - started < 20
    assert shot.render(crop=(0, 0, 8, 8)).image.shape == (8, 8, 4)  # it is free again


def test_a_job_is_polled_and_gives_its_frame(smoke):
    job = scrim.open(smoke).start(7)
    while not job.wait(0.05):
        assert 0 <= job.progress <= 1
    assert job.done
    frame = job.result()
    assert frame.number == 7 and job.result() is frame
    assert numpy.array_equal(frame.image, scrim.open(smoke).render(7).image)


def test_a_cancelled_job_raises_cancelled(smoke):
    shot = scrim.open(smoke, LONG)
    job = shot.start(verify="all")
    assert not job.wait(0.2) and not job.done
    started = time.monotonic()
    job.cancel()
    assert job.wait(20) and time.monotonic() - started < 15
    with pytest.raises(scrim.Cancelled, match="interrupted|cancelled"):
        job.result()


def test_a_job_that_is_forgotten_ends(smoke):
    shot = scrim.open(smoke, LONG)
    job = shot.start(verify="all")
    del job
    gc.collect()
    assert shot.render(crop=(0, 0, 8, 8)).image.shape == (8, 8, 4)


def test_a_shot_does_one_thing_at_a_time(smoke):
    shot = scrim.open(smoke, LONG)
    job = shot.start(3, verify="all")
    with pytest.raises(
        scrim.UsageError, match="the shot is at work on frame 3; wait for it, or open the shot once more"
    ):
        shot.render(4)
    job.cancel()
    job.wait()
    assert shot.start(4, crop=(0, 0, 8, 8)).result().number == 4


def test_what_fails_in_a_job_is_raised_by_its_result(smoke):
    job = scrim.open(smoke).start(memory=1000)
    assert job.wait()
    with pytest.raises(scrim.OutOfMemoryError):
        job.result()


def test_two_renders_in_two_threads_are_what_they_are_alone(smoke):
    overrides = [{"light.key.intensity": 3}, {"light.key.direction": [0, -1, 0]}]
    alone = [scrim.open(smoke, o).render().image for o in overrides]
    found = [None, None]

    def render(i):
        for _ in range(3):
            found[i] = scrim.open(smoke, overrides[i]).render().image

    threads = [threading.Thread(target=render, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not numpy.array_equal(alone[0], alone[1])
    for i in range(2):
        assert numpy.array_equal(found[i], alone[i])


def test_other_threads_of_python_go_on_during_a_render(smoke):
    shot = scrim.open(smoke, LONG)
    thread = threading.Thread(target=lambda: shot.render(verify=300))
    thread.start()
    turns = 0
    while thread.is_alive():
        time.sleep(0.002)
        turns += 1
    assert turns > 10


def child(smoke, python_path, text):
    """Runs `text` in a process of its own, in which `shot` is the long scene."""
    start = f"import os, signal, sys, time, scrim\nshot = scrim.open({str(smoke)!r}, {LONG!r})\n"
    return subprocess.Popen(
        [sys.executable, "-c", start + textwrap.dedent(text)],
        env=python_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def test_control_c_cancels_and_python_hears_of_it_afterwards_as_before(smoke, python_path):
    run = child(
        smoke,
        python_path,
        """\
        before = signal.getsignal(signal.SIGINT)
        try:
            shot.render(verify="all", progress=lambda part: print("on", flush=True))
        except KeyboardInterrupt:
            print("stopped", flush=True)
        assert signal.getsignal(signal.SIGINT) is before
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(10)
        except KeyboardInterrupt:
            print("again", flush=True)
        print(shot.render(crop=(0, 0, 8, 8)).image.shape, flush=True)
        """,
    )
    assert run.stdout.readline() == "on\n"
    started = time.monotonic()
    run.send_signal(signal.SIGINT)
    rest, errors = run.communicate(timeout=60)
    assert time.monotonic() - started < 20
    assert [line for line in rest.splitlines() if line != "on"] == ["stopped", "again", "(8, 8, 4)"], errors
    assert run.returncode == 0


def test_a_handler_of_the_programs_own_is_called_during_a_render(smoke, python_path):
    run = child(
        smoke,
        python_path,
        """\
        class Mine(Exception):
            pass
        def handle(number, frame):
            raise Mine
        signal.signal(signal.SIGTERM, handle)
        try:
            job = shot.start(verify="all")
            job.result(progress=lambda part: print("on", flush=True))
        except Mine:
            print("mine", job.done, flush=True)
        """,
    )
    assert run.stdout.readline() == "on\n"
    run.send_signal(signal.SIGTERM)
    rest, errors = run.communicate(timeout=60)
    assert [line for line in rest.splitlines() if line != "on"] == ["mine True"] and run.returncode == 0, errors


def test_python_ends_while_a_job_runs(smoke, python_path):
    run = child(
        smoke,
        python_path,
        """\
        job = shot.start(verify="all")
        time.sleep(0.3)
        keep = [job]
        keep.append(keep)  # nobody frees it
        """,
    )
    _, errors = run.communicate(timeout=60)
    assert run.returncode == 0, errors
    assert "leaked" not in errors, errors


def test_messages_go_to_logging(tmp_path, caplog):
    scene = {
        "camera": {"position": [0, 0, 5], "target": [0, 0, 0], "resolution": [8, 8]},
        "volume": [{"name": "smoke", "file": "smoke.####.vdb"}],
        "light": [{"name": "key", "type": "distant", "direction": [0, 0, -1]}],
    }
    with caplog.at_level("INFO", logger="scrim"):
        scrim.loads(scene, folder=tmp_path).render(2, missing="black")
    assert [(r.levelname, r.name) for r in caplog.records] == [("WARNING", "scrim")]
    assert caplog.records[0].getMessage().startswith("frame 2: black instead: scene:")
