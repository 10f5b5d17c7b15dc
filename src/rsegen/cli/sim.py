"""rsegen sim: the supported simulators, and which of them are installed."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.errors import RsegenError, line_of

if TYPE_CHECKING:
    from rsegen.simulation.simulators import Installation, Simulator


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "List the simulators in which rsegen can open worlds: version and path, or how to install them."
    add_command(commands, "sim", text=text)


def run(arguments: argparse.Namespace) -> Report:
    """Look for them."""
    found = found_simulators()
    return Report(lines=_report(found), content=found)


def found_simulators() -> list[dict[str, Any]]:
    """Ask every simulator at the same time whether it is installed; return what is known of each, for JSON."""
    from rsegen.simulation.simulators import SIMULATORS

    with ThreadPoolExecutor() as pool:
        return list(pool.map(_found, SIMULATORS.values()))


def _found(simulator: Simulator) -> dict[str, Any]:
    """A plug-in's simulator may raise anything, and one that is installed may not answer."""
    here: Installation | None = None
    problem = ""
    try:
        here = simulator.installation()
    except Exception as error:  # a report about a machine in disorder is wanted most
        problem = line_of(str(error) if isinstance(error, RsegenError) else f"{type(error).__name__}: {error}")
    return {
        "name": simulator.name,
        "title": simulator.title,
        "version": here.version if here else None,
        "commands": {name: str(path) for name, path in here.commands.items()} if here else {},
        "problem": problem,
        "how_to_get": list(simulator.how_to_install),
    }


def _report(found: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for each in found:
        yield f"{each['name']:<9}{each['title']} {each['version'] or each['problem'] or 'is not installed'}"
        rows = [f"{name}: {path}" for name, path in each["commands"].items()] or each["how_to_get"]
        yield from (f"{'':<9}  {row}" for row in rows if not each["problem"])
