"""What a command prints: lines for people, or the same as JSON for programs; nothing with --quiet."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from rsegen.cli.parser import Parser
from rsegen.params.command import flags_in_errors, given

Subparsers: TypeAlias = "argparse._SubParsersAction[Parser]"

R = TypeVar("R")


@dataclass(frozen=True, kw_only=True)
class Report:
    """The outcome of a command.

    lines: for people, made while they are printed; content: for --json, or a function that gives it; notes: lines that
    go to stderr with --json; code: the exit code
    """

    lines: Iterable[str]
    content: object
    notes: Iterable[str] = ()
    code: int = 0

    def show(self, arguments: argparse.Namespace) -> int:
        """Print it as the flags ask for, and return the exit code."""
        if arguments.json:
            print(json.dumps(self.content() if callable(self.content) else self.content, indent=2))
        for line in () if arguments.json else self.lines:
            _print(line, arguments)
        for line in self.notes:
            _print(line, arguments, sys.stderr if arguments.json else sys.stdout)
        return self.code


def _print(line: str, arguments: argparse.Namespace, file: Any = None) -> None:
    if not arguments.quiet:
        print(line, file=file)


def add_command(
    commands: Subparsers, name: str, function: Callable[..., object] | None = None, *, text: str = "", epilog: str = ""
) -> Parser:
    """Add the parser of a command, with the flags that all have; its text is the first line of its function."""
    description = text or ((function.__doc__ or "").partition("\n")[0] if function else "")
    parser = commands.add_parser(name, description=description.replace("%", "%%"), epilog=epilog)
    parser.add_argument("--json", action="store_true", help="print the result as JSON, lengths in metres")
    parser.add_argument("-q", "--quiet", action="store_true", help="print no report and no progress")
    return parser


def call(function: Callable[..., R], arguments: argparse.Namespace, *positional: Any, **named: Any) -> R:
    """Call a command with what its flags say, and what else is given; its errors name the flags."""
    with flags_in_errors(function):
        return function(*positional, **{**given(function, arguments), **named})
