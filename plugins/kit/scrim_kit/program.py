# SPDX-License-Identifier: Apache-2.0
"""The program `scrim` as a child process: started, listened to, ended.

A child shares no library with its parent, and what goes wrong in it stays in it. Its exit status says how it ended; the
last line on its standard error says why. A child ends when the thread that started it does.
"""

from __future__ import annotations

import ctypes
import enum
import json
import os
import selectors
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .failure import Failure

_PR_SET_PDEATHSIG = 1
_POLL_SECONDS = 0.05
_GRACE_SECONDS = 3.0
_WARNING = "scrim: warning: "
_ERROR = "scrim: error: "

try:
    _prctl = ctypes.CDLL(None).prctl
except (OSError, AttributeError):  # not Linux
    _prctl = None


class Status(enum.IntEnum):
    """Exit statuses of the program. Where a signal stopped it, the status is 128 + the number of the signal."""

    DONE = 0
    RENDER = 1  # something inside of a render went wrong
    USAGE = 2  # the command line is wrong
    INPUT = 3  # a scene or a file that it reads is missing or bad
    OUTPUT = 4  # a file could not be written
    INACCURATE = 5  # the picture is written, its accuracy was not reached
    MEMORY = 33  # the limit of memory does not suffice


def error_line(reason: str) -> str:
    """The last line on standard error of a program that fails: see `Ended.reason`."""
    return _ERROR + reason


class Cancelled(Exception):
    """The caller asked to stop."""


@dataclass(frozen=True)
class Ended:
    """How a run ended. `returncode`: the exit status, or -N where signal N killed the program. `told`: its lines on
    standard error. `output`: what it wrote on standard output, where that was read."""

    returncode: int
    told: list[str]
    output: str = ""

    @property
    def status(self) -> int:
        """The exit status as shells have it: 128 + N where signal N killed the program."""
        return self.returncode if self.returncode >= 0 else 128 - self.returncode

    @property
    def warnings(self) -> list[str]:
        return [line[len(_WARNING) :] for line in self.told if line.startswith(_WARNING)]

    @property
    def reason(self) -> str:
        """Why the program failed: its last line on standard error, without the program's name."""
        last = next((line for line in reversed(self.told) if line.strip()), "")
        if last.startswith(_ERROR):
            return last[len(_ERROR) :]
        if self.returncode < 0:
            return f"scrim was ended by signal {-self.returncode}" + (f": {last}" if last else "")
        return last or f"scrim ended with exit status {self.returncode}"


