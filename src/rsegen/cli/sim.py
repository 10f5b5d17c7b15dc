"""rsegen sim: the supported simulators, and which of them are installed."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping

from rsegen.cli.flags import Subparsers
from rsegen.simulation.simulators import SIMULATORS, Installation, Simulator


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "sim",
        description="List the simulators in which rsegen can open worlds: version and path, or how to install them.",
    )
    command.add_argument("--json", action="store_true", help="print it as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print them."""
    found = {simulator: simulator.installation() for simulator in SIMULATORS.values()}
    if arguments.json:
        print(json.dumps([_summary(simulator, here) for simulator, here in found.items()], indent=2))
    else:
        print("\n".join(_report(found)))


def _summary(simulator: Simulator, here: Installation | None) -> dict[str, object]:
    there = {name: str(path) for name, path in here.commands.items()} if here else {}
    return {
        "name": simulator.name,
        "title": simulator.title,
        "version": here.version if here else None,
        "commands": there,
        "how_to_get": list(simulator.how_to_install),
    }


def _report(found: Mapping[Simulator, Installation | None]) -> Iterator[str]:
    for simulator, here in found.items():
        yield f"{simulator.name:<9}{simulator.title} {here.version if here else 'is not installed'}"
        rows = [f"{name}: {path}" for name, path in here.commands.items()] if here else simulator.how_to_install
        yield from (f"{'':<9}  {row}" for row in rows)
