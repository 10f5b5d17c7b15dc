"""The commands that print what rsegen knows and finds: examples, obstacles, schema, sim, doctor, completion and man."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen import __version__
from rsegen.cli.commands import Parser
from rsegen.cli.report import Report
from rsegen.commands.parameters import Force
from rsegen.errors import RsegenError, UnknownName, line_of
from rsegen.params.command import Shell, add_flags
from rsegen.params.registry import entry_points
from rsegen.params.sorts import FilePath

if TYPE_CHECKING:
    from rsegen.params.sorts import Parameter
    from rsegen.simulation.simulators import Installation, Simulator


@dataclass(frozen=True, kw_only=True, slots=True)
class _Copies:
    """List the recipes that come with rsegen, or copy them into a folder."""

    output: Annotated[Path | None, FilePath(help="folder to copy them into"), Shell(("-o", "--output"), "DIR")] = None
    force: Force = False


def add_examples(command: Parser) -> None:
    """Add the flags of `rsegen examples`."""
    epilog = "The name of an example works wherever a recipe is expected: rsegen generate peak -o worlds"
    command.explain(_Copies.__doc__, epilog)
    add_flags(command, _Copies)


def run_examples(arguments: argparse.Namespace) -> Report:
    """List the examples, or copy them."""
    from rsegen.io.recipe_file import load
    from rsegen.recipe.examples import EXAMPLES
    from rsegen.run.single_files import copy_examples

    if arguments.output is not None:
        copies = [str(path) for path in copy_examples(Path(arguments.output), force=bool(arguments.force))]
        return Report(lines=copies, content={"files": copies})
    described = {name: load(path).description for name, path in EXAMPLES.items()}
    width = max(map(len, described))
    content = [{"name": name, "description": text, "file": str(EXAMPLES[name])} for name, text in described.items()]
    return Report(lines=(f"{name:<{width}}  {text}" for name, text in described.items()), content=content)


def add_obstacles(command: Parser) -> None:
    """Say what `rsegen obstacles` is."""
    command.explain("List the kinds of obstacles with their parameters, ranges and meaning; as JSON their schemas.")


def run_obstacles(_: argparse.Namespace) -> Report:
    """List the kinds of obstacles."""
    from rsegen.recipe.codec import schema

    return Report(lines=_kinds(), content=lambda: schema()["properties"]["obstacles"]["items"]["oneOf"])


def _kinds() -> Iterator[str]:
    from rsegen.field.obstacles import KINDS
    from rsegen.field.obstacles.base import PLACING, own_parameters
    from rsegen.params.registry import summary

    def rows(known: Mapping[str, Parameter]) -> Iterator[str]:
        return (f"    {name:<11} {parameter.help}: {parameter.describe()}" for name, parameter in known.items())

    yield "An obstacle is its kind, the parameters of that kind, and a place: 'peak levels=5 first=2,2 last=7,7'."
    yield "first and last, its place, are the same for every kind: they are at the end."
    yield ""
    for name, cls in KINDS.items():
        source = KINDS.source(name)
        yield f"{name}\n    {summary(cls)}" + (f" From {source}." if source else "")
        yield from rows(own_parameters(cls))
        yield ""
    yield "every kind"
    yield from rows(PLACING)


FUNCTIONS = {"generate": "generate", "series": "series", "dataset": "make_dataset", "export": "export_maps"} | {
    name: name for name in ("drive", "spots", "experiment", "open", "spawn", "respawn", "remove")
}
"""The function of `rsegen` that each command is."""


def add_schema(command: Parser) -> None:
    """Add the argument of `rsegen schema`."""
    text = "Print the JSON Schema (2020-12) of recipe files, by which editors complete and check recipes; or of the "
    command.explain(f"{text}parameters of a command, of which a form can be made.")
    command.add_argument("command", nargs="?", metavar="COMMAND", help=", ".join(FUNCTIONS))


def run_schema(arguments: argparse.Namespace) -> Report:
    """Print the schema of a recipe, or of a command."""
    import rsegen
    from rsegen.params.command import schema as command_schema
    from rsegen.recipe.codec import schema

    if arguments.command is None:
        content = schema()
    elif arguments.command in FUNCTIONS:
        content = command_schema(getattr(rsegen, FUNCTIONS[arguments.command]))
    else:
        raise UnknownName.among("", "command", arguments.command, FUNCTIONS)
    return Report(lines=[json.dumps(content, indent=2)], content=content)


def add_sim(command: Parser) -> None:
    """Say what `rsegen sim` is."""
    command.explain("List the simulators in which rsegen can open worlds: version and path, or how to install them.")


def run_sim(_: argparse.Namespace) -> Report:
    """Look for simulators."""
    simulators = _simulators()
    return Report(lines=_lines_of(simulators), content=simulators)


def _simulators() -> list[dict[str, Any]]:
    """Ask every simulator at the same time whether it is installed; return what is known of each, for JSON."""
    from concurrent.futures import ThreadPoolExecutor

    from rsegen.simulation.simulators import SIMULATORS

    with ThreadPoolExecutor() as pool:
        return list(pool.map(_simulator, SIMULATORS.values()))


def _simulator(simulator: Simulator) -> dict[str, Any]:
    """Return what is known of a simulator: a plug-in's may raise anything, and one that is there may not answer."""
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


