"""The parser of every command; what it refuses it refuses in one line."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn

from rsegen import __version__
from rsegen.cli import (
    dataset,
    drive,
    examples,
    experiment,
    export,
    generate,
    gui,
    import_,
    info,
    metrics,
    obstacles,
    open,
    preview,
    remove,
    respawn,
    schema,
    series,
    sheet,
    sim,
    spawn,
)
from rsegen.cli.plugins import add_plugin_flag
from rsegen.errors import UnknownName, shown

COMMANDS = (
    generate,
    series,
    dataset,
    import_,
    export,
    gui,
    preview,
    info,
    metrics,
    sheet,
    open,
    spawn,
    respawn,
    remove,
    drive,
    experiment,
    obstacles,
    examples,
    schema,
    sim,
)


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, with the nearest flag or command, and takes flags in full only."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_Help, **options)
        add_plugin_flag(self)

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """What is unknown is known to be so by the command itself, which has the flags to compare it with."""
        parsed, unknown = super().parse_known_args(args, namespace)
        for text in unknown[:1]:
            flags = [flag for action in self._actions for flag in action.option_strings]
            named = text.startswith("-")
            self.error(
                str(UnknownName.among("", "flag", text, flags)) if named else f"unexpected argument {shown(text)}"
            )
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            self.error(str(UnknownName.among("", "command", value, action.choices)))


class _Help(argparse.HelpFormatter):
    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=26)


def parser() -> Parser:
    """The parser of the whole command line."""
    top = Parser(
        prog="rsegen",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random max_height=5' -o worlds",
    )
    top.add_argument("--version", action="version", version=f"rsegen {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add(commands)
    return top
