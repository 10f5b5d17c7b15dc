"""The command `rsegen experiment`."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.parameters import Force, OutputFolder
from rsegen.cli.parser import Parser
from rsegen.cli.report import (
    ProgressLines,
    Report,
    call,
    progress_is_wanted,
    progress_shown,
)
from rsegen.params.command import Shell, add_flags, command, flags_in_errors, given
from rsegen.params.sorts import ListOf, Reference
from rsegen.simulators.parameters import Timeout, ignore, known_simulators

if TYPE_CHECKING:
    from rsegen.experiments.plan import Cell, ExperimentPlan
    from rsegen.experiments.run import ExperimentResult


@command
def experiment(  # noqa: PLR0913  # each is a flag
    plan: str | os.PathLike[str] | ExperimentPlan,
    output: OutputFolder,
    *,
    simulator: Annotated[
        str | Sequence[str] | None,
        ListOf(
            Reference("sim, classic or mujoco"),
            help="Gazebo Sim (sim), Gazebo Classic (classic), MuJoCo (mujoco), or several as classic,mujoco, which are "
            "compared",
        ),
        Shell(metavar="NAME[,NAME]", default="the newest Gazebo that is installed", known=known_simulators),
    ] = None,
    force: Force = False,
    timeout: Timeout = 20.0,
    progress: Callable[[int, Cell], None] | None = None,
    watch: Callable[[], None] | None = None,
) -> ExperimentResult:
    """Measure what maps cost a simulator while robots drive on them, and write tables and a plot into a folder.

    If the folder has outcomes of this plan, only the missing trials are run; `force` begins anew, and earlier outcomes
    stay until the new ones are complete. An exception in `progress` or `watch` stops the experiment; the same call
    continues it.

    Parameters
    ----------
    plan : str, path or ExperimentPlan
        The name of an included plan, a YAML file like these, or a plan.
    progress : callable, optional
        Called with the number of finished trials, and the next cell.
    watch : callable, optional
        Called several times per second during a trial.

    Returns
    -------
    ExperimentResult
        Outcomes of every cell.

    Raises
    ------
    UserError
        Before the first trial, if the plan is wrong, a simulator is not installed, or the folder has other files of
        these names.
    """
    from rsegen.experiments.run import run_trials

    return run_trials(
        plan,
        Path(output),
        simulator,
        force=force,
        timeout=timeout,
        progress=progress or ignore,
        watch=watch or ignore,
    )


def add_experiment(command: Parser) -> None:
    """Add the flags of `rsegen experiment`."""
    epilog = (
        "The folder gets table.md, trials.csv, summary.json, plot.png, and the trajectories in tracks. "
        "The same command continues a stopped experiment."
    )
    command.explain(experiment.__doc__, epilog)
    names = "quick, driven, paper, burgers, frames, representations"
    command.add_argument("plan", metavar="PLAN", help=f"{names}, or a YAML file like these")
    add_flags(command.group("output"), experiment)


def run_experiment(arguments: argparse.Namespace) -> Report:
    """Run all trials, and report the table."""
    from rsegen.experiments.plan import load_plan
    from rsegen.experiments.run import in_simulators

    with flags_in_errors(experiment):
        plan = in_simulators(load_plan(arguments.plan), given(experiment, arguments).get("simulator"))
    with how_to_go_on(), trials_bar(plan) as progress:
        result = call(experiment, arguments, arguments.plan, progress=progress)
    return Report(lines=[result.table], content=lambda: json.loads((result.folder / "summary.json").read_text("utf-8")))


@contextmanager
def trials_bar(plan: ExperimentPlan) -> Iterator[Callable[[int, Cell], None]]:
    """Yield a function that shows the progress of trials: a bar, or a line for each if it is not a terminal."""
    trials = len(plan.cells) * plan.repeats
    with progress_shown(trials, "trial") as bar:

        def progress(done: int, cell: Cell) -> None:
            if isinstance(bar, ProgressLines) and not bar.is_shown and progress_is_wanted():
                print(f"{done + 1} of {trials}: {cell.name}", file=sys.stderr, flush=True)
            bar.update(done - bar.n)
            bar.set_description(cell.name)

        yield progress
        bar.update(trials - bar.n)