def _lines_of(simulators: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for known in simulators:
        yield f"{known['name']:<9}{known['title']} {known['version'] or known['problem'] or 'is not installed'}"
        rows = [f"{name}: {path}" for name, path in known["commands"].items()] or known["how_to_get"]
        yield from (f"{'':<9}  {row}" for row in rows if not known["problem"])


def add_doctor(command: Parser) -> None:
    """Say what `rsegen doctor` is."""
    text = (
        "Print the versions, simulators and extras that rsegen finds here, what is missing, and what it is needed for."
    )
    command.explain(text, "Starts no simulator and changes nothing. Add its output to bug reports.")


def run_doctor(_: argparse.Namespace) -> Report:
    """Look at this machine; no server is started, and what fails is a line of the result."""
    here = _environment()
    content = {**here, "missing": [{"what": what, "remedy": remedy} for what, remedy in _missing(here)]}
    return Report(lines=_diagnosis(content), content=content)


def _environment() -> dict[str, Any]:
    """Return versions, simulators, extras and plug-ins; the version of a library or package that is missing is None."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    from rsegen.params.extras import EXTRAS, requirements

    def version_of(package: str) -> str | None:
        try:
            return version(package)
        except PackageNotFoundError:
            return None

    needed = {extra: [re.split(r"[^\w.-]", line)[0] for line in lines] for extra, lines in requirements().items()}
    return {
        "rsegen": __version__,
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "executable": sys.executable,
        "platform": f"{platform.platform()}, {platform.machine()}",
        "libraries": {name: version_of(name) for name in needed.get("", ["numpy"])},
        "simulators": _simulators(),
        "extras": [
            {
                "name": extra.name,
                "for": extra.use,
                "missing": extra.missing_modules,
                "versions": {name: known for name in needed.get(extra.name, ()) if (known := version_of(name))},
            }
            for extra in EXTRAS
        ],
        "plugins": list(dict.fromkeys(f"{offer.source}: {offer.name}" for offer in entry_points())),
    }


def _missing(here: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what is missing, what it is needed for, and how to get it."""
    from rsegen.params.extras import pip_install

    for name in (name for name, number in here["libraries"].items() if number is None):
        yield f"{name}, which rsegen always needs", f"{sys.executable} -m pip install '{name}'"
    for simulator in here["simulators"]:
        if simulator["version"] is None:
            yield f"{simulator['title']}: worlds cannot be opened in it", simulator["how_to_get"][0]
    for extra in here["extras"]:
        if extra["missing"]:
            yield f"{', '.join(extra['missing'])}: {extra['for']}", pip_install([extra["name"]])


def _diagnosis(here: Mapping[str, Any]) -> Iterator[str]:
    libraries = ", ".join(f"{name} {number or 'missing'}" for name, number in here["libraries"].items())
    yield f"rsegen      {here['rsegen']}"
    yield f"Python      {here['python']}, {here['executable']}"
    yield f"platform    {here['platform']}"
    yield f"libraries   {libraries}"
    yield from (f"plug-in     {plugin}" for plugin in here["plugins"])
    yield "\nSimulators"
    for simulator in here["simulators"]:
        version = f" {simulator['version']}"
        problem = f": {simulator['problem'] or 'not installed'}"
        yield f"  {simulator['title']}{problem if simulator['version'] is None else version}"
        yield from (f"    {name}: {path}" for name, path in simulator["commands"].items())
    yield "\nExtras"
    for extra in here["extras"]:
        versions = ", ".join(f"{name} {number}" for name, number in extra["versions"].items())
        state = f"missing: {', '.join(extra['missing'])}" if extra["missing"] else versions or "installed"
        yield f"  {extra['name']:<10}{state} (for {extra['for']})"
    yield "\nMissing" if here["missing"] else "\nNothing is missing."
    for lack in here["missing"]:
        yield f"  {lack['what']}\n    {lack['remedy']}"


_SHELLS = ("bash", "zsh", "fish")


def add_completion(command: Parser) -> None:
    """Add the argument of `rsegen completion`."""
    epilog = (
        'For good: eval "$(rsegen completion bash)" in ~/.bashrc, the same with zsh in ~/.zshrc after compinit, or '
        "rsegen completion fish > ~/.config/fish/completions/rsegen.fish."
    )
    command.explain("Print what makes a shell complete commands, flags and their words when Tab is pressed.", epilog)
    text = f"{', '.join(_SHELLS)} (default: that of $SHELL)"
    command.add_argument("shell", nargs="?", metavar="SHELL", help=text)


def run_completion(arguments: argparse.Namespace) -> Report:
    """Print the code for a shell, by which argcomplete asks rsegen itself at each Tab."""
    from argcomplete.shell_integration import shellcode

    shell = arguments.shell or os.path.basename(os.environ.get("SHELL", "bash"))
    if shell not in _SHELLS:
        raise UnknownName.among("", "shell", shell, _SHELLS)
    code = shellcode(["rsegen"], shell=shell)
    return Report(lines=[code.rstrip("\n")], content={"shell": shell, "code": code})


def add_man(command: Parser) -> None:
    """Add the argument of `rsegen man`."""
    text = "Print the manual page of rsegen, or of one of its commands, for the program man."
    epilog = "To read one: rsegen man generate | man -l -. To keep it: rsegen man generate > "
    command.explain(text, f"{epilog}~/.local/share/man/man1/rsegen-generate.1, and then: man rsegen-generate.")
    command.add_argument("command", nargs="?", metavar="COMMAND", help="default: the list of commands")


def run_man(arguments: argparse.Namespace) -> Report:
    """Print a manual page: its head, of which `whatis` and `apropos` read the line of NAME, and the help."""
    from rsegen.cli.commands import COMMANDS, parser, parser_of

    name = arguments.command
    if name is not None and name not in COMMANDS:
        raise UnknownName.among("", "command", name, COMMANDS)
    of = parser_of(name) if name else parser()
    of.formatter_class = _Roff
    program, about = of.prog.replace(" ", "-"), _roff(str(COMMANDS[name] if name else of.description).rstrip("."))
    head = f'.TH "{program.upper()}" 1 "" "rsegen {__version__}" "rsegen"\n.SH NAME\n{_roff(program)} \\- {about}\n'
    page = f"{head}{of.format_help()}"
    return Report(lines=[page.rstrip("\n")], content={"command": name, "page": page})


class _Roff(argparse.HelpFormatter):
    """The help of a parser in the language of man; the walk over it is the parser's own."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog)
        self._page: list[str] = []

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: str | None = None) -> None:
        """Add how to call it."""
        super().add_usage(usage, actions, groups, prefix="")
        self._page += [".SH SYNOPSIS", _roff(" ".join(super().format_help().split())), ".SH DESCRIPTION"]

    def start_section(self, heading: str | None) -> None:
        """Begin a group of flags; one without any leaves no heading."""
        self._page.append(f".SH {_roff((heading or '').upper())}")

    def end_section(self) -> None:
        """Take the heading of an empty group away."""
        if self._page[-1].startswith(".SH"):
            self._page.pop()

    def add_text(self, text: str | None) -> None:
        """Add a paragraph."""
        if text:
            self._page += [".PP", _roff(self._format_text(text))]

    def add_arguments(self, actions: Iterable[argparse.Action]) -> None:
        """Add flags and names, each with its help."""
        for action in actions:
            if action.help is not argparse.SUPPRESS:
                help_ = self._expand_help(action) if action.help else ""
                self._page += [".TP", rf"\fB{_roff(self._format_action_invocation(action))}\fR", _roff(help_)]

    def format_help(self) -> str:
        """Return the page below its head."""
        return "\n".join(self._page) + "\n"


def _roff(text: str) -> str:
    """Return a text on one line that roff prints as it is: no escape, no command, hyphens as typed."""
    escaped = " ".join(text.split()).replace("\\", r"\e").replace("-", r"\-")
    return re.sub(r"^(?=[.'])", r"\\&", escaped)
