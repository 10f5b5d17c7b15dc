"""Outcomes of trials, as lines of the journal of an experiment's folder: a stopped experiment goes on with them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, refuse_unknown, shown
from rsegen.io.checksums import JOURNAL
from rsegen.params.sorts import Choice, Float, Integer, Json, Parameter
from rsegen.run.journal import Journal
from rsegen.simulation.experiment.plan import PACES, Cell
from rsegen.simulation.experiment.trial import Outcome

_CELL: Mapping[str, Parameter] = {"row": Integer(0), "size": Integer(0), "pace": Choice(PACES)}
_OUTCOME: Mapping[str, Parameter] = {field.name: Float() for field in fields(Outcome)}
_OPTIONAL = frozenset(_OUTCOME) - {"load", "memory", "speed"}
"""Figures that not every trial has: some paces, and robots that are not in the record, lack some of them."""

Results = Mapping[Cell, list[Outcome]]
"""The outcomes of every cell, in the order of its repeats."""


Entry = tuple[Cell, int, Outcome]
"""A cell, the number of the repeat, and what it measured."""


def entry(cell: Cell, repeat: int, outcome: Outcome) -> dict[str, Json]:
    """Return an outcome as the journal has it."""
    return {"cell": asdict(cell), "repeat": repeat, "outcome": asdict(outcome)}


def read_entries(journal: Journal | None, folder: Path, rows: int) -> list[Entry]:
    """Return the outcomes in the journal of a folder; FileError for the first that something else has changed."""
    entries = []
    for number, result in enumerate(journal.results if journal else (), 1):
        try:
            cell, outcome = read_cell(result.get("cell"), rows), read_outcome(result.get("outcome"))
            entries.append((cell, Integer(0).check("repeat", result.get("repeat")), outcome))
        except ParameterError as error:  # noqa: PERF203  # an experiment has some hundred
            advice = "delete its line, or give another folder, or --force"
            raise FileError(f"{folder / JOURNAL}: result {number}: {error}; {advice}") from None
    return entries


def results_of(entries: Iterable[Entry]) -> Results:
    """Return the outcomes of every cell."""
    found: dict[Cell, list[Outcome]] = {}
    for cell, _, outcome in entries:
        found.setdefault(cell, []).append(outcome)
    return found


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
