"""`rsegen.experiment`: the trials of a plan run one by one, logged as they end, and reported in tables and a plot.

    tracks/row1-80-free-0.csv   poses of robots in the first trial of the first row, on 80 x 80 blocks, at pace `free`
    tracks/row1-80-free.png     a picture of the trajectories in the last trial of this cell, on the plan of its map

Outcomes are lines of the journal in the experiment's folder, from which a stopped experiment continues. They may come
from anybody: a line that is not an outcome of this plan is refused, with its place.
"""

from __future__ import annotations

import json
import os
import platform
import re
import shlex
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from rsegen.driving.drive_metrics import COLUMNS
from rsegen.driving.plots import trajectory_plot
from rsegen.errors import (
    FileError,
    Incomplete,
    NoSpot,
    ParameterError,
    Stopped,
    UserError,
    inside,
    refuse_unknown,
    shown,
)
from rsegen.experiments.plan import PACES, Cell, ExperimentPlan, load_plan, read_plan
from rsegen.experiments.report import plot, report_page, trials_csv
from rsegen.experiments.trial import (
    Outcome,
    Results,
    Trial,
    refuse_undrivable,
    run_trial,
)
from rsegen.experiments.trial_server import TrialSimulator, refuse_without_frames
from rsegen.input_files import JOURNAL, checksum_of
from rsegen.params.sorts import Choice, Flag, Float, Integer, Json, Parameter, Text
from rsegen.recipe import recipe_file
from rsegen.recipe.codec import plugin_identities
from rsegen.robots.base import ROBOTS
from rsegen.robots.files.sdf_file import is_robot_file
from rsegen.robots.files.xacro_files import with_arguments
from rsegen.simulators.embedded import embedded_simulator
from rsegen.simulators.server import choose_installation
from rsegen.writing.journal import Journal
from rsegen.writing.store import Store, continued

HOLDS = "experiment"
_LINE = Text(r".{0,4096}", "a line of at most 4096 letters")
"""The command line in a summary, which may come from anybody; 4096 is the longest path of Linux."""

