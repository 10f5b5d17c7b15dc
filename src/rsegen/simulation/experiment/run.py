"""`rsegen.experiment`: the trials of a plan run one by one, logged as they end, and reported in tables and a plot."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rsegen.errors import FileError, OutputError, ParameterError
from rsegen.io import recipe_file
from rsegen.io.contents import refuse_link, refuse_loss_of_files
from rsegen.io.record import Record, recorded
from rsegen.io.writer import refuse_not_a_folder, write_files
from rsegen.simulation.experiment.machine import description
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, load_plan, read_plan
from rsegen.simulation.experiment.report import plot, report_page, trials_csv
from rsegen.simulation.experiment.results import Results, ResultsLog, is_results_log, read_cell, read_outcome
from rsegen.simulation.experiment.trial import run_trial
from rsegen.simulation.simulators.launching import choose_installation

RESULTS_FILE = "results.jsonl"
REPORT_FILES = ("table.md", "trials.csv", "summary.json", "plot.png")


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentResult:
    """What `rsegen.experiment` gives: the plan, every cell's outcomes, the machine, and the folder of the files."""

    plan: ExperimentPlan
    results: Results
    machine: dict[str, str]
    folder: Path

    @property
    def table(self) -> str:
        """The content of table.md."""
        return report_page(self.plan, self.results, self.machine)


def experiment(
    plan: str | os.PathLike[str] | ExperimentPlan,
    output: str | Path,
    *,
    simulator: str | Sequence[str] | None = None,
    force: bool = False,
    progress: Callable[[int, Cell], None] = lambda *_: None,
) -> ExperimentResult:
    """Measure what maps cost a simulator while robots drive on them, and write tables and a plot into a folder.

    plan: the name of an included plan, a YAML file like these, or a Plan; output: the folder; if it has outcomes of
    this plan, only the missing trials are run; `force` deletes them first, and nothing else. simulator: `sim`,
    `classic`, or both, which are compared; by default the newest that is installed. `progress` is called with the
    number of trials that are done and the next cell. UserError, before the first trial, if the plan is wrong, a
    simulator is not installed, or the folder has other files of these names.
    """
    plan, folder = plan if isinstance(plan, ExperimentPlan) else load_plan(os.fspath(plan)), Path(output)
    plan = in_simulators(plan, simulator)
    names = dict.fromkeys(str(row.simulator) for row in plan.rows)
    installed = {name: choose_installation("both", name) for name in names}
    _refuse_loss(folder)
    if force:
        _remove(folder)
    log = ResultsLog(path=folder / RESULTS_FILE)
    log.begin(asdict(plan))
    done = {(cell, repeat) for cell, repeat, _ in log.entries()}
    machine = {"simulator": ", ".join(map(str, installed.values())), **description()}
    for number, (cell, repeat) in enumerate(plan.order()):
        progress(number, cell)
        if (cell, repeat) not in done:
            log.add(cell, repeat, run_trial(plan, cell, repeat, installed[str(plan.rows[cell.row].simulator)]))
    found = ExperimentResult(plan=plan, results=log.results(), machine=machine, folder=folder)
    files = {name: [content] for name, content in _files(found).items()}
    write_files(files, folder, record=recorded(folder) or Record(content="files", files={}))
    return found


def in_simulators(plan: ExperimentPlan, simulator: str | Sequence[str] | None) -> ExperimentPlan:
    """The plan with a row for each of these simulators, by default the newest that is installed."""
    if simulator is not None:
        return plan.in_simulators([simulator] if isinstance(simulator, str) else list(dict.fromkeys(simulator)))
    if all(row.simulator for row in plan.rows):
        return plan
    return plan.in_simulators([choose_installation("both", None).simulator.name])


def load_summary(file: Path) -> tuple[ExperimentPlan, Results, dict[str, str]]:
    """The plan, the outcomes and the machine of a summary.json that `experiment` wrote; FileError if it is damaged."""
    found = recipe_file.content(file)
    try:
        plan = read_plan(file.stem, found["plan"])  # type: ignore[index]  # a TypeError if it is no mapping
        results = {
            read_cell({key: cell[key] for key in ("row", "size", "pace")}, len(plan.rows)): [
                read_outcome(one) for one in cell["outcomes"]
            ]
            for cell in found["cells"]  # type: ignore[index]
        }
        machine = {str(name): str(value) for name, value in found["machine"].items()}  # type: ignore[index]
    except ParameterError as error:
        raise error.of(str(file)) from None
    except (AttributeError, KeyError, TypeError) as error:
        raise FileError(f"{file}: not the summary of an experiment: {error}") from None
    return plan, results, machine


def _refuse_loss(folder: Path) -> None:
    """Raise an OutputError, before any trial, if a file of an experiment would replace one that is not rsegen's."""
    refuse_not_a_folder(folder)
    refuse_loss_of_files(folder, REPORT_FILES)
    refuse_link(folder / RESULTS_FILE)
    if os.path.lexists(folder / RESULTS_FILE) and not is_results_log(folder / RESULTS_FILE):
        raise OutputError(f"{folder / RESULTS_FILE}: not the results log of an experiment; give another folder")


def _remove(folder: Path) -> None:
    """Remove the files of an experiment, which are rsegen's own."""
    for name in (*REPORT_FILES, RESULTS_FILE):
        (folder / name).unlink(missing_ok=True)


def _files(found: ExperimentResult) -> dict[str, bytes]:
    plan, results = found.plan, found.results
    cells = [
        {**asdict(cell), "outcomes": [asdict(one) for one in results[cell]]} for cell in plan.cells if cell in results
    ]
    summary = {"machine": found.machine, "plan": asdict(plan), "cells": cells}
    return {
        "table.md": found.table.encode(),
        "trials.csv": trials_csv(plan, results).encode(),
        "summary.json": json.dumps(summary, indent=2).encode() + b"\n",
        "plot.png": plot(plan, results),
    }
