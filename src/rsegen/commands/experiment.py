"""`rsegen experiment`: what maps cost a simulator while robots drive on them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.commands.parameters import Force, OutputFolder, Timeout
from rsegen.params.command import Shell, command
from rsegen.params.sorts import ListOf, Reference

if TYPE_CHECKING:
    from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
    from rsegen.simulation.experiment.run import ExperimentResult


@command
def experiment(  # noqa: PLR0913  # each is a flag
    plan: str | os.PathLike[str] | ExperimentPlan,
    output: OutputFolder,
    *,
    simulator: Annotated[
        str | Sequence[str] | None,
        ListOf(
            Reference("sim or classic"),
            help="Gazebo Sim (sim), Gazebo Classic (classic), or both as sim,classic, which are compared",
        ),
        Shell(metavar="NAME[,NAME]", default="the newest that is installed"),
    ] = None,
    force: Force = False,
    timeout: Timeout = 20.0,
    progress: Callable[[int, Cell], None] = lambda *_: None,
    watch: Callable[[], None] = lambda: None,
) -> ExperimentResult:
    """Measure what maps cost a simulator while robots drive on them, and write tables and a plot into a folder.

    plan: the name of an included plan, a YAML file like these, or an ExperimentPlan. If the folder has outcomes of this
    plan, only the missing trials are run; `force` begins anew, and what is there stays until the new is complete.
    progress: called with the number of trials that are done and the next cell; watch: several times per second during a
    trial; what they raise stops the experiment, and the same call continues it. UserError, before the first trial, if
    the plan is wrong, a simulator is not installed, or the folder has other files of these names.
    """
    from rsegen.simulation.experiment.run import run_experiment

    return run_experiment(plan, Path(output), simulator, force=force, timeout=timeout, progress=progress, watch=watch)
