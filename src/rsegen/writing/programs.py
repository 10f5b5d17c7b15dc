r"""Programs in sessions of their own, which end with all that they have started, and what they print.

    rsegen --starts--> program (and what it starts)
       |  \--starts--> watchdog.py
       pipe ------------^   closed: by rsegen, or by the system when rsegen is gone

There is one way to end a program: the pipe closes, and the watch ends the program's session. The program is started by
a shell that names itself to the watch through the same pipe before it becomes the program, so there is no moment in
which anything runs that the watch will not end (decision 9). Cost: 0.1 s of CPU time per program.
"""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import IO

from rsegen.writing import stop

_WATCH = Path(__file__).with_name("watchdog.py")
_NAMED = ("/bin/sh", "-c", 'echo $$ >&0; exec "$@" </dev/null', "sh")
"""A shell that writes its id, which is that of the session, into the watch's pipe, and becomes the program."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LaunchCommand:
    """A command, the environment variables to add, and the working folder."""

    command: tuple[str, ...]
    environment: Mapping[str, str]
    folder: Path

    @property
    def shell_line(self) -> str:
        """The command line for a shell."""
        variables = (f"{name}={shlex.quote(value)}" for name, value in self.environment.items())
        return " ".join(["cd", shlex.quote(str(self.folder)), "&&", *variables, shlex.join(self.command)])

    def with_variables(self, variables: Mapping[str, str]) -> LaunchCommand:
        """Return the command with more variables."""
        return replace(self, environment=MappingProxyType({**self.environment, **variables}))

    def with_options(self, *options: str) -> LaunchCommand:
        """Return the command with more options in front of the world."""
        return replace(self, command=(*self.command[:-1], *options, self.command[-1]))


@dataclass(frozen=True, kw_only=True, slots=True)
class RunningProgram:
    """A program that runs or has ended."""

    process: subprocess.Popen[str]
    watch: subprocess.Popen[str]

    @property
    def exit_code(self) -> int | None:
        """The exit code; None while it runs."""
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
    with ExitStack() as stack:
        with stop.held():  # a Ctrl-C between the two would leave a process that nobody waits for
            watch = subprocess.Popen(
                [sys.executable, str(_WATCH)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                text=True,
                start_new_session=True,
            )
            stack.callback(watch.wait)
            stack.callback(watch.stdin.close if watch.stdin else watch.kill)  # also if the program cannot be started
            process = subprocess.Popen(
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
            program = RunningProgram(process=process, watch=watch)
            stack.callback(program.end)
        yield program


def has_screen() -> bool:
    """Return whether a window can be shown; only on Linux can it be known that there is no screen."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
