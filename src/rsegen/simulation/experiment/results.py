"""Outcomes on disk, one JSON line each, so that a stopped experiment can be resumed."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, refuse_unknown, shown
from rsegen.io.input_files import open_regular, regular_content
from rsegen.io.syncing import sync_folder
from rsegen.io.text_files import text_of
from rsegen.params.sorts import Choice, Float, Integer, Json, Parameter
from rsegen.simulation.experiment.plan import PACES, Cell
from rsegen.simulation.experiment.trial import Outcome

_BEGIN = b'{"plan":'
_MOST_MIB = 256

_CELL: Mapping[str, Parameter] = {"row": Integer(0), "size": Integer(0), "pace": Choice(PACES)}
_OUTCOME: Mapping[str, Parameter] = {field.name: Float() for field in fields(Outcome)}
_OPTIONAL = frozenset(_OUTCOME) - {"load", "memory", "speed"}
"""Figures that not every trial has: some paces, and robots that are not in the record, lack some of them."""

Results = Mapping[Cell, list[Outcome]]
"""The outcomes of every cell, in the order of its repeats."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ResultsLog:
    """A file with the plan on its first line, to which every outcome is appended."""

    path: Path

    def begin(self, plan: Mapping[str, object]) -> None:
        """Create it, or resume one of the same plan; FileError, and nothing is changed, if it is of another plan."""
        if not self.path.exists() or self._is_beginning_of({"plan": plan}):
            self.path.unlink(missing_ok=True)
            self._add({"plan": plan})
            sync_folder(self.path.parent)
            return
        if self._first() != json.loads(json.dumps({"plan": plan})):
            raise FileError(f"{self.path}: has the outcomes of another plan; give another folder, or --force")
        for _ in self.entries():
            pass  # each is checked before anything is changed
        self._mend()

    def add(self, cell: Cell, repeat: int, outcome: Outcome) -> None:
        """Append an outcome."""
        self._add({"cell": asdict(cell), "repeat": repeat, "outcome": asdict(outcome)})

    def entries(self) -> Iterator[tuple[Cell, int, Outcome]]:
        """All complete lines: cell, repeat and outcome; FileError for the first that something else has changed."""
        first, *lines = self._lines() or [None]
        rows = _rows(first)
        for number, line in enumerate(lines, 2):
            try:
                entry = line if isinstance(line, Mapping) else {}
                cell, outcome = read_cell(entry.get("cell"), rows), read_outcome(entry.get("outcome"))
                repeat = Integer(0).check("repeat", entry.get("repeat"))
            except ParameterError as error:
                advice = "delete the line, or give another folder, or --force"
                raise FileError(f"{self.path}: line {number}: {error}; {advice}") from None
            yield cell, repeat, outcome

    def results(self) -> Results:
        """The outcomes of every cell."""
        found: dict[Cell, list[Outcome]] = {}
        for cell, _, outcome in self.entries():
            found.setdefault(cell, []).append(outcome)
        return found

    def _mend(self) -> None:
        """Delete an incomplete last line, left by a run that was stopped."""
        whole, _, broken = self._content().rpartition(b"\n")
        if broken:
            with self.path.open("r+b") as file:
                file.truncate(len(whole) + 1 if whole else 0)

    def _is_beginning_of(self, entry: Mapping[str, object]) -> bool:
        """Whether it has nothing but a part of its first line, as after a run that was killed when it wrote it."""
        return json.dumps(entry).encode().startswith(self._content())

    def _content(self) -> bytes:
        try:
            with open_regular(self.path) as reading:
                return reading.read()
        except OSError as error:
            raise FileError(f"{self.path}: {error.strerror or error}") from None

    def _first(self) -> Json:
        return next(iter(self._lines()), None)

    def _lines(self) -> list[Json]:
        text = text_of(self.path, _MOST_MIB, "a results log")
        try:
            return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]
        except (RecursionError, ValueError):
            raise FileError(f"{self.path}: not the results log of an experiment") from None

    def _add(self, entry: Mapping[str, object]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")
            file.flush()
            os.fsync(file.fileno())


def read_cell(found: object, rows: int) -> Cell:
    """The cell that a file has, of a plan with this number of rows; a ParameterError if it cannot be."""
    return Cell(**_checked("cell", found, {**_CELL, "row": Integer(0, rows - 1)}))


def read_outcome(found: object) -> Outcome:
    """The outcome that a file has; a ParameterError if a value is no number."""
    return Outcome(**_checked("outcome", found, _OUTCOME, _OPTIONAL))


def _checked(
    where: str, found: object, sorts: Mapping[str, Parameter], optional: Collection[str] = ()
) -> dict[str, Any]:
    """The values of a mapping by their sorts; a ParameterError for one that is missing, too many, or wrong."""
    if not isinstance(found, Mapping):
        raise ParameterError(where, f"{shown(found)} is not a mapping with {', '.join(sorts)}")
    try:
        refuse_unknown("key", found, sorts)
        given = {name: found.get(name) for name in sorts}
        return {
            name: None if given[name] is None and name in optional else sort.check(name, given[name])
            for name, sort in sorts.items()
        }
    except ParameterError as error:
        raise (error.inside(where) if where else error) from None


def _rows(first: Json) -> int:
    """How many rows the plan on the first line has."""
    plan = first.get("plan") if isinstance(first, Mapping) else None
    rows = plan.get("rows") if isinstance(plan, Mapping) else None
    return len(rows) if isinstance(rows, Sequence) else 0


def is_results_log(path: Path) -> bool:
    """Whether a file is the results log of an experiment, as its beginning says; an empty one is."""
    start = regular_content(path, len(_BEGIN))
    return start is not None and start == _BEGIN[: len(start)]
