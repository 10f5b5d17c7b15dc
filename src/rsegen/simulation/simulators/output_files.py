"""What a program prints, in two files: a simulator writes stdout in blocks, which would cut lines of stderr in one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from rsegen.simulation.simulators.base import LaunchCommand
from rsegen.simulation.simulators.process import RunningProgram, running

PAUSE = 0.1
"""Seconds between two looks into the files."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OutputFiles:
    """The files in a folder that hold stdout and stderr of a program."""

    folder: Path

    @property
    def paths(self) -> tuple[Path, Path]:
        """The file of stdout and that of stderr."""
        return self.folder / "stdout", self.folder / "stderr"

    @property
    def text(self) -> str:
        """What has been printed until now: stdout, perhaps to the middle of a line, then stderr from a new line on."""
        return "\n".join(path.read_text(errors="replace") for path in self.paths)

    @contextmanager
    def running(self, launch: LaunchCommand) -> Iterator[RunningProgram]:
        """A program that prints into these files, and is ended when this ends."""
        output, errors = self.paths
        with output.open("w") as out, errors.open("w") as err, running(launch, out, err) as program:
            yield program

    def lines(self, goes_on: Callable[[], bool]) -> Iterator[str]:
        """The lines of both files as they are written, as long as their program goes on."""
        with ExitStack() as stack:
            readers = [_Reader(stack.enter_context(path.open(errors="replace"))) for path in self.paths]
            more = True
            while more:
                more = goes_on()
                for reader in readers:
                    yield from reader.whole_lines()
                time.sleep(PAUSE if more else 0)
            yield from (reader.rest for reader in readers)


class _Reader:
    """Reads a file that is being written; `rest` is the line that has no end yet."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        self.rest = ""

    def whole_lines(self) -> list[str]:
        """The lines that have been written since the last call."""
        *whole, self.rest = (self.rest + self._file.read()).split("\n")
        return whole