REPORT_FILES = ("table.md", "trials.csv", "summary.json", "plot.png")


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentResult:
    """The result of `rsegen.experiment`.

    Attributes
    ----------
    plan : ExperimentPlan
        The plan of the trials.
    results : Results
        The outcomes of every cell.
    machine : dict of str
        The machine that they were measured on.
    folder : Path
        Folder of the files.
    command : str
        The command line, or the call in Python, that makes the same experiment.
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


def run_trials(  # noqa: PLR0913  # as `rsegen.experiment`
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
    command, source = _command(plan, folder, simulators), "" if isinstance(plan, ExperimentPlan) else os.fspath(plan)
    written = plan if isinstance(plan, ExperimentPlan) else load_plan(source)
    plan = in_simulators(written, simulators)
    names = dict.fromkeys(str(row.simulator) for row in plan.rows)
    installed = {name: _chosen(name, timeout) for name in names}
    with _errors_of(source, ParameterError):
        refuse_without_frames(plan, installed)
        refuse_undrivable(written)  # whose rows have the numbers that they have in the file
    machine = {"simulator": ", ".join(map(str, installed.values())), **_description()}
    with _opened(plan, folder, force=force) as store:
        done = read_entries(store.journal.content, folder, len(plan.rows))
        store.announce_files([*REPORT_FILES, *track_names(plan)], kept=track_names(plan, done))
        earlier = len(done)
        for cell, repeat in plan.order():
            if (cell, repeat) in done:
                continue
            progress(len(done), cell)
            # First the tracks of a trial are written, then its outcome: a trial in the journal has its files.
            try:
                with _errors_of(source, NoSpot):
                    trial = run_trial(plan, cell, repeat, installed[str(plan.rows[cell.row].simulator)], watch)
                if files := track_files(plan, cell, repeat, trial):
                    store.put(files, force=True, holds=HOLDS)
                store.note(journal_entry(cell, repeat, trial.outcome))
                done[cell, repeat] = trial.outcome
            except (KeyboardInterrupt, UserError) as error:
                complete = f"{len(done)} of {len(plan.cells) * plan.repeats} trials are complete in {folder}"
                raise _ended(error, complete, done, earlier) from None
        result = ExperimentResult(plan=plan, results=results_of(done), machine=machine, folder=folder, command=command)
        store.put({name: [content] for name, content in _files(result).items()}, force=True, holds=HOLDS)
    return result


def _ended(error: BaseException, complete: str, done: Entries, earlier: int) -> BaseException:
    """Return the error that ended the trials, with how many are complete; earlier: trials done before this call.

    A larger map may have no room for the robots; exit code 2, of an error as it is, means that nothing was changed.
    """
    if isinstance(error, KeyboardInterrupt):
        return Stopped(complete, changed=bool(done))
    return Incomplete(f"{error}; {complete}") if len(done) > earlier else error


@contextmanager
def _errors_of(source: str, sort: type[ParameterError]) -> Iterator[None]:
    """Add the source of a plan, a file or name, to errors of a sort raised inside; a plan made in Python has none.

    Only to errors of that sort, as a wrong environment variable, for example, is not a value of the plan.
    """
    try:
        yield
    except sort as error:
        raise error.of(source) if source else error from None


def _chosen(name: str, timeout: float) -> TrialSimulator:
    """Return an installed simulator by its name; NoSimulator if it is not installed."""
    embedded = embedded_simulator(name)
    if embedded is None:
        return choose_installation("both", name, timeout)
    embedded.refuse_missing()
    return embedded


def _description() -> dict[str, str]:
    """Return the processor, cores, memory, system and load of this computer."""
    import psutil

    table = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:\s*(.+)", table.read_text()) if table.exists() else None
    return {
        "processor": named[1] if named else platform.processor() or platform.machine(),
        "cores": str(os.cpu_count()),
        "memory": f"{psutil.virtual_memory().total / 2**30:.1f} GiB",
        "system": platform.platform(),
        "load before": " ".join(f"{load:.1f}" for load in os.getloadavg()) if hasattr(os, "getloadavg") else "?",
    }


def _opened(plan: ExperimentPlan, folder: Path, *, force: bool) -> AbstractContextManager[Store]:
    """Open the folder of new or begun results, or with force of their replacement; OutputError if it has others."""
    of: Json = json.loads(json.dumps({**asdict(plan), **_robot_files(plan), **_plugins(plan)}))
    problem = (
        "the outcomes of another plan, or of a robot or plug-in that was changed; use another folder, or force=True"
    )
    return continued(folder, HOLDS, of, (*REPORT_FILES, *track_names(plan)), force=force, other=problem)


def _robot_files(plan: ExperimentPlan) -> dict[str, Json]:
    """Return the checksums of the robots' files: outcomes of a changed robot do not belong to the plan."""
    files = [with_arguments(row.robot)[0] for row in plan.rows if is_robot_file(row.robot)]
    checksums = {file: checksum.sha256 for file in files if (checksum := checksum_of(Path(file)))}
    return {"robot_files": checksums} if checksums else {}


def _plugins(plan: ExperimentPlan) -> dict[str, Json]:
    """Return the plug-ins of robots and obstacles: outcomes of another version do not belong to the plan either."""
    maps = (row.map_of(max(row.sizes), plan.seed) for row in plan.rows)
    return plugin_identities(maps, (ROBOTS.source(row.robot) for row in plan.rows))


def in_simulators(plan: ExperimentPlan, simulators: Sequence[str] | None) -> ExperimentPlan:
    """Return the plan with a row for each of these simulators, by default the newest installed Gazebo."""
    if simulators is not None:
        return plan.in_simulators(list(dict.fromkeys(simulators)))
    if all(row.simulator for row in plan.rows):
        return plan
    return plan.in_simulators([choose_installation("both", None).simulator.name])


def load_summary(file: Path) -> tuple[ExperimentPlan, Results, dict[str, str], str]:
    """Return the plan, the outcomes, the machine and the command of a summary.json that `experiment` wrote.

    FileError if it is damaged.
    """
    content = recipe_file.recipe_content(file)
    try:
        plan = read_plan(file.stem, content["plan"])  # type: ignore[index]  # a TypeError if it is no mapping
        # The file may have been edited: its plan, cells and outcomes pass the same checks as when they are made.
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
    """Return the command line that makes the same experiment, or the call for a plan made in Python."""
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


