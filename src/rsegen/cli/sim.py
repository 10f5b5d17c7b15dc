"""rsegen sim: the supported simulators, and which of them are installed."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    content = [{**each.summary, "how_to_get": list(each.simulator.how_to_install)} for each in found]
    return Report(lines=_report(found), content=content)


@dataclass(frozen=True, kw_only=True, slots=True)
class FoundSimulator:
    """A simulator, its installation if there is one, and what went wrong when it was asked for its version."""

    simulator: Simulator
    here: Installation | None
    problem: str = ""

    @property
    def summary(self) -> dict[str, object]:
        """Return the figures of a simulation, for JSON."""
        return {
            "name": self.simulator.name,
            "title": self.simulator.title,
            "version": self.here.version if self.here else None,
            "commands": {name: str(path) for name, path in self.here.commands.items()} if self.here else {},
            "problem": self.problem,
        }


def found_simulators() -> list[FoundSimulator]:
    """Ask every simulator at the same time whether it is installed."""
    from rsegen.simulation.simulators import SIMULATORS

    with ThreadPoolExecutor() as pool:
        return list(pool.map(_found, SIMULATORS.values()))


def _found(simulator: Simulator) -> FoundSimulator:
    """A plug-in's simulator may raise anything, and one that is installed may not answer."""
    try:
        return FoundSimulator(simulator=simulator, here=simulator.installation())
    except Exception as error:  # a report about a machine in disorder is wanted most
        why = str(error) if isinstance(error, RsegenError) else f"{type(error).__name__}: {error}"
        return FoundSimulator(simulator=simulator, here=None, problem=line_of(why))


def _report(found: Iterable[FoundSimulator]) -> Iterator[str]:
    for each in found:
        here, problem = each.here, each.problem
        what = here.version if here else problem or "is not installed"
        yield f"{each.simulator.name:<9}{each.simulator.title} {what}"
        rows = [f"{name}: {path}" for name, path in here.commands.items()] if here else each.simulator.how_to_install
        yield from (f"{'':<9}  {row}" for row in rows if not problem)
