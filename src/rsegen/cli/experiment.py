"""rsegen experiment: the cost of maps for a simulator, measured as in the paper."""

from __future__ import annotations

import argparse
import json

from rsegen.cli.edge import how_to_go_on
from rsegen.cli.report import Report, Subparsers, add_command, call, trials_bar
from rsegen.commands.experiment import experiment
from rsegen.params.command import add_flags, flags_in_errors, given


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = "The folder gets table.md, trials.csv, summary.json, plot.png, and the trajectories in tracks. "
    command = add_command(
        commands,
        "experiment",
        experiment,
        epilog=f"{epilog}The same command continues a stopped experiment.",
    )
    names = "quick, driven, paper, burgers, frames, representations"
    command.add_argument("plan", metavar="PLAN", help=f"{names}, or a YAML file like these")
    add_flags(command.add_argument_group("output"), experiment)


def run(arguments: argparse.Namespace) -> Report:
    """Run all trials, and give the table."""
    from rsegen.simulation.experiment.plan import load_plan
    from rsegen.simulation.experiment.run import in_simulators

    with flags_in_errors(experiment):
        plan = in_simulators(load_plan(arguments.plan), given(experiment, arguments).get("simulator"))
    with how_to_go_on(), trials_bar(plan) as progress:
        result = call(experiment, arguments, arguments.plan, progress=progress)
    return Report(lines=[result.table], content=lambda: json.loads((result.folder / "summary.json").read_text("utf-8")))
