# SPDX-License-Identifier: Apache-2.0
# The program scrim as a child process: found, started, listened to, ended. It shares no library with Blender, and what
# goes wrong in it stays in it.
import ctypes
import json
import os
import re
import selectors
import shutil
import signal
import subprocess
import time

WRITTEN_BUT_MISSED = 5  # exit status: the picture is there, its tolerance was not reached
_PR_SET_PDEATHSIG = 1
_POLL_SECONDS = 0.05
_GRACE_SECONDS = 3.0

try:
    _prctl = ctypes.CDLL(None).prctl
except (OSError, AttributeError):  # not Linux
    _prctl = None


class Failure(Exception):
    """Its text is for the user."""


class Cancelled(Exception):
    pass


def find_program(preference=""):
    """The path of the program: the preference, else $SCRIM, else what PATH holds."""
    for where, named in (
        ("the add-on's preferences name", preference),
        ("$SCRIM names", os.environ.get("SCRIM", "")),
    ):
        if named:
            found = shutil.which(os.path.expanduser(named))
            if not found:
                raise Failure(f"{where} '{named}' as the program scrim, which cannot be run")
            return found
    found = shutil.which("scrim")
    if not found:
        raise Failure(
            "the program scrim was not found: name it in the add-on's preferences, in $SCRIM, or add it to PATH"
        )
    return found


def pattern_of(path):
    """As what the program writes to, and scenes name: "####" and others would stand for the frame there."""
    return re.sub(r"[$#%]", r"$\g<0>", path)


def _die_with(parent):
    """For the child, before it becomes the program: it ends when the thread that waits for it does. Blender ends at
    once on SIGTERM, and would leave it behind."""

    def prepare():
        if _prctl is not None:
            _prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:  # it was too late
                os._exit(143)

    return prepare


def _start(arguments, stdout, stderr):
    return subprocess.Popen(
        arguments, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, preexec_fn=_die_with(os.getpid())
    )


def stop(process):
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_GRACE_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


class Background:
    """A child that nobody waits for. What it writes on stderr goes into the file `told`: a pipe that is read at its
    end alone would stop it once it is full."""

    def __init__(self, arguments, told):
        self.told = told
        with open(told, "wb") as file:
            self.process = _start(arguments, subprocess.DEVNULL, file)

    def ended(self):
        return self.process.poll() is not None

    def result(self):
        """Of one that has ended: its exit status, and the lines that it wrote on stderr."""
        with open(self.told, encoding="utf-8", errors="replace") as file:
            return self.process.returncode, file.read().splitlines()

    def stop(self):
        stop(self.process)


class _Lines:
    """Whole lines of what a pipe gives in pieces."""

    def __init__(self):
        self.rest = b""

    def add(self, piece):
        *lines, self.rest = (self.rest + piece).split(b"\n")
        return [line.decode(errors="replace") for line in lines]


def run(arguments, progress=lambda part: None, cancelled=lambda: False):
    """Runs the program to its end. `progress` gets 0 to 1, `cancelled` is asked now and then, both by this thread.
    Gives the exit status and the lines that it wrote on stderr; raises Cancelled."""
    process = _start(arguments, subprocess.PIPE, subprocess.PIPE)
    told = []
    try:
        with selectors.DefaultSelector() as selector:
            for pipe in (process.stdout, process.stderr):
                os.set_blocking(pipe.fileno(), False)
                selector.register(pipe, selectors.EVENT_READ, _Lines())
            while selector.get_map():
                if cancelled():
                    raise Cancelled
                for key, _ in selector.select(_POLL_SECONDS):
                    piece = os.read(key.fileobj.fileno(), 65536)
                    if not piece:
                        selector.unregister(key.fileobj)
                    for line in key.data.add(piece if piece else b"\n" if key.data.rest else b""):
                        if key.fileobj is process.stderr:
                            told.append(line)
                        else:
                            _report(line, progress)
        while process.poll() is None:
            if cancelled():
                raise Cancelled
            time.sleep(_POLL_SECONDS)
        return process.returncode, told
    finally:
        stop(process)
        process.stdout.close()
        process.stderr.close()


def _report(line, progress):
    try:
        progress(json.loads(line)["progress"] / 100)
    except (ValueError, KeyError, TypeError):
        pass  # another line


def warnings(told):
    mark = "scrim: warning: "
    return [line[len(mark) :] for line in told if line.startswith(mark)]


def reason(status, told):
    """Why the program failed, in one line: its last one, by contract."""
    last = next((line for line in reversed(told) if line.strip()), "")
    mark = "scrim: error: "
    if last.startswith(mark):
        return last[len(mark) :]
    if status < 0:
        return f"scrim was ended by signal {-status}" + (f": {last}" if last else "")
    return last or f"scrim ended with exit status {status}"
