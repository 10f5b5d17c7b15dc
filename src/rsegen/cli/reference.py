"""The commands that print what rsegen knows: examples, obstacles, schema, completion and manual pages."""

from __future__ import annotations

import argparse
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen import __version__
from rsegen.cli.command_line import parser, parser_of
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import UnknownName
from rsegen.params.capabilities import commands, unknown_command
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import FilePath

if TYPE_CHECKING:
    from rsegen.params.sorts import Parameter


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
    from rsegen.recipe.examples import EXAMPLES
    from rsegen.recipe.recipe_file import load
    from rsegen.writing.store import write_files

    if arguments.output is not None:
        copies = {Path(arguments.output) / path.name: [path.read_bytes()] for path in EXAMPLES.values()}
        write_files(copies, force=bool(arguments.force))
        names = [str(path) for path in copies]
        return Report(lines=names, content={"files": names})
    described = {name: load(path).description for name, path in EXAMPLES.items()}
    width = max(map(len, described))
    content = [{"name": name, "description": text, "file": str(EXAMPLES[name])} for name, text in described.items()]
    return Report(lines=(f"{name:<{width}}  {text}" for name, text in described.items()), content=content)


def add_obstacles(command: Parser) -> None:
    """Add the argument of `rsegen obstacles`."""
    command.explain("List the kinds of obstacles with their parameters, ranges and meaning; as JSON their schemas.")
    argument: Any = command.add_argument("kind", nargs="?", metavar="KIND", help="only this kind")
    argument.completer = _kinds


def _kinds(**_: object) -> Iterable[str]:
    from rsegen.obstacles import KINDS

    return KINDS


def run_obstacles(arguments: argparse.Namespace) -> Report:
    """List the kinds of obstacles, or one of them."""
    from rsegen.obstacles import KINDS
    from rsegen.recipe.codec import schema

    if arguments.kind is not None:
        KINDS.named(arguments.kind, "KIND")
    kinds = list(KINDS) if arguments.kind is None else [arguments.kind]

    def schemas() -> list[object]:
        known = schema()["properties"]["obstacles"]["items"]["oneOf"]
        return [row for row in known if row["properties"]["kind"]["const"] in kinds]

    return Report(lines=_described(kinds), content=schemas)


def _described(kinds: Sequence[str]) -> Iterator[str]:
    from rsegen.obstacles import KINDS
    from rsegen.obstacles.base import Obstacle, own_parameters
    from rsegen.params.registry import summary_of_class
    from rsegen.params.sorts import parameters

    def rows(known: Mapping[str, Parameter]) -> Iterator[str]:
        return (f"    {name:<14} {parameter.help}: {parameter.describe()}" for name, parameter in known.items())

    # What all kinds have is listed once, at the end; a kind that declares such a parameter anew lists its own.
    shared = parameters(Obstacle)

    yield "An obstacle is its kind, the parameters of that kind, and a place: 'peak levels=5 first=2,2 last=7,7'."
    yield "Every kind also has the parameters at the end, such as levels, softness, first and last."
    yield ""
    for name in kinds:
        cls, source = KINDS[name], KINDS.source(name)
        yield f"{name}\n    {summary_of_class(cls)}" + (f" From {source}." if source else "")
        yield from rows({key: own for key, own in own_parameters(cls).items() if own != shared.get(key)})
        yield ""
    yield "every kind"
    yield from rows(shared)


def add_schema(command: Parser) -> None:
    """Add the argument of `rsegen schema`."""
    text = "Print the JSON Schema (2020-12) of recipe files, with which editors complete and check recipes; or of the "
    command.explain(f"{text}parameters of a command, for making a form.")
    functions = [name for name, known in commands().items() if known.function]
    argument: Any = command.add_argument("command", nargs="?", metavar="COMMAND", help=", ".join(functions))
    argument.completer = lambda **_: functions


def run_schema(arguments: argparse.Namespace) -> Report:
    """Print the schema of a recipe, or of a command."""
    import rsegen
    from rsegen.params.command import command_schema
    from rsegen.recipe.codec import schema

    functions = {name: known.function for name, known in commands().items() if known.function}
    if arguments.command is None:
        content = schema()
    elif arguments.command in functions:
        content = command_schema(getattr(rsegen, functions[arguments.command]))
    else:
        raise unknown_command(arguments.command, functions)
    return Report(lines=[json.dumps(content, indent=2)], content=content)


_SHELLS = ("bash", "zsh", "fish")


def add_completion(command: Parser) -> None:
    """Add the argument of `rsegen completion`."""
    epilog = (
        'Permanently: eval "$(rsegen completion bash)" in ~/.bashrc, the same with zsh in ~/.zshrc after compinit, or '
        "rsegen completion fish > ~/.config/fish/completions/rsegen.fish."
    )
    command.explain("Print a shell completion script: Tab then completes commands, flags and their values.", epilog)
    text = f"{', '.join(_SHELLS)} (default: that of $SHELL)"
    argument: Any = command.add_argument("shell", nargs="?", metavar="SHELL", help=text)
    argument.completer = lambda **_: _SHELLS


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
    epilog = "To read one: rsegen man generate | man -l -. To install it: rsegen man generate > "
    command.explain(text, f"{epilog}~/.local/share/man/man1/rsegen-generate.1, and then: man rsegen-generate.")
    text = "default: the list of commands"
    argument: Any = command.add_argument("command", nargs="?", metavar="COMMAND", help=text)
    argument.completer = lambda **_: commands()


def run_man(arguments: argparse.Namespace) -> Report:
    """Print a manual page: its head, of which `whatis` and `apropos` read the line of NAME, and the help."""
    name = arguments.command
    if name is not None and name not in commands():
        raise unknown_command(name)
    of = parser_of(name) if name else parser()
    of.formatter_class = _Roff
    program, about = (
        of.prog.replace(" ", "-"),
        _roff(str(commands()[name].help if name else of.description).rstrip(".")),
    )
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
