"""`rsegen.experiment`: the trials of a plan run one by one, logged as they end, and reported in tables and a plot."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from rsegen.errors import FileError, OutputError, ParameterError, Stopped
from rsegen.io import recipe_file
from rsegen.io.input_files import checksum_of
from rsegen.params.sorts import Json, Text
from rsegen.robots import is_robot_file, with_arguments
from rsegen.run.journal import is_intact, read_errors, read_journal
from rsegen.run.store import Store, open_store, refuse_busy, refuse_irreplaceable, replacing
from rsegen.simulation.experiment.machine import description
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, load_plan, read_plan
from rsegen.simulation.experiment.report import plot, report_page, trials_csv
from rsegen.simulation.experiment.results import (
    Results,
    entry,
    read_cell,
    read_entries,
    read_outcome,
    results_of,
    track_files,
    track_names,
)
from rsegen.simulation.experiment.trial import refuse_undrivable, refuse_without_frames, run_trial
from rsegen.simulation.simulators.server import choose_installation

HOLDS = "experiment"
_LINE = Text(r".{0,4096}", "a line of at most 4096 letters")
"""The command line in a summary, which may come from anybody; 4096 is the longest path of Linux."""

REPORT_FILES = ("table.md", "trials.csv", "summary.json", "plot.png")


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentResult:
    """The result of `rsegen.experiment`: the plan, every cell's outcomes, the machine, and the folder of the files.

    command: the command line, or the call in Python, that gives them
    """

    plan: ExperimentPlan
    results: Results
    machine: dict[str, str]
    folder: Path
    command: str

    @property
    def table(self) -> str:
        """The content of table.md."""
        return report_page(self.plan, self.results, self.machine, self.command)


def run_experiment(  # noqa: PLR0913  # as `rsegen.experiment`
    plan: str | os.PathLike[str] | ExperimentPlan,
    folder: Path,
    simulators: Sequence[str] | None,
    *,
    force: bool,
    timeout: float,
    progress: Callable[[int, Cell], None],
    watch: Callable[[], None],
) -> ExperimentResult:
    """Run the trials of a plan that are missing in its folder, and report on all of them; see `rsegen.experiment`."""
    command = _command(plan, folder, simulators)
    plan = plan if isinstance(plan, ExperimentPlan) else load_plan(os.fspath(plan))
    plan = in_simulators(plan, simulators)
    names = dict.fromkeys(str(row.simulator) for row in plan.rows)
    installed = {name: choose_installation("both", name, timeout) for name in names}
    refuse_without_frames(plan, installed)
    refuse_undrivable(plan)
    machine = {"simulator": ", ".join(map(str, installed.values())), **description()}
    with _opened(plan, folder, force=force) as store:
        done = read_entries(store.journal.content, folder, len(plan.rows))
        store.foresee([*REPORT_FILES, *track_names(plan)], kept=track_names(plan, done))
        for number, (cell, repeat) in enumerate(plan.order()):
            progress(number, cell)
            if (cell, repeat) not in done:
                try:  # first the tracks of a trial are written, then its outcome
                    trial = run_trial(plan, cell, repeat, installed[str(plan.rows[cell.row].simulator)], watch)
                    if files := track_files(plan, cell, repeat, trial):
                        store.put(files, force=True, holds=HOLDS)
                    store.note(entry(cell, repeat, trial.outcome))
                    done[cell, repeat] = trial.outcome
                except KeyboardInterrupt:
                    there = f"{len(done)} of {len(plan.cells) * plan.repeats} trials are complete in {folder}"
                    raise Stopped(there, changed=bool(done)) from None
        result = ExperimentResult(plan=plan, results=results_of(done), machine=machine, folder=folder, command=command)
        store.put({name: [content] for name, content in _files(result).items()}, force=True, holds=HOLDS)
    return result


@contextmanager
def _opened(plan: ExperimentPlan, folder: Path, *, force: bool) -> Iterator[Store]:
    """Open the folder of the results, or that of those which replace them; an OutputError if that may not be."""
    # Three cases: replace another experiment, refuse other files, or go on with what this plan has begun.
    refuse_busy(folder)
    of: Json = json.loads(json.dumps({**asdict(plan), **_robot_files(plan)}))
    journal = read_journal(folder)
    if force and journal:
        refuse_irreplaceable(folder, HOLDS)
        with replacing(folder, HOLDS, of) as store:
            yield store
        return
    if journal and (journal.holds, journal.of) != (HOLDS, of):
        has = "the outcomes of another plan" if journal.holds == HOLDS else "other files of rsegen"
        raise OutputError(f"{folder}: has {has}; give another folder{', or force=True' * (journal.holds == HOLDS)}")
    with read_errors(folder):
        for name in (*REPORT_FILES, *track_names(plan)):
            is_intact(folder, name, journal)
    with open_store(folder) as store:
        store.journal.begin(HOLDS, of)
        yield store


def _robot_files(plan: ExperimentPlan) -> dict[str, Json]:
    """Return the checksums of the robots' files: outcomes of a robot that was changed are not those of the plan."""
    files = [with_arguments(row.robot)[0] for row in plan.rows if is_robot_file(row.robot)]
    checksums = {file: checksum.sha256 for file in files if (checksum := checksum_of(Path(file)))}
    return {"robot_files": checksums} if checksums else {}


