r"""Programs in sessions of their own, which end with all that they have started, however rsegen itself ends.

    rsegen --starts--> program (and what it starts)
       |  \--starts--> watchdog.py
       pipe ------------^   closed: by rsegen, or by the system when rsegen is gone

There is one way to end a program: the pipe closes, and the watch ends the program's session. The program is started by
a shell that names itself to the watch through the same pipe before it becomes the program, so there is no moment in
which anything runs that the watch will not end.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

from rsegen.errors import SimulatorFailed
from rsegen.simulation.simulators.base import LaunchCommand

_WATCH = Path(__file__).with_name("watchdog.py")
_NAMED = ("/bin/sh", "-c", 'echo $$ >&0; exec "$@" </dev/null', "sh")


@dataclass(frozen=True, kw_only=True, slots=True)
class RunningProgram:
    """A program that runs or has ended."""

    process: subprocess.Popen[str]
    watch: subprocess.Popen[str]

    @property
    def exit_code(self) -> int | None:
        """Its exit code; None while it runs."""
        return self.process.poll()

    def end(self) -> None:
        """End it with all that it has started: by SIGINT first, and by SIGKILL after some seconds."""
        if self.watch.stdin:
            self.watch.stdin.close()
        self.watch.wait()
        if self.process.poll() is None:  # somebody has killed the watch
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()


@contextmanager
def running(
    launch: LaunchCommand, output: IO[str] | int, errors: IO[str] | int = subprocess.STDOUT
) -> Iterator[RunningProgram]:
    """A program that is ended when this ends; stdout goes to `output`, stderr to `errors`, by default there too."""
    watch = subprocess.Popen(
        [sys.executable, str(_WATCH)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    with _closed_at_end(watch):
        started = RunningProgram(process=_started(launch, output, errors, watch), watch=watch)
        try:
            yield started
        finally:
            started.end()


def output_of(launch: LaunchCommand, timeout: float) -> str:
    """stdout and stderr of a program that ends by itself; SimulatorFailed if it takes longer than `timeout` s."""
    printed, has_ended = _printed(launch, timeout)
    if not has_ended:
        raise SimulatorFailed(f"{launch.command[0]}: no answer in {timeout:g} s")
    return printed


def command_output(command: Sequence[str | Path]) -> str:
    """stdout and stderr of a short command, also if it does not end; empty if there is no such command."""
    try:
        return _printed(LaunchCommand(command=tuple(map(str, command)), environment={}, folder=Path.cwd()), 30)[0]
    except OSError:
        return ""


def _printed(launch: LaunchCommand, timeout: float) -> tuple[str, bool]:
    """What a program prints in some seconds, and whether it has ended: its end counts, not that of a pipe, which any
    process that it has started may keep open.
    """
    with TemporaryFile("w+", encoding="utf-8", errors="replace") as file, running(launch, file) as started:
        with suppress(subprocess.TimeoutExpired):
            started.process.wait(timeout)
        has_ended = started.exit_code is not None
        file.seek(0)
        return file.read(), has_ended


def _started(
    launch: LaunchCommand, output: IO[str] | int, errors: IO[str] | int, watch: subprocess.Popen[str]
) -> subprocess.Popen[str]:
    return subprocess.Popen(
        (*_NAMED, *launch.command),
        env=os.environ | dict(launch.environment),
        cwd=launch.folder,
        stdin=watch.stdin,
        stdout=output,
        stderr=errors,
        text=True,
        errors="replace",
        start_new_session=True,
    )


@contextmanager
def _closed_at_end(watch: subprocess.Popen[str]) -> Iterator[None]:
    try:
        yield
    finally:
        if watch.stdin:
            watch.stdin.close()
        watch.wait()
