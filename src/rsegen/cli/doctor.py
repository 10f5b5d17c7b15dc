"""rsegen doctor: what rsegen finds on this machine, what is missing and for what; for reports of what does not work."""

from __future__ import annotations

import argparse
import platform
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from rsegen import __version__
from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.cli.sim import FoundSimulator, found_simulators
from rsegen.params.extras import EXTRAS, Extra, pip_install, requirements
from rsegen.params.registry import entry_points


@dataclass(frozen=True, kw_only=True, slots=True)
class FoundExtra:
    """An extra, its modules that are missing, and the versions of its packages that are installed."""

    extra: Extra
    missing: tuple[str, ...]
    versions: Mapping[str, str]


@dataclass(frozen=True, kw_only=True, slots=True)
class Environment:
    """Versions, simulators, extras and plug-ins that rsegen finds on this machine.

    libraries: versions of what rsegen always needs, None if missing; plugins: of installed packages, with versions.
    """

    rsegen: str
    python: str
    executable: str
    platform: str
    libraries: Mapping[str, str | None]
    simulators: tuple[FoundSimulator, ...]
    extras: tuple[FoundExtra, ...]
    plugins: tuple[str, ...]

    def missing(self) -> Iterator[tuple[str, str]]:
        """Yield what is missing, what it is needed for, and how to get it."""
        for name in (name for name, found in self.libraries.items() if found is None):
            yield f"{name}, which rsegen always needs", f"{sys.executable} -m pip install '{name}'"
        for found in self.simulators:
            if not found.here:
                yield f"{found.simulator.title}: worlds cannot be opened in it", found.simulator.how_to_install[0]
        for each in self.extras:
            if each.missing:
                yield f"{', '.join(each.missing)}: {each.extra.use}", pip_install([each.extra.name])


def environment() -> Environment:
    """Look; no server is started, and what fails is a line of the result."""
    names = {extra: [re.split(r"[^\w.-]", each)[0] for each in needed] for extra, needed in requirements().items()}
    return Environment(
        rsegen=__version__,
        python=f"{platform.python_implementation()} {platform.python_version()}",
        executable=sys.executable,
        platform=f"{platform.platform()}, {platform.machine()}",
        libraries={name: _version(name) for name in names.get("", ["numpy"])},
        simulators=tuple(found_simulators()),
        extras=tuple(_found_extra(extra, names.get(extra.name, [])) for extra in EXTRAS),
        plugins=tuple(dict.fromkeys(f"{each.source}: {each.name}" for each in entry_points())),
    )


def _found_extra(extra: Extra, packages: list[str]) -> FoundExtra:
    versions = {name: found for name in packages if (found := _version(name))}
    return FoundExtra(extra=extra, missing=extra.missing_modules, versions=versions)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


_WIDTH = 12


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the versions, simulators and extras that rsegen finds here, what is missing, and what it is "
    epilog = "Starts no simulator and changes nothing. Add its output to bug reports."
    add_command(commands, "doctor", text=f"{text}needed for.", epilog=epilog)


def run(arguments: argparse.Namespace) -> Report:
    """Look."""
    here = environment()
    return Report(lines=_report(here), content=_summary(here))


def _summary(found: Environment) -> dict[str, Any]:
    plain = {name: getattr(found, name) for name in ("rsegen", "python", "executable", "platform", "libraries")}
    simulators = [each.summary for each in found.simulators]
    extras = [
        {"name": each.extra.name, "for": each.extra.use, "missing": each.missing, "versions": each.versions}
        for each in found.extras
    ]
    missing = [{"what": what, "remedy": remedy} for what, remedy in found.missing()]
    lists = {"simulators": simulators, "extras": extras, "plugins": found.plugins, "missing": missing}
    return plain | lists


def _report(found: Environment) -> Iterator[str]:
    yield _row("rsegen", found.rsegen)
    yield _row("Python", f"{found.python}, {found.executable}")
    yield _row("platform", found.platform)
    yield _row("libraries", ", ".join(f"{name} {number or 'missing'}" for name, number in found.libraries.items()))
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
