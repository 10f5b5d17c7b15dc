"""`rsegen.experiment`: the trials of a plan run one by one, logged as they end, and reported in tables and a plot."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rsegen.errors import FileError, OutputError, ParameterError
from rsegen.io import recipe_file
from rsegen.io.contents import refuse_link, refuse_loss_of_files
from rsegen.io.record import Record, recorded
from rsegen.io.writer import refuse_not_a_folder, write_files
from rsegen.params.sorts import Text
from rsegen.simulation.experiment.frames import refuse_without_frames
from rsegen.simulation.experiment.machine import description
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, load_plan, read_plan
from rsegen.simulation.experiment.plot import plot
from rsegen.simulation.experiment.report import report_page, trials_csv
from rsegen.simulation.experiment.results import Results, ResultsLog, is_results_log, read_cell, read_outcome
from rsegen.simulation.experiment.tracks import refuse_loss_of_tracks, remove_tracks, write_tracks
from rsegen.simulation.experiment.trial import refuse_crowded, run_trial
from rsegen.simulation.simulators.launching import choose_installation

RESULTS_FILE = "results.jsonl"
_LINE = Text(r".{1,4096}", "a line of 1..4096 letters")

REPORT_FILES = ("table.md", "trials.csv", "summary.json", "plot.png")


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentResult:
    """What `rsegen.experiment` gives: the plan, every cell's outcomes, the machine, and the folder of the files.

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


def experiment(
    plan: str | os.PathLike[str] | ExperimentPlan,
    output: str | Path,
    *,
    simulator: str | Sequence[str] | None = None,
    force: bool = False,
    progress: Callable[[int, Cell], None] = lambda *_: None,
    watch: Callable[[], None] = lambda: None,
) -> ExperimentResult:
    """Measure what maps cost a simulator while robots drive on them, and write tables and a plot into a folder.

    plan: the name of an included plan, a YAML file like these, or a Plan; output: the folder; if it has outcomes of
    this plan, only the missing trials are run; `force` deletes them first, and nothing else. simulator: `sim`,
    `classic`, or both, which are compared; by default the newest that is installed. `progress` is called with the
    number of trials that are done and the next cell, `watch` several times per second during a trial; what they raise
    stops the experiment, and the same call continues it. UserError, before the first trial, if the plan is wrong, a
    simulator is not installed, or the folder has other files of these names.
    """
    command, folder = _command(plan, output, simulator), Path(output)
    plan = plan if isinstance(plan, ExperimentPlan) else load_plan(os.fspath(plan))
    plan = in_simulators(plan, simulator)
    names = dict.fromkeys(str(row.simulator) for row in plan.rows)
    installed = {name: choose_installation("both", name) for name in names}
    refuse_without_frames(plan, installed)
    refuse_crowded(plan)
    _refuse_loss(plan, folder)
    if force:
        _remove(folder)
    log = ResultsLog(path=folder / RESULTS_FILE)
    log.begin(asdict(plan))
    done = {(cell, repeat) for cell, repeat, _ in log.entries()}
    machine = {"simulator": ", ".join(map(str, installed.values())), **description()}
    for number, (cell, repeat) in enumerate(plan.order()):
        progress(number, cell)
        if (cell, repeat) not in done:
            trial = run_trial(plan, cell, repeat, installed[str(plan.rows[cell.row].simulator)], watch)
            write_tracks(plan, folder, cell, repeat, trial)
            log.add(cell, repeat, trial.outcome)
    found = ExperimentResult(plan=plan, results=log.results(), machine=machine, folder=folder, command=command)
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


def load_summary(file: Path) -> tuple[ExperimentPlan, Results, dict[str, str], str]:
    """The plan, the outcomes, the machine and the command of a summary.json that `experiment` wrote.

    FileError if it is damaged.
    """
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
        command = _LINE.check("command", found["command"])  # type: ignore[index]
    except ParameterError as error:
        raise error.of(str(file)) from None
    except (AttributeError, KeyError, TypeError) as error:
        raise FileError(f"{file}: not the summary of an experiment: {error}") from None
    return plan, results, machine, command


def _command(plan: str | os.PathLike[str] | ExperimentPlan, output: str | Path, simulator: object) -> str:
    """The command line that does the same; for a plan made in Python the call."""
    names = simulator if isinstance(simulator, str) or not isinstance(simulator, Sequence) else ",".join(simulator)
    if isinstance(plan, ExperimentPlan):
        return "rsegen.experiment(plan, output" + (f", simulator={names!r})" if names else ")")
    flags = ["--simulator", str(names)] if names else []
    return shlex.join(["rsegen", "experiment", os.fspath(plan), *flags, "-o", os.fspath(output)])


def _refuse_loss(plan: ExperimentPlan, folder: Path) -> None:
    """Raise an OutputError, before any trial, if a file of an experiment would replace one that is not rsegen's."""
    refuse_not_a_folder(folder)
    refuse_loss_of_files(folder, REPORT_FILES)
    refuse_loss_of_tracks(plan, folder)
    refuse_link(folder / RESULTS_FILE)
    if os.path.lexists(folder / RESULTS_FILE) and not is_results_log(folder / RESULTS_FILE):
        raise OutputError(f"{folder / RESULTS_FILE}: not the results log of an experiment; give another folder")


def _remove(folder: Path) -> None:
    """Remove the files of an experiment, which are rsegen's own; an OutputError if somebody has changed a track."""
    remove_tracks(folder)
    for name in (*REPORT_FILES, RESULTS_FILE):
        (folder / name).unlink(missing_ok=True)


def _files(found: ExperimentResult) -> dict[str, bytes]:
    plan, results = found.plan, found.results
    cells = [
        {**asdict(cell), "outcomes": [asdict(one) for one in results[cell]]} for cell in plan.cells if cell in results
    ]
    summary = {"command": found.command, "machine": found.machine, "plan": asdict(plan), "cells": cells}
    return {
        "table.md": found.table.encode(),
        "trials.csv": trials_csv(plan, results).encode(),
        "summary.json": json.dumps(summary, indent=2).encode() + b"\n",
        "plot.png": plot(plan, results),
    }
