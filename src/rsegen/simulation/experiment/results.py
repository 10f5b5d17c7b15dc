"""Outcomes of trials, as lines of the journal of an experiment's folder, and the files of what robots did in them.

    tracks/row1-80-free-0.csv   poses of the robots in the first trial of the plan's first row, 80 x 80 blocks, at
    `free` tracks/row1-80-free.png     a picture of those in the last trial of this cell, on the plan of its map

A stopped experiment goes on with the outcomes in the journal. They are read as a file from anybody: whatever is no
outcome of this plan is refused with its place.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from rsegen.errors import FileError, ParameterError, inside, refuse_unknown, shown
from rsegen.io.input_files import JOURNAL
from rsegen.params.sorts import Choice, Flag, Float, Integer, Json, Parameter
from rsegen.run.journal import Journal
from rsegen.simulation.driving.drive import draw_trajectories
from rsegen.simulation.driving.drive_metrics import COLUMNS, Trajectory
from rsegen.simulation.experiment.plan import PACES, Cell, ExperimentPlan
from rsegen.simulation.experiment.trial import Outcome, Trial

_CELL: Mapping[str, Parameter] = {"row": Integer(0), "size": Integer(0), "pace": Choice(PACES)}
_OUTCOME: Mapping[str, Parameter] = {
    **{field.name: Float() for field in fields(Outcome)},
    "starved": Flag(),
    "attempts": Integer(1),
}
_OPTIONAL = frozenset(_OUTCOME) - {"load", "memory", "speed"}
"""Figures that not every trial has: some paces, and robots that are not in the record, lack some of them."""

Results = Mapping[Cell, list[Outcome]]
"""The outcomes of every cell, in the order of its repeats."""

Entries = dict[tuple[Cell, int], Outcome]
"""The outcome of each repeat of a cell that was tried, by its number."""


def entry(cell: Cell, repeat: int, outcome: Outcome) -> dict[str, Json]:
    """Return an outcome as the journal has it."""
    return {"cell": asdict(cell), "repeat": repeat, "outcome": asdict(outcome)}


def read_entries(journal: Journal | None, folder: Path, rows: int) -> Entries:
    """Return the outcomes in the journal of a folder; FileError for the first that something else has changed."""
    entries = {}
    for number, result in enumerate(journal.results if journal else (), 1):
        try:
            cell, outcome = read_cell(result.get("cell"), rows), read_outcome(result.get("outcome"))
            entries[cell, Integer(0).check("repeat", result.get("repeat"))] = outcome
        except ParameterError as error:  # noqa: PERF203  # an experiment has some hundred
            advice = "delete its line, or give another folder, or force=True"
            raise FileError(f"{folder / JOURNAL}: result {number}: {error}; {advice}") from None
    return entries


def results_of(entries: Entries) -> Results:
    """Return the outcomes of every cell."""
    results: dict[Cell, list[Outcome]] = {}
    for (cell, _), outcome in entries.items():
        results.setdefault(cell, []).append(outcome)
    return results


def read_cell(content: object, rows: int) -> Cell:
    """Return the cell that a file has, of a plan with this number of rows; a ParameterError if it cannot be."""
    return Cell(**_checked("cell", content, {**_CELL, "row": Integer(0, rows - 1)}))


def read_outcome(content: object) -> Outcome:
    """Return the outcome that a file has; a ParameterError if a value is no number."""
    return Outcome(**_checked("outcome", content, _OUTCOME, _OPTIONAL))


def _checked(
    where: str, content: object, sorts: Mapping[str, Parameter], optional: Collection[str] = ()
) -> dict[str, Any]:
    """Return the values of a mapping by their sorts; a ParameterError for one that is missing, too many, or wrong."""
    if not isinstance(content, Mapping):
        raise ParameterError(where, f"{shown(content)} is not a mapping with {', '.join(sorts)}")
    with inside(where):
        refuse_unknown("key", content, sorts)
        given = ((name, sort, content.get(name)) for name, sort in sorts.items())
        return {
            name: None if value is None and name in optional else sort.check(name, value) for name, sort, value in given
        }


FOLDER = "tracks"
"""The folder of trajectories, in the folder of the results."""


def track_files(plan: ExperimentPlan, cell: Cell, repeat: int, trial: Trial) -> dict[str, list[bytes]]:
    """Return the file of the trajectories of a trial, and a picture of them if it is the last one of its cell."""
    if not trial.trajectories:
        return {}
    rows, *picture = track_names(plan, [(cell, repeat)])
    files = {rows: [line.encode() for line in tracks_csv(trial.trajectories)]}
    return files | {name: [draw_trajectories(trial.scene, trial.trajectories)] for name in picture}


def track_names(plan: ExperimentPlan, trials: Collection[tuple[Cell, int]] | None = None) -> Iterator[str]:
    """Yield the name of every file that the tracks of these trials have, by default of all of a plan."""
    for cell, repeat in plan.order() if trials is None else trials:
        name = f"{FOLDER}/row{cell.row + 1}-{cell.size}-{cell.pace}"
        yield f"{name}-{repeat}.csv"
        if repeat == plan.repeats - 1:
            yield f"{name}.png"


def tracks_csv(trajectories: Mapping[str, Trajectory]) -> Iterator[str]:
    """Yield the lines of a CSV file: a header, then robot after robot."""
    yield ",".join(["robot", *COLUMNS]) + "\n"
    for name, trajectory in trajectories.items():
        _, *lines = trajectory.csv()
        yield from (f"{name},{line}" for line in lines)
