"""Outcomes on disk, one JSON line each, so that a stopped experiment can be resumed."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rsegen.errors import FileError
from rsegen.io.input_files import open_regular
from rsegen.io.syncing import sync_folder
from rsegen.simulation.experiment.plan import Cell
from rsegen.simulation.experiment.trial import Outcome

_BEGIN = b'{"plan":'

Results = Mapping[Cell, list[Outcome]]
"""The outcomes of every cell, in the order of its repeats."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ResultsLog:
    """A file with the plan on its first line, to which every outcome is appended."""

    path: Path

    def begin(self, plan: Mapping[str, object]) -> None:
        """Create it, or resume one of the same plan; FileError if it is of another plan."""
        if not self.path.exists():
            self._add({"plan": plan})
            sync_folder(self.path.parent)
            return
        self._mend()
        if self._first() != json.loads(json.dumps({"plan": plan})):
            raise FileError(f"{self.path}: has the outcomes of another plan; give another folder, or --force")

    def add(self, cell: Cell, repeat: int, outcome: Outcome) -> None:
        """Append an outcome."""
        self._add({"cell": asdict(cell), "repeat": repeat, "outcome": asdict(outcome)})

    def entries(self) -> Iterator[tuple[Cell, int, Outcome]]:
        """All complete lines: cell, repeat and outcome."""
        for line in self._lines()[1:]:
            yield Cell(**line["cell"]), line["repeat"], Outcome(**line["outcome"])

    def results(self) -> Results:
        """The outcomes of every cell."""
        found: dict[Cell, list[Outcome]] = {}
        for cell, _, outcome in self.entries():
            found.setdefault(cell, []).append(outcome)
        return found

    def _mend(self) -> None:
        """Delete an incomplete last line, left by a run that was stopped."""
        whole, _, broken = self.path.read_bytes().rpartition(b"\n")
        if broken:
            with self.path.open("r+b") as file:
                file.truncate(len(whole) + 1 if whole else 0)

    def _first(self) -> object:
        lines = self._lines()
        return lines[0] if lines else None

    def _lines(self) -> list[dict[str, Any]]:
        try:
            text = self.path.read_text("utf-8")
            return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]
        except (OSError, ValueError):
            raise FileError(f"{self.path}: not the results log of an experiment") from None

    def _add(self, entry: Mapping[str, object]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")
            file.flush()
            os.fsync(file.fileno())


def is_results_log(path: Path) -> bool:
    """Whether a file is the results log of an experiment, as its beginning says; an empty one is."""
    try:
        with open_regular(path) as file:
            start = file.read(len(_BEGIN))
    except OSError:
        return False
    return start == _BEGIN[: len(start)]
