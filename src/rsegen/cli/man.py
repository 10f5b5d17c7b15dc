"""rsegen man: the manual page of rsegen or of a command, made of its help, as `man` shows it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from typing import Any

from rsegen import __version__
from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.errors import UnknownName


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the manual page of rsegen, or of one of its commands, for the program man."
    epilog = "To read one: rsegen man generate | man -l -. To keep it: rsegen man generate > "
    epilog += "~/.local/share/man/man1/rsegen-generate.1, and then: man rsegen-generate."
    command = add_command(commands, "man", text=text, epilog=epilog)
    command.add_argument("command", nargs="?", metavar="COMMAND", help="default: the list of commands")


def run(arguments: argparse.Namespace) -> Report:
    """Print it."""
    from rsegen.cli.commands import COMMANDS, parser, parser_of

    name = arguments.command
    if name is not None and name not in COMMANDS:
        raise UnknownName.among("", "command", name, COMMANDS)
    of = parser_of(name) if name else parser()
    of.formatter_class = _Roff
    about = COMMANDS[name] if name else of.description
    page = f"{title(of.prog, str(about))}{of.format_help()}"
    return Report(lines=[page.rstrip("\n")], content={"command": name, "page": page})


def title(program: str, about: str) -> str:
    """Return the head of a page: `whatis` and `apropos` read its line of NAME."""
    name, about = program.replace(" ", "-"), _text(about.rstrip("."))
    return f'.TH "{name.upper()}" 1 "" "rsegen {__version__}" "rsegen"\n.SH NAME\n{_text(name)} \\- {about}\n'


class _Roff(argparse.HelpFormatter):
    """The help of a parser in the language of man; the walk over it is the parser's own."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog)
        self._page: list[str] = []

    def add_usage(self, usage: Any, actions: Any, groups: Any, prefix: str | None = None) -> None:
        """Add how to call it."""
        super().add_usage(usage, actions, groups, prefix="")
        self._page += [".SH SYNOPSIS", _text(" ".join(super().format_help().split()))]
        self._page.append(".SH DESCRIPTION")

    def start_section(self, heading: str | None) -> None:
        """Begin a group of flags; one without any leaves no heading."""
        self._page.append(f".SH {_text((heading or '').upper())}")

    def end_section(self) -> None:
        """End it."""
        if self._page[-1].startswith(".SH"):
            self._page.pop()

    def add_text(self, text: str | None) -> None:
        """Add a paragraph."""
        if text:
            self._page += [".PP", _text(self._format_text(text))]

    def add_arguments(self, actions: Iterable[argparse.Action]) -> None:
        """Add flags and names, each with its help."""
        for action in actions:
            if action.help is not argparse.SUPPRESS:
                help_ = self._expand_help(action) if action.help else ""
                self._page += [".TP", rf"\fB{_text(self._format_action_invocation(action))}\fR", _text(help_)]

    def format_help(self) -> str:
        """Return the page below its head."""
        return "\n".join(self._page) + "\n"


def _text(text: str) -> str:
    """Return a text on one line that roff prints as it is: no escape, no command, hyphens as typed."""
    escaped = " ".join(text.split()).replace("\\", r"\e").replace("-", r"\-")
    return re.sub(r"^(?=[.'])", r"\\&", escaped)