class Child:
    """A run of the program, whose standard error is read. `arguments`: the program's path, and its arguments.
    `reads_output`: whether standard output is read, too; else it is the parent's. Whoever starts a child waits for it.
    Raises Failure where the program cannot be started."""

    def __init__(self, arguments: Sequence[str], *, reads_output: bool = True) -> None:
        self._process = _start(arguments, subprocess.PIPE if reads_output else None, subprocess.PIPE)

    def signal(self, number: int) -> None:
        """Sends a signal. Signal handlers may call it. Does nothing where the program has ended."""
        self._process.send_signal(number)

    def wait(
        self,
        progress: Callable[[float], object] | None = None,
        told: Callable[[str], object] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> Ended:
        """Listens until the program ends. This thread calls `progress` with 0 to 1 for each line of `--progress json`,
        `told` with each line on standard error, and asks `cancelled` twenty times a second. Where `cancelled` says so,
        or a callback raises, the program is stopped first: `stop`. Raises Cancelled, and what callbacks raise."""
        process, lines, output = self._process, [], []

        def hear(line: str, is_output: bool) -> None:
            if is_output:
                output.append(line + "\n")
                part = _progress_of(line) if progress else None
                if part is not None:
                    progress(part)
            else:
                lines.append(line)
                if told:
                    told(line)

        try:
            self._listen(hear, cancelled)
            while process.poll() is None:  # its pipes are closed, but it still runs
                _check(cancelled)
                time.sleep(_POLL_SECONDS)
            return Ended(process.returncode, lines, "".join(output))
        finally:
            stop(process)
            for pipe in (process.stdout, process.stderr):
                if pipe:
                    pipe.close()

    def _listen(self, hear: Callable[[str, bool], None], cancelled: Callable[[], bool] | None) -> None:
        """Calls `hear(line, is it of standard output?)` until both pipes are closed."""
        process = self._process
        with selectors.DefaultSelector() as selector:
            for pipe in filter(None, (process.stdout, process.stderr)):
                os.set_blocking(pipe.fileno(), False)
                selector.register(pipe, selectors.EVENT_READ, _Lines())
            while selector.get_map():
                _check(cancelled)
                for key, _ in selector.select(_POLL_SECONDS if cancelled else None):
                    piece = os.read(key.fileobj.fileno(), 65536)
                    if not piece:
                        selector.unregister(key.fileobj)
                    for line in key.data.add(piece if piece else key.data.end()):
                        hear(line, key.fileobj is process.stdout)


class Background:
    """A run of the program that nobody waits for. Standard error goes into the file `told`: a pipe that is read at its
    end alone would stop the program once it is full. Raises Failure where the program cannot be started."""

    def __init__(self, arguments: Sequence[str], told: str) -> None:
        self._told = told
        with open(told, "wb") as file:
            self._process = _start(arguments, subprocess.DEVNULL, file)

    def has_ended(self) -> bool:
        return self._process.poll() is not None

    def result(self) -> Ended:
        """How the run ended. The run must have ended."""
        with open(self._told, encoding="utf-8", errors="replace") as file:
            return Ended(self._process.returncode, file.read().splitlines())

    def stop(self) -> None:
        """Ends the program as `stop` does."""
        stop(self._process)


def run(
    arguments: Sequence[str],
    progress: Callable[[float], object] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Ended:
    """Runs the program to its end, whatever its exit status: see `Child`."""
    return Child(arguments).wait(progress, cancelled=cancelled)


def ask(arguments: Sequence[str], seconds: float | None = None) -> Ended:
    """Runs a command that answers on standard output. Raises Failure with the program's reason and exit status where it
    fails, or where it takes longer than `seconds`."""
    deadline = None if seconds is None else time.monotonic() + seconds
    try:
        ended = run(arguments, cancelled=None if deadline is None else lambda: time.monotonic() > deadline)
    except Cancelled:
        raise Failure(f"scrim took longer than {seconds:g} seconds", Status.RENDER) from None
    if ended.returncode != Status.DONE:
        raise Failure(ended.reason, ended.returncode if ended.returncode > 0 else Status.RENDER)
    return ended


def stop(process: subprocess.Popen) -> None:
    """Ends a process if it still runs: by SIGTERM, at which the program leaves no half file, and three seconds later by
    SIGKILL."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_GRACE_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


class _Lines:
    """Whole lines of what a pipe gives in pieces."""

    def __init__(self) -> None:
        self._rest = b""

    def add(self, piece: bytes) -> list[str]:
        *lines, self._rest = (self._rest + piece).split(b"\n")
        return [line.decode(errors="replace") for line in lines]

    def end(self) -> bytes:
        """Takes the rest, which has no end of line, as a line."""
        return b"\n" if self._rest else b""


def _check(cancelled: Callable[[], bool] | None) -> None:
    if cancelled and cancelled():
        raise Cancelled


def _progress_of(line: str) -> float | None:
    """The finished part, 0 to 1, that a line of `--progress json` tells; None for other lines."""
    try:
        return json.loads(line)["progress"] / 100
    except (ValueError, KeyError, TypeError):
        return None


def _start(arguments: Sequence[str], stdout: object, stderr: object) -> subprocess.Popen:
    try:
        return subprocess.Popen(
            arguments, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, preexec_fn=_end_with(os.getpid())
        )
    except OSError as error:
        raise Failure(f"cannot start '{arguments[0]}': {error.strerror}", Status.RENDER) from None


def _end_with(parent: int) -> Callable[[], None]:
    """For the child, before it becomes the program: the system sends it SIGTERM when the thread that waits for it ends.
    Blender ends at once on SIGTERM, and would leave the program behind."""

    def prepare() -> None:
        if _prctl is not None:
            _prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
            if os.getppid() != parent:  # the parent ended before this call
                os._exit(143)

    return prepare
