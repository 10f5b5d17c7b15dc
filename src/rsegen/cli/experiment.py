"""rsegen experiment: the paper's tables, on any machine."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rsegen.cli.bar import watched
from rsegen.cli.flags import Subparsers
from rsegen.simulation.experiment.plan import PLANS, Cell, Plan, load_plan
from rsegen.simulation.experiment.run import RESULTS_FILE, experiment
from rsegen.simulation.simulators.launching import choose_installation


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "experiment",
        help="measure what maps cost a simulator with robots in it",
        description="Repeat the paper's experiment in a Gazebo server: robots wander over maps of several sizes; "
        "real-time factor, CPU, memory and load time go into DIR as table.md, trials.csv, summary.json and plot.png.",
        epilog="Stopped, it goes on where it was when the same command is given again.",
    )
    names = ", ".join(sorted(PLANS))
    command.add_argument("plan", metavar="PLAN", help=f"{names}, or a YAML file like theirs")
    command.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for what comes of it")
    command.add_argument("--force", action="store_true", help="begin anew, where DIR has outcomes already")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Try everything, and print the table."""
    plan, here = load_plan(arguments.plan), choose_installation("both", "classic")
    if arguments.force and (arguments.output / RESULTS_FILE).is_file():
        shutil.rmtree(arguments.output)
    with _bar(plan) as progress:
        experiment(plan, here, arguments.output, progress)
    print((arguments.output / "table.md").read_text("utf-8"))


@contextmanager
def _bar(plan: Plan) -> Iterator[Callable[[int, Cell], None]]:
    """A progress bar on a terminal, with the time that is left; else a line for every trial."""
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
