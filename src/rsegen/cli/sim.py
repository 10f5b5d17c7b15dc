"""rsegen sim: the supported simulators, and which of them are installed."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rsegen.cli.report import Report, Subparsers, add_command

if TYPE_CHECKING:
    from rsegen.simulation.simulators import Installation, Simulator


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "List the simulators in which rsegen can open worlds: version and path, or how to install them."
    command = add_command(commands, "sim", text=text)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> Report:
    """Look for them."""
    from rsegen.simulation.simulators import SIMULATORS

    installed = {simulator: simulator.installation() for simulator in SIMULATORS.values()}
    content = [_summary(simulator, here) for simulator, here in installed.items()]
    return Report(lines=_report(installed), content=content)


def _summary(simulator: Simulator, here: Installation | None) -> dict[str, object]:
    there = {name: str(path) for name, path in here.commands.items()} if here else {}
    return {
        "name": simulator.name,
        "title": simulator.title,
        "version": here.version if here else None,
        "commands": there,
        "how_to_get": list(simulator.how_to_install),
    }


def _report(installed: Mapping[Simulator, Installation | None]) -> Iterator[str]:
    for simulator, here in installed.items():
        yield f"{simulator.name:<9}{simulator.title} {here.version if here else 'is not installed'}"
        rows = [f"{name}: {path}" for name, path in here.commands.items()] if here else simulator.how_to_install
        yield from (f"{'':<9}  {row}" for row in rows)
