"""rsegen doctor: what rsegen finds on this machine, what is missing and for what; for reports of what does not work."""

from __future__ import annotations

import argparse
import platform
import re
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from rsegen import __version__
from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.cli.sim import found_simulators
from rsegen.params.extras import EXTRAS, pip_install, requirements
from rsegen.params.registry import entry_points

_WIDTH = 12


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the versions, simulators and extras that rsegen finds here, what is missing, and what it is "
    epilog = "Starts no simulator and changes nothing. Add its output to bug reports."
    add_command(commands, "doctor", text=f"{text}needed for.", epilog=epilog)


def run(arguments: argparse.Namespace) -> Report:
    """Look; no server is started, and what fails is a line of the result."""
    found = _environment()
    content = {**found, "missing": [{"what": what, "remedy": remedy} for what, remedy in _missing(found)]}
    return Report(lines=_report(content), content=content)


def _environment() -> dict[str, Any]:
    """Return versions, simulators, extras and plug-ins; the version of a library or package that is missing is None."""
    needed = {extra: [re.split(r"[^\w.-]", each)[0] for each in lines] for extra, lines in requirements().items()}
    return {
        "rsegen": __version__,
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "executable": sys.executable,
        "platform": f"{platform.platform()}, {platform.machine()}",
        "libraries": {name: _version(name) for name in needed.get("", ["numpy"])},
        "simulators": found_simulators(),
        "extras": [
            {
                "name": extra.name,
                "for": extra.use,
                "missing": extra.missing_modules,
                "versions": {name: found for name in needed.get(extra.name, ()) if (found := _version(name))},
            }
            for extra in EXTRAS
        ],
        "plugins": list(dict.fromkeys(f"{each.source}: {each.name}" for each in entry_points())),
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _missing(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what is missing, what it is needed for, and how to get it."""
    for name in (name for name, number in found["libraries"].items() if number is None):
        yield f"{name}, which rsegen always needs", f"{sys.executable} -m pip install '{name}'"
    for each in found["simulators"]:
        if each["version"] is None:
            yield f"{each['title']}: worlds cannot be opened in it", each["how_to_get"][0]
    for each in found["extras"]:
        if each["missing"]:
            yield f"{', '.join(each['missing'])}: {each['for']}", pip_install([each["name"]])


def _report(found: Mapping[str, Any]) -> Iterator[str]:
    yield _row("rsegen", found["rsegen"])
    yield _row("Python", f"{found['python']}, {found['executable']}")
    yield _row("platform", found["platform"])
    yield _row("libraries", ", ".join(f"{name} {number or 'missing'}" for name, number in found["libraries"].items()))
    yield from (_row("plug-in", plugin) for plugin in found["plugins"])
    yield "\nSimulators"
    for each in found["simulators"]:
        here = each["version"] is not None
        yield f"  {each['title']}" + (f" {each['version']}" if here else f": {each['problem'] or 'not installed'}")
        yield from (f"    {name}: {path}" for name, path in each["commands"].items())
    yield "\nExtras"
    for each in found["extras"]:
        versions = ", ".join(f"{name} {number}" for name, number in each["versions"].items())
        state = f"missing: {', '.join(each['missing'])}" if each["missing"] else versions or "installed"
        yield f"  {each['name']:<{_WIDTH - 2}}{state} (for {each['for']})"
    yield "\nMissing" if found["missing"] else "\nNothing is missing."
    for each in found["missing"]:
        yield f"  {each['what']}\n    {each['remedy']}"


def _row(name: str, text: str) -> str:
    return f"{name:<{_WIDTH}}{text}"
