"""A driver (driver.py) with its own folder and its own shared memory: runs commands for the trials."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType
from typing import Any

import rsegen
from tests.crash.driver import CONTROL
from tests.crash.injection import Injection, mapped_control
from tests.crash.judging import End

_ROOTS = (Path(rsegen.__file__).parents[1], Path(__file__).parents[2])


class Server:
    """Runs commands in `folder/trial/root`; one at a time, or two if the first is stopped.

    control: a file of the memory that it shares with its driver, on this machine's own disk
    lacks: what its disk lacks, as fields of an Injection
    """

    def __init__(self, folder: Path, control: Path, library: Path, inputs: Path) -> None:
        folder.mkdir(parents=True)
        self.trial: Path = folder / "trial"
        self.root: Path = self.trial / "root"
        self._inputs, self._said = inputs, folder / "stderr"
        self.lacks: Mapping[str, Any] = {}
        mapped_control(control)
        environment = os.environ | {
            CONTROL: str(control),
            "LD_PRELOAD": str(library),
            "PYTHONPATH": os.pathsep.join(map(str, _ROOTS)),
            "OPENBLAS_NUM_THREADS": "1",  # a fork has none of them
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        self._driver = subprocess.Popen(
            [sys.executable, "-m", "tests.crash.driver"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )

    def __enter__(self) -> Server:
        return self

    def __exit__(self, _: type[BaseException] | None, __: BaseException | None, ___: TracebackType | None) -> None:
        self._driver.communicate()

    def run(self, command: Sequence[str], injection: Injection | None = None) -> End:
        """Run a command until it has ended or is stopped."""
        answer = self._asked(
            "start",
            arguments=self._filled(command),
            folder=str(self.root),
            root=str(self.root),
            injection=asdict(replace(injection or Injection(), **self.lacks)),
        )
        return End.of(answer)

    def second(self, command: Sequence[str]) -> End:
        """Run another command while the first is stopped."""
        return End.of(self._asked("second", arguments=self._filled(command), folder=str(self.root)))

    def go_on(self) -> End:
        """Wake the first up, and wait until it has ended."""
        return End.of(self._asked("continue"))

    def _filled(self, command: Sequence[str]) -> list[str]:
        return [word.replace("{inputs}", str(self._inputs)) for word in command]

    def _asked(self, what: str, **request: Any) -> Any:
        asks, answers = self._driver.stdin, self._driver.stdout
        assert asks
        assert answers
        asks.write(json.dumps({"what": what, "said": str(self._said), **request}) + "\n")
        asks.flush()
        return json.loads(answers.readline())
