# SPDX-License-Identifier: Apache-2.0
"""The program as a child: what it tells, how it ends, and that it is gone where it was stopped."""

import os
import signal
import subprocess
import sys
import time

import pytest
import scrim_kit
from conftest import PROGRAM
from scrim_kit import Failure, program
from scrim_kit.program import Background, Cancelled, Child, Ended, Status


def is_gone(pid, seconds=20):
    """Whether a process ends in time. One that nobody has waited for yet has ended, too."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
                if file.read().rpartition(")")[2].split()[0] == "Z":
                    return True
        except FileNotFoundError:
            return True
        time.sleep(0.05)
    return False


def pid_in(path, seconds=20):
    """What a program wrote there of itself, once it has."""
    deadline = time.monotonic() + seconds
    while not (path.exists() and path.read_text().strip()):
        assert time.monotonic() < deadline, "the program did not begin"
        time.sleep(0.02)
    return int(path.read_text())


def slow(shot):
    """Arguments of a render that takes minutes."""
    dials = ("volume.smoke.parameters.resolution=160", "render.texel=0.05", "render.sheet_thickness=0.05")
    words = [word for dial in (*dials, "camera.resolution=[960, 720]") for word in ("--set", dial)]
    return ["render", shot, *words]


# By the program itself


def test_exit_statuses_are_those_of_the_program(shot, tmp_path):
    out = ["-o", str(tmp_path / "out.exr")]
    (tmp_path / "file").write_text("")
    for status, words in [
        (Status.DONE, ["render", shot, *out]),
        (Status.USAGE, ["fly"]),
        (Status.INPUT, ["render", str(tmp_path / "absent.toml"), *out]),
        (Status.OUTPUT, ["render", shot, "-o", str(tmp_path / "file" / "out.exr")]),
        (Status.INACCURATE, ["render", shot, *out, "--tolerance", "0.0000001"]),
        (Status.MEMORY, ["render", shot, *out, "--memory", "1K"]),
    ]:
        ended = program.run([PROGRAM, *words])
        assert (ended.returncode, ended.status) == (status, status), ended.told
        if status != Status.DONE:
            assert ended.told[-1] == f"scrim: error: {ended.reason}"


def test_a_line_of_error_has_its_reason():
    assert Ended(Status.INPUT, ["scrim: warning: w", program.error_line("a.toml:1:1: bad")]).reason == "a.toml:1:1: bad"


def test_progress_and_warnings_are_the_programs(shot, tmp_path):
    parts = []
    words = ["render", shot, "-o", str(tmp_path / "out.####.exr"), "--frames", "1-2", "--progress", "json"]
    ended = program.run([PROGRAM, *words, "--display-server", "127.0.0.1:1"], parts.append)  # where nobody listens
    assert ended.returncode == 0, ended.told
    assert parts == sorted(parts) and parts[0] < 0.5 and parts[-1] == 1 and len(parts) > 4
    [text] = ended.warnings
    assert text.endswith("pictures are rendered but not shown") and f"scrim: warning: {text}" in ended.told


def test_answers_are_the_programs(shot):
    assert program.ask([PROGRAM, "plan", shot, "--json"]).output.startswith("[")
    with pytest.raises(Failure, match="^--set camera.fov: 'fov' is 200; expected a number") as failure:
        program.ask([PROGRAM, "plan", shot, "--set", "camera.fov=200"])
    assert failure.value.status == Status.INPUT


def test_a_render_that_is_cancelled_is_gone_and_leaves_no_file(shot, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    parts = []
    with pytest.raises(Cancelled):
        words = [*slow(shot), "-o", str(out / "a.exr"), "--progress", "json"]
        program.run([PROGRAM, *words], parts.append, cancelled=lambda: parts)
    assert parts[0] < 1 and os.listdir(out) == []
    assert not running(str(out / "a.exr"))


def running(word):
    """Processes that have it on their command line."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as file:
                if word.encode() in file.read().split(b"\0"):
                    found.append(int(pid))
        except OSError:
            pass
    return found


@pytest.mark.parametrize("number, status", [(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGKILL, 137)])
def test_a_signal_reaches_the_program(shot, tmp_path, number, status):
    child = Child([PROGRAM, *slow(shot), "-o", str(tmp_path / "a.exr"), "--progress", "json"])
    ended = child.wait(progress=lambda part: child.signal(number))
    assert ended.status == status, ended
    assert not running(str(tmp_path / "a.exr"))


# By programs that stand for it


@pytest.fixture
def script(tmp_path):
    """Makes such a program of lines of a shell."""

    def make(text):
        path = tmp_path / "program"
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        return str(path)

    return make


def test_a_child_tells_what_it_does(script):
    lines = """echo '{"progress":50.0}'; echo other; echo '{}'; echo 'scrim: warning: w' >&2; printf end; exit 5"""
    name = script(lines)
    parts = []
    ended = program.run([name], parts.append)
    assert ended == Ended(Status.INACCURATE, ["scrim: warning: w"], '{"progress":50.0}\nother\n{}\nend\n')
    assert parts == [0.5] and ended.warnings == ["w"]


