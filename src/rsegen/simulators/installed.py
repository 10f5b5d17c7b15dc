"""The simulators that are on this machine, servers and libraries, for `rsegen sim` and `rsegen doctor`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rsegen.errors import RsegenError, line_of
from rsegen.params.capabilities import Finding

if TYPE_CHECKING:
    from rsegen.simulators.base import Simulator
    from rsegen.simulators.embedded import EmbeddedSimulator


def installed() -> list[dict[str, Any]]:
    """Ask every simulator at the same time whether it is installed; return what is known of each, for JSON.

    Those in this process come first, then the servers.
    """
    from concurrent.futures import ThreadPoolExecutor

    from rsegen.simulators.base import SIMULATORS
    from rsegen.simulators.embedded import EMBEDDED

    with ThreadPoolExecutor() as pool:
        return list(pool.map(_simulator, (*EMBEDDED.values(), *SIMULATORS.values())))


def _simulator(simulator: Simulator | EmbeddedSimulator) -> dict[str, Any]:
    """Return what is known of a simulator: a plug-in's may raise anything, and one that is there may not answer."""
    from rsegen.simulators.embedded import EmbeddedSimulator

    version: str | None = None
    commands: Mapping[str, Path] = {}
    problem = ""
    try:
        version, commands = _version_and_commands(simulator)
    except Exception as error:  # a report about a machine in disorder is wanted most
        problem = line_of(str(error) if isinstance(error, RsegenError) else f"{type(error).__name__}: {error}")
    return {
        "name": simulator.name,
        "title": simulator.title,
        "version": version,
        "commands": {name: str(path) for name, path in commands.items()},
        "embedded": isinstance(simulator, EmbeddedSimulator),
        "problem": problem,
        "how_to_get": list(simulator.how_to_install),
    }


def _version_and_commands(simulator: Simulator | EmbeddedSimulator) -> tuple[str | None, Mapping[str, Path]]:
    """Return the version, None if it is not installed, and the commands, of which a library has none."""
    from rsegen.simulators.embedded import EmbeddedSimulator

    if isinstance(simulator, EmbeddedSimulator):
        return simulator.version(), {}
    installation = simulator.installation()
    return (installation.version, installation.commands) if installation else (None, {})


def describe(simulators: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the lines of `rsegen sim`: each simulator with its version and commands, or how to get it."""
    for known in simulators:
        yield f"{known['name']:<9}{known['title']} {known['version'] or known['problem'] or 'is not installed'}"
        rows = [f"{name}: {path}" for name, path in known["commands"].items()]
        rows += known["how_to_get"] if known["version"] is None else []
        yield from (f"{'':<9}  {row}" for row in rows if not known["problem"])


def finding() -> Finding:
    """Return what `rsegen doctor` says of simulators."""
    simulators = installed()
    lines, missing = list[str](), list[tuple[str, str]]()
    for known in simulators:
        if known["version"]:
            lines.append(f"{known['title']} {known['version']}")
        elif known["problem"]:  # what is not installed is among what is missing alone
            lines.append(f"{known['title']}: {known['problem']}")
        lines += (f"  {name}: {path}" for name, path in known["commands"].items())
        if known["version"] is None:
            lacks = "robots cannot be driven in it" if known["embedded"] else "worlds cannot be opened in it"
            missing.append((f"{known['title']}: {lacks}", known["how_to_get"][0]))
    return Finding("simulators", "Simulators", simulators, lines, missing)
