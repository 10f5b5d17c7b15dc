"""Output, resources and working folders of a simulator's program.

stdout and stderr go into two files: a simulator writes stdout in blocks, which would cut lines of stderr in one. Error
lines that differ in numbers alone are passed on once, as an old Gazebo Sim prints some at every step.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryFile
from typing import NamedTuple

from rsegen.errors import SimulatorFailed
from rsegen.simulators.patience import Patience, share
from rsegen.writing import stop
from rsegen.writing.programs import LaunchCommand, RunningProgram, running

_SHORT_COMMAND = Patience(seconds=30.0)
"""Time for a short command, such as one that prints a version: on a cold disk Gazebo's take some seconds."""

_WORKS = 0.3
"""Part of a processor's time, of what it can have, from which on a program works, and does not only wait."""


def command_output(command: Sequence[str | Path]) -> str:
    """Return stdout and stderr of a short command; SimulatorFailed if it prints nothing for long.

    Empty if it does not exist.
    """
    # The output is a file, whole once the command has ended: a pipe its children could keep open for longer.
    launch = LaunchCommand(command=tuple(map(str, command)), environment={}, folder=Path.cwd())
    with suppress(OSError), ExitStack() as stack:
        file = stack.enter_context(TemporaryFile("w+", encoding="utf-8", errors="replace"))
        started = stack.enter_context(running(launch, file))
        wait = replace(_SHORT_COMMAND, works=Work(started)).begin()
        while started.exit_code is None and not wait.is_over:
            with suppress(subprocess.TimeoutExpired):
                started.process.wait(min(PAUSE, _SHORT_COMMAND.seconds))
        has_ended = started.exit_code is not None
        file.seek(0)
        printed = file.read()
        if not (printed or has_ended):
            words = shlex.join(launch.command)
            raise SimulatorFailed(f"{words} prints nothing, after {_SHORT_COMMAND} without progress")
        return printed
    return ""


class Work:
    """Progress of a program that has just been started, and its children: they use a processor, or write into the files
    of a folder.

    A paused server of Gazebo that waits for nothing uses 5 to 15 % of a processor, one that loads a world all of one.
    """

    def __init__(self, program: RunningProgram, folder: Path | None = None) -> None:
        self._program = program
        self._output = OutputFiles(folder=folder).paths if folder else ()
        self._seen = time.monotonic(), 0.0, 0  # the program has just been started

    @stop.held()  # a Ctrl-C inside psutil would leave the file open that it reads
    def __call__(self) -> bool:
        """Return whether they have worked since the last call."""
        # The time, the seconds of CPU of all processes, and the bytes of the files: then, and now.
        (began, cpu, size), cpu_now = self._seen, 0.0
        with suppress(SimulatorFailed):
            cpu_now = usage(self._program.process.pid).cpu
        now, size_now = time.monotonic(), sum(file.stat().st_size for file in self._output if file.exists())
        self._seen = now, cpu_now, size_now
        return size_now > size or cpu_now - cpu > _WORKS * (now - began) * share()


class Usage(NamedTuple):
    """CPU time in seconds so far, and memory in MiB."""

    cpu: float
    memory: float


def usage(pid: int) -> Usage:
    """Return the usage of a process and of all that it has started; SimulatorFailed if it has ended.

    Resident memory counts shared pages once per process, so the sum for several processes is too large.
    """
    import psutil

    try:
        first = psutil.Process(pid)
        children, usages = first.children(recursive=True), [(first.cpu_times(), first.memory_info())]
    except psutil.Error:
        raise SimulatorFailed("the simulator is gone") from None
    for child in children:
        with suppress(psutil.Error):  # it ends in this moment
            usages.append((child.cpu_times(), child.memory_info()))
    cpu = sum(times.user + times.system for times, _ in usages)
    return Usage(cpu=cpu, memory=sum(memory.rss for _, memory in usages) / 2**20)


PAUSE = 0.1
"""Seconds between two looks into the files: soon enough for a person who watches, at no cost."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OutputFiles:
    """The files in a folder that hold stdout and stderr of a program."""

    folder: Path

    @property
    def paths(self) -> tuple[Path, Path]:
        """The files of stdout and stderr."""
        return self.folder / "stdout", self.folder / "stderr"

    @property
    def text(self) -> str:
        """The output until now: stdout, perhaps to the middle of a line, then stderr from a new line on."""
        return "\n".join(path.read_text(errors="replace") for path in self.paths)

    @contextmanager
    def running(self, launch: LaunchCommand) -> Iterator[RunningProgram]:
        """A program that prints into these files, and is ended when this ends."""
        output, errors = self.paths
        with output.open("w") as out, errors.open("w") as err, running(launch, out, err) as program:
            yield program

    def lines(self, goes_on: Callable[[], bool]) -> Iterator[str]:
        """Yield the lines of both files as they are written, as long as their program goes on."""
        with ExitStack() as stack:
            files = [stack.enter_context(path.open(errors="replace")) for path in self.paths]
            rests, more = dict.fromkeys(files, ""), True  # the line of each file that has no end yet
            while more:
                stop.check()  # Python drops a Ctrl-C that comes in a destructor or a callback
                more = goes_on()
                for file in files:
                    *whole, rests[file] = (rests[file] + file.read()).split("\n")
                    yield from whole
                time.sleep(PAUSE if more else 0)
            yield from rests.values()


_NUMBER = re.compile(r"(?<!\w)[-+]?\d[\d.:]*(?:e[-+]?\d+)?(?!\w)")
"""A number that stands alone, as an id or a time does; those in names such as rse_0001.obj do not."""


class ErrorRelay:
    """Passes on the first of all error lines that differ in numbers alone, and counts them."""

    def __init__(self, on_error: Callable[[str], None]) -> None:
        self._on_error = on_error
        self._first: dict[str, str] = {}
        self._counts: Counter[str] = Counter()

    @property
    def first(self) -> str | None:
        """The first line that was passed on."""
        return next(iter(self._first.values()), None)

    @property
    def lines(self) -> tuple[str, ...]:
        """Every line that was passed on, with the count of its like if there are several."""
        return tuple(_with_count(line, self._counts[kind]) for kind, line in self._first.items())

    def add(self, line: str) -> None:
        """Count a line, and pass it on if it is the first of its kind."""
        kind = _NUMBER.sub("#", line)
        self._counts[kind] += 1
        if kind not in self._first:
            self._first[kind] = line
            self._on_error(line)

    def finish(self) -> None:
        """Pass on every line that has come more than once again, with its count."""
        for kind, line in self._first.items():
            if self._counts[kind] > 1:
                self._on_error(_with_count(line, self._counts[kind]))


def grouped_line(lines: Iterable[str]) -> tuple[str, ...]:
    """Return the first of all lines that differ in numbers alone, with their count if there are several."""
    relay = ErrorRelay(lambda _: None)
    for line in lines:
        relay.add(line)
    return relay.lines


def _with_count(line: str, count: int) -> str:
    return f"{line} ({count} times)" if count > 1 else line
