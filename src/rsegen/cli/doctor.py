"""rsegen doctor: what rsegen finds on this machine, for reports of what does not work."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rsegen.cli.report import Report, Subparsers, add_command

if TYPE_CHECKING:
    from rsegen.cli.environment import Environment, FoundExtra, FoundSimulator

_WIDTH = 12


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the versions, simulators, extras and OpenGL that rsegen finds here, what is missing, and what it is "
    epilog = "Starts no simulator and changes nothing. Add its output to bug reports."
    command = add_command(commands, "doctor", text=f"{text}needed for.", epilog=epilog)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> Report:
    """Look."""
    from rsegen.cli.environment import environment

    here = environment()
    return Report(lines=_report(here), content=_summary(here))


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