# Outcomes and tracks in the folder of an experiment.


_OUTCOME: Mapping[str, Parameter] = {
    **{field.name: Float() for field in fields(Outcome)},
    "starved": Flag(),
    "attempts": Integer(1),
}
_OPTIONAL = frozenset(_OUTCOME) - {"load", "memory", "speed"}
"""Figures that a trial may lack: some are of certain paces, others of robots that are in the record."""

Entries = dict[tuple[Cell, int], Outcome]
"""Outcomes by their cell and the number of the repeat."""


def journal_entry(cell: Cell, repeat: int, outcome: Outcome) -> dict[str, Json]:
    """Return the journal's entry of an outcome."""
    return {"cell": asdict(cell), "repeat": repeat, "outcome": asdict(outcome)}


def read_entries(journal: Journal | None, folder: Path, rows: int) -> Entries:
    """Return the outcomes in the journal of a folder; FileError for the first entry that was changed."""
    entries = {}
    for line, result in enumerate(journal.results if journal else (), 1):
        try:
            cell, outcome = read_cell(result.get("cell"), rows), read_outcome(result.get("outcome"))
            entries[cell, Integer(0).check("repeat", result.get("repeat"))] = outcome
        except ParameterError as error:  # an experiment has some hundred
            advice = "delete its line, or use another folder, or force=True"
            raise FileError(f"{folder / JOURNAL}: result {line}: {error}; {advice}") from None
    return entries


def results_of(entries: Entries) -> Results:
    """Return the outcomes of every cell, in the order of its repeats, also if a line of the journal was deleted."""
    results: dict[Cell, list[Outcome]] = {}
    for (cell, _), outcome in sorted(entries.items(), key=lambda entry: entry[0][1]):
        results.setdefault(cell, []).append(outcome)
    return results


def read_cell(content: object, rows: int) -> Cell:
    """Return the cell in a file, of a plan with this number of rows; a ParameterError if it is not in the plan."""
    sorts = {"row": Integer(0, rows - 1), "size": Integer(0), "pace": Choice(PACES)}
    return Cell(**_checked("cell", content, sorts))


def read_outcome(content: object) -> Outcome:
    """Return the outcome in a file; a ParameterError if a value is not a number."""
    return Outcome(**_checked("outcome", content, _OUTCOME, _OPTIONAL))


def _checked(
    where: str, content: object, sorts: Mapping[str, Parameter], optional: Collection[str] = ()
) -> dict[str, Any]:
    """Return the values of a mapping by their sorts; a ParameterError for one that is missing, too many, or wrong."""
    if not isinstance(content, Mapping):
        raise ParameterError(where, f"{shown(content)} is not a mapping with {', '.join(sorts)}")
    with inside(where):
        refuse_unknown("key", content, sorts)
        values = ((name, sort, content.get(name)) for name, sort in sorts.items())
        return {
            name: None if value is None and name in optional else sort.check(name, value)
            for name, sort, value in values
        }


def track_files(plan: ExperimentPlan, cell: Cell, repeat: int, trial: Trial) -> dict[str, list[bytes]]:
    """Return the file of the trajectories of a trial, and a picture of them if it is the last one of its cell."""
    if not trial.trajectories:
        return {}
    file, *picture = track_names(plan, [(cell, repeat)])
    rows = [",".join(["robot", *COLUMNS]) + "\n"]
    for name, trajectory in trial.trajectories.items():
        rows += [f"{name},{row}" for row in [*trajectory.csv()][1:]]
    files = {file: [row.encode() for row in rows]}
    return files | {name: [trajectory_plot(trial.scene, trial.trajectories)] for name in picture}


def track_names(plan: ExperimentPlan, trials: Collection[tuple[Cell, int]] | None = None) -> Iterator[str]:
    """Yield the names of all files with tracks of these trials, by default of all trials of a plan."""
    for cell, repeat in plan.order() if trials is None else trials:
        name = f"tracks/row{cell.row + 1}-{cell.size}-{cell.pace}"
        yield f"{name}-{repeat}.csv"
        if repeat == plan.repeats - 1:
            yield f"{name}.png"
