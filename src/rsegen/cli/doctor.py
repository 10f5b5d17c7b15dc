"""The command `rsegen doctor`: what is installed, what is missing and what it is needed for."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from rsegen import __version__
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.params.capabilities import Finding, all_extras, hooks, left_out
from rsegen.params.plugins import entry_points, failure


def add_doctor(command: Parser) -> None:
    """Say what `rsegen doctor` is."""
    text = (
        "Print the versions, simulators and extras that rsegen finds here, what is missing, and what it is needed for."
    )
    command.explain(text, "Starts no simulator and changes nothing. Add its output to bug reports.")


def run_doctor(_: argparse.Namespace) -> Report:
    """Look at this machine; no server is started, and what fails is a line of the result."""
    findings = [finding for look in hooks("doctor") if (finding := _finding(look))]
    known = _environment(findings)
    missing = [{"what": thing, "remedy": remedy} for thing, remedy in _missing(known, findings)]
    content = {**known, "missing": missing}
    return Report(lines=_diagnosis(content, findings), content=content)


def _finding(look: Callable[[], Finding]) -> Finding | None:
    """Return what a capability finds on this machine; None, with a warning, if another package's fails."""
    try:
        finding = look()
        if not isinstance(finding, Finding):
            raise TypeError(f"it returned {finding!r}, and no Finding")
        if not all(isinstance(part, list) for part in finding[2:]) or any(len(pair) != 2 for pair in finding.missing):
            raise TypeError(f"the fields of {finding!r} are not as those of a Finding")
    except Exception as error:
        from rsegen.params.registry import is_own

        if is_own(look):
            raise
        left_out(f"plug-in {look.__module__}:{look.__name__}: {failure(error)}")
        return None
    return finding


def _environment(findings: Sequence[Finding]) -> dict[str, Any]:
    """Return versions, extras, plug-ins and findings; the version of a library or package that is missing is None."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    from rsegen.params.extras import requirements

    def version_of(package: str) -> str | None:
        try:
            return version(package)
        except PackageNotFoundError:
            return None

    # A requirement is a line such as `numpy>=2`, of which the name counts: the version is that of what is installed.
    needed = {extra: [re.split(r"[^\w.-]", line)[0] for line in lines] for extra, lines in requirements().items()}
    return {
        "rsegen": __version__,
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "executable": sys.executable,
        "platform": f"{platform.platform()}, {platform.machine()}",
        "libraries": {name: version_of(name) for name in needed.get("", ["numpy"])},
        **{finding.name: finding.content for finding in findings},
        "extras": [
            {
                "name": extra.name,
                "for": extra.use,
                "missing": extra.missing_modules,
                "versions": {name: known for name in needed.get(extra.name, ()) if (known := version_of(name))},
            }
            for extra in all_extras().values()
        ],
        "plugins": list(dict.fromkeys(f"{offer.source}: {offer.name}" for offer in entry_points())),
    }


def _missing(known: Mapping[str, Any], findings: Sequence[Finding]) -> Iterator[tuple[str, str]]:
    """Yield what is missing, what it is needed for, and how to get it."""
    from rsegen.params.extras import pip_install

    for name in (name for name, version in known["libraries"].items() if version is None):
        yield f"{name}, which rsegen always needs", f"{sys.executable} -m pip install '{name}'"
    for finding in findings:
        yield from finding.missing
    for extra in known["extras"]:
        if extra["missing"]:
            yield f"{', '.join(extra['missing'])}: {extra['for']}", pip_install([extra["name"]])


def _diagnosis(content: Mapping[str, Any], findings: Sequence[Finding]) -> Iterator[str]:
    libraries = ", ".join(f"{name} {version or 'missing'}" for name, version in content["libraries"].items())
    yield f"rsegen      {content['rsegen']}"
    yield f"Python      {content['python']}, {content['executable']}"
    yield f"platform    {content['platform']}"
    yield f"libraries   {libraries}"
    yield from (f"plug-in     {plugin}" for plugin in content["plugins"])
    for finding in findings:
        yield from _section(finding.title, finding.lines)
    installed = (extra for extra in content["extras"] if not extra["missing"])
    yield from _section("Extras", map(_of_extra, installed))
    yield "\nMissing" if content["missing"] else "\nNothing is missing."
    for lack in content["missing"]:
        yield f"  {lack['what']}\n    {lack['remedy']}"


def _section(title: str, lines: Iterable[str]) -> Iterator[str]:
    yield f"\n{title}"
    yield from [f"  {line}" for line in lines] or ["  none"]


def _of_extra(extra: Mapping[str, Any]) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in extra["versions"].items())
    return f"{extra['name']:<10}{versions or 'installed'} (for {extra['for']})"
