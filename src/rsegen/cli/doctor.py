"""rsegen doctor: what rsegen finds on this machine, for reports of what does not work."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from rsegen.cli.environment import Environment, FoundExtra, FoundSimulator, environment
from rsegen.cli.flags import Subparsers

_WIDTH = 12


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    command = commands.add_parser(
        "doctor",
        description="Print the versions, simulators, extras and OpenGL that rsegen finds here, what is missing, and "
        "what it is needed for. Starts no simulator and changes nothing.",
        epilog="Add its output to bug reports.",
    )
    command.add_argument("--json", action="store_true", help="print it as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Look, and print it."""
    found = environment()
    print(json.dumps(_summary(found), indent=2) if arguments.json else "\n".join(_report(found)))


def _summary(found: Environment) -> dict[str, Any]:
    plain = {name: getattr(found, name) for name in ("rsegen", "python", "executable", "platform", "libraries")}
    simulators = [
        {
            "name": each.simulator.name,
            "title": each.simulator.title,
            "version": each.here.version if each.here else None,
            "commands": {name: str(path) for name, path in each.here.commands.items()} if each.here else {},
            "problem": each.problem,
        }
        for each in found.simulators
    ]
    extras = [
        {"name": each.extra.name, "for": each.extra.use, "missing": each.missing, "versions": each.versions}
        for each in found.extras
    ]
    missing = [{"what": what, "remedy": remedy} for what, remedy in found.missing()]
    opengl = {"version": found.opengl or None, "problem": found.opengl_problem}
    lists = {"simulators": simulators, "extras": extras, "plugins": found.plugins, "missing": missing}
    return {**plain, "opengl": opengl, **lists}


def _report(found: Environment) -> Iterator[str]:
    yield _row("rsegen", found.rsegen)
    yield _row("Python", f"{found.python}, {found.executable}")
    yield _row("platform", found.platform)
    yield _row("libraries", ", ".join(f"{name} {number or 'missing'}" for name, number in found.libraries.items()))
    yield _row("OpenGL", found.opengl or found.opengl_problem)
    yield from (_row("plug-in", plugin) for plugin in found.plugins)
    yield "\nSimulators"
    for simulator in found.simulators:
        yield from _simulator(simulator)
    yield "\nExtras"
    yield from map(_extra, found.extras)
    missing = list(found.missing())
    yield "\nMissing" if missing else "\nNothing is missing."
    for what, remedy in missing:
        yield f"  {what}\n    {remedy}"


def _simulator(found: FoundSimulator) -> Iterator[str]:
    if not found.here:
        yield f"  {found.simulator.title}: {found.problem or 'not installed'}"
        return
    yield f"  {found.here}"
    yield from (f"    {name}: {path}" for name, path in found.here.commands.items())


def _extra(found: FoundExtra) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in found.versions.items())
    state = f"missing: {', '.join(found.missing)}" if found.missing else versions or "installed"
    return f"  {found.extra.name:<{_WIDTH - 2}}{state} (for {found.extra.use})"


def _row(name: str, text: str) -> str:
    return f"{name:<{_WIDTH}}{text}"