def in_simulators(plan: ExperimentPlan, simulators: Sequence[str] | None) -> ExperimentPlan:
    """Return the plan with a row for each of these simulators, by default the newest that is installed."""
    if simulators is not None:
        return plan.in_simulators(list(dict.fromkeys(simulators)))
    if all(row.simulator for row in plan.rows):
        return plan
    return plan.in_simulators([choose_installation("both", None).simulator.name])


def load_summary(file: Path) -> tuple[ExperimentPlan, Results, dict[str, str], str]:
    """Return the plan, the outcomes, the machine and the command of a summary.json that `experiment` wrote.

    FileError if it is damaged.
    """
    content = recipe_file.content(file)
    try:
        plan = read_plan(file.stem, content["plan"])  # type: ignore[index]  # a TypeError if it is no mapping
        results = {
            read_cell({key: cell[key] for key in ("row", "size", "pace")}, len(plan.rows)): [
                read_outcome(outcome) for outcome in cell["outcomes"]
            ]
            for cell in content["cells"]  # type: ignore[index]
        }
        machine = {str(name): str(value) for name, value in content["machine"].items()}  # type: ignore[index]
        command = _LINE.check("command", content["command"])  # type: ignore[index]
    except ParameterError as error:
        raise error.of(str(file)) from None
    except (AttributeError, KeyError, TypeError) as error:
        raise FileError(f"{file}: not the summary of an experiment: {error}") from None
    return plan, results, machine, command


def _command(plan: str | os.PathLike[str] | ExperimentPlan, folder: Path, simulators: Sequence[str] | None) -> str:
    """Return the command line that does the same; for a plan made in Python the call."""
    if isinstance(plan, ExperimentPlan):
        return "rsegen.experiment(plan, output" + (f", simulator={list(simulators)!r})" if simulators else ")")
    flags = ["--simulator", ",".join(simulators)] if simulators else []
    return shlex.join(["rsegen", "experiment", os.fspath(plan), *flags, "-o", os.fspath(folder)])


def _files(result: ExperimentResult) -> dict[str, bytes]:
    plan, results = result.plan, result.results
    cells = [
        {**asdict(cell), "outcomes": [asdict(outcome) for outcome in results[cell]]}
        for cell in plan.cells
        if cell in results
    ]
    summary = {"command": result.command, "machine": result.machine, "plan": asdict(plan), "cells": cells}
    return {
        "table.md": result.table.encode(),
        "trials.csv": trials_csv(plan, results).encode(),
        "summary.json": json.dumps(summary, indent=2).encode() + b"\n",
        "plot.png": plot(plan, results),
    }
