"""The command `rsegen man`: the help of a command as a manual page."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from typing import Any

from rsegen import __version__
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.params.capabilities import commands, unknown_command


def add_man(command: Parser) -> None:
    """Add the argument of `rsegen man`."""
    text = "Print the manual page of rsegen, or of one of its commands, for the program man."
    epilog = "To read one: rsegen man generate | man -l -. To install it: rsegen man generate > "
    command.explain(text, f"{epilog}~/.local/share/man/man1/rsegen-generate.1, and then: man rsegen-generate.")
    command.add_argument("command", nargs="?", metavar="COMMAND", help="default: the list of commands")


def run_man(arguments: argparse.Namespace) -> Report:
    """Print a manual page: its head, of which `whatis` and `apropos` read the line of NAME, and the help."""
    from rsegen.cli.parser import parser, parser_of

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
