"""The command line: which command its words name, and the parser of that command.

Its commands are those that capabilities declare (`params/capabilities.py`). Help is made only when it is asked for, and
a command's module is imported when the command is named. Plug-ins are loaded before the command line is parsed, as they
may add to what it takes.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from functools import partial

from rsegen import __version__
from rsegen.cli.parser import FLAG, VARIABLE, Parser
from rsegen.errors import PluginError
from rsegen.params.capabilities import command_functions, commands, left_out, unknown_command

OVERVIEW = """\
rsegen makes Random Step Environments (NIST stepfields) as worlds and models for robot simulators.

  rsegen generate --obstacle 'random levels=5' -o worlds   make a world
  rsegen open worlds/rse_0000                              open it in Gazebo
  rsegen examples                                          list recipes to start from
  rsegen gui                                               shape a map with the mouse
  rsegen --help                                            list all commands
"""
"""Text that `rsegen` without arguments prints."""


def parser() -> Parser:
    """Return the parser of the command line without a command, whose help lists the commands."""
    top = Parser(
        prog="rsegen",
        usage="rsegen COMMAND [options]",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random levels=5' -o worlds",
    )
    top.add_argument("-V", "--version", action="version", version=f"rsegen {__version__}")
    for title in dict.fromkeys(command.group for command in commands().values()):
        top.add_rows(title, partial(_rows_of, title))
    return top


def _rows_of(title: str) -> list[tuple[str, str]]:
    return [(command.name, command.help) for command in commands().values() if command.group == title]


def parser_of(command: str, empty: Parser | None = None) -> Parser:
    """Return the parser of one command, or `empty` with its flags and the function that runs it; imports its module."""
    from rsegen.cli.report import add_shared_flags

    full = empty or Parser(prog=f"rsegen {command}")
    add, run = command_functions(command)
    add_shared_flags(full, add)
    full.set_defaults(run=run)
    return full


def parsers() -> Iterator[tuple[str, Parser]]:
    """Yield every command with its parser; one of another package that has none is left out with a warning."""
    for name in commands():
        try:
            made = parser_of(name)
        except PluginError as error:
            left_out(str(error))
        else:
            yield name, made


def parsed(words: Sequence[str]) -> argparse.Namespace:
    """Return what a command line says; its `run` runs the command, if one is named."""
    if words and words[0] == "help":  # as in git, docker and pip
        words = [*words[1:2], "--help"]
    if words and words[0] == "version":
        words = ["--version"]
    if not words or words[0].startswith("-"):
        return parser().parse_args(words)
    command, *others = words
    if command not in commands():
        parser().error(str(unknown_command(command)))
    return parser_of(command).parse_args(others)


def load_plugins(arguments: Sequence[str]) -> list[str]:
    """Load the plug-ins that the environment and the arguments name; gives the arguments without them."""
    others, named = _parted(arguments)
    for name in (*filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)), *named):
        from rsegen.params.plugins import load_plugin

        load_plugin(name)
    return others


def _parted(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments without `--plugin MODULE`, and the modules; what follows `--` is left alone."""
    # By hand, as the parser of the command, which plug-ins add to, is made only after they are loaded.
    others: list[str] = []
    named: list[str] = []
    waiting = list(arguments)
    while waiting:
        part = waiting.pop(0)
        if part == "--":
            return [*others, part, *waiting], named
        if part == FLAG and waiting:
            named.append(waiting.pop(0))
        elif part.startswith(f"{FLAG}="):
            named.append(part.partition("=")[2])
        else:
            others.append(part)
    return others, named