def test_lines_are_told_as_they_come(script, tmp_path):
    until = f"for i in $(seq 300); do [ -e {tmp_path}/told ] && break; sleep 0.02; done"
    name = script(f"echo one >&2; {until}; [ -e {tmp_path}/told ] && echo two >&2; echo hidden")
    lines = []

    def told(line):
        lines.append(line)
        (tmp_path / "told").write_text("")

    assert Child([name]).wait(told=told).told == lines == ["one", "two"]


def test_output_that_is_not_read_is_the_parents(script):
    name = script("echo out; echo err >&2")
    code = f"from scrim_kit.program import Child; print(Child([{name!r}], reads_output=False).wait())"
    done = subprocess.run([sys.executable, "-B", "-c", code], env=with_kit(), capture_output=True, text=True)
    assert done.stdout.splitlines() == ["out", "Ended(returncode=0, told=['err'], output='')"] and not done.stderr


def with_kit():
    return {**os.environ, "PYTHONPATH": os.path.dirname(scrim_kit.__path__[0])}


def test_a_child_is_cancelled(script, tmp_path):
    name = script(f"echo $$ > {tmp_path}/pid; exec sleep 60")
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        program.run([name], cancelled=lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").stat().st_size > 0)
    assert time.monotonic() - begun < 10
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_a_child_that_does_not_heed_is_killed(script, tmp_path):
    name = script(f"trap '' TERM; echo $$ > {tmp_path}/pid; for i in $(seq 120); do sleep 0.1; done")
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        program.run([name], cancelled=lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").stat().st_size > 0)
    assert time.monotonic() - begun < 10
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_a_child_is_gone_where_a_callback_raises(script, tmp_path):
    name = script(f"""echo $$ > {tmp_path}/pid; echo '{{"progress":1}}'; exec sleep 60""")
    with pytest.raises(ZeroDivisionError):
        program.run([name], lambda part: 1 / 0)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_a_child_that_closes_its_pipes_is_waited_for(script):
    assert program.run([script("exec >&- 2>&-; sleep 0.3; exit 4")]).returncode == 4


def test_an_answer_that_takes_too_long_is_a_failure(script, tmp_path):
    name = script(f"echo $$ > {tmp_path}/pid; exec sleep 60")
    with pytest.raises(Failure, match=r"^scrim took longer than 0.2 seconds$"):
        program.ask([name], seconds=0.2)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_what_cannot_be_started_is_a_failure(tmp_path):
    with pytest.raises(Failure, match=r"^cannot start '/nowhere/scrim': No such file or directory$"):
        program.run(["/nowhere/scrim"])
    (tmp_path / "scrim").write_text("")
    with pytest.raises(Failure, match=r"scrim': Permission denied$"):
        Background([str(tmp_path / "scrim")], str(tmp_path / "told"))


def test_a_child_in_the_background_may_say_much(script, tmp_path):
    """More than pipes hold: 200 KiB of warnings, and as much on standard output."""
    line = "scrim: warning: " + "w" * 1000
    many = f"for i in $(seq 200); do echo '{line}' >&2; echo '{line}'; done; echo 'scrim: error: why' >&2; exit 3"
    background = Background([script(many)], str(tmp_path / "told"))
    deadline = time.monotonic() + 10
    while not background.has_ended():
        if time.monotonic() > deadline:
            background.stop()
            pytest.fail("it was stopped by what it says")
        time.sleep(0.01)
    ended = background.result()
    assert (ended.returncode, len(ended.told), ended.reason) == (3, 201, "why")


def test_a_child_in_the_background_is_stopped(script, tmp_path):
    background = Background([script("echo begun >&2; exec sleep 60")], str(tmp_path / "told"))
    assert not background.has_ended()
    background.stop()
    assert background.has_ended() and background.result().returncode < 0


def test_a_child_ends_with_its_parent(script, tmp_path):
    """The parent ends as SIGTERM ends Blender: without a word."""
    name = script(f"echo $$ > {tmp_path}/pid; exec sleep 60")
    code = f"from scrim_kit import program; program.run([{name!r}])"
    parent = subprocess.Popen([sys.executable, "-B", "-c", code], env=with_kit())
    pid = pid_in(tmp_path / "pid")
    parent.kill()
    parent.wait()
    if not is_gone(pid):
        os.kill(pid, signal.SIGKILL)
        pytest.fail("the child lives on")


def test_why_a_child_failed():
    assert Ended(3, ["x", "scrim: error: 'fov' is 200", ""]).reason == "'fov' is 200"
    assert Ended(-11, []).reason == "scrim was ended by signal 11"
    assert Ended(-11, ["said"]).reason == "scrim was ended by signal 11: said"
    assert Ended(1, []).reason == "scrim ended with exit status 1"
    assert [Ended(code, []).status for code in (0, 3, -9, -15)] == [0, 3, 137, 143]
