"""rsegen experiment: the cost of maps for a simulator, measured as in the paper."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rsegen.cli.bar import watched
from rsegen.cli.flags import Subparsers, add_force_flag
from rsegen.cli.simulation_flags import flags_in_errors, simulator_names
from rsegen.cli.stop import how_to_go_on
from rsegen.simulation.experiment.plan import PLANS, Cell, ExperimentPlan, load_plan
from rsegen.simulation.experiment.run import experiment, in_simulators
from rsegen.simulation.simulators import SIMULATORS


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "experiment",
        description="Repeat the paper's experiment in a Gazebo server: robots drive randomly over maps of several "
        "sizes. Writes real-time factor, CPU, memory, load time and how far the robots drove into DIR (table.md, "
        "trials.csv, summary.json, plot.png), and the trajectories of the robots into DIR/tracks.",
        epilog="To continue a stopped experiment, run the same command again.",
    )
    names = ", ".join(sorted(PLANS))
    command.add_argument("plan", metavar="PLAN", help=f"{names}, or a YAML file like these")
    command.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results")
    both = f"or both as {','.join(SIMULATORS)}, which are compared"
    text = f"{simulator_names()}, {both} (default: the newest that is installed)"
    command.add_argument("--simulator", metavar="NAME[,NAME]", help=text)
    add_force_flag(command, "results in DIR", ", once the new ones are complete")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Run all trials, and print the table."""
    names = arguments.simulator.split(",") if arguments.simulator is not None else None
    with flags_in_errors("simulator"):
        plan = in_simulators(load_plan(arguments.plan), names)
    with how_to_go_on(), _bar(plan) as progress:
        result = experiment(arguments.plan, arguments.output, simulator=names, force=arguments.force, progress=progress)
    print(result.table)


@contextmanager
def _bar(plan: ExperimentPlan) -> Iterator[Callable[[int, Cell], None]]:
    """A progress bar on a terminal, with the time that is left; otherwise a line per trial."""
    trials = len(plan.cells) * plan.repeats
    if not watched():
        yield lambda done, cell: print(f"{done + 1} of {trials}: {cell.name}", file=sys.stderr, flush=True)
        return
    from tqdm import tqdm

    with tqdm(total=trials, unit="trial") as bar:

        def progress(done: int, cell: Cell) -> None:
            bar.update(done - bar.n)
            bar.set_description(cell.name)

        yield progress
        bar.update(trials - bar.n)
