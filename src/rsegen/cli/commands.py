"""The table of commands: what each is for. A command's module is imported when the command is named, not before."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any

from rsegen import __version__
from rsegen.cli.parser import Parser

GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "worlds": {
            "generate": "write worlds and models",
            "series": "write maps whose difficulty rises evenly",
            "terrain": "write one field of many maps, in rows of rising difficulty, for learning",
            "import": "write a world from measured heights, an image or an occupancy grid of ROS",
            "scan": "write the world of a real field from a point cloud or a depth image of it",
            "gui": "edit maps on a page in the browser",
        },
        "maps": {
            "info": "print the size of a map, its obstacles and its cost",
            "metrics": "measure how rough maps are, and what a robot can do on them",
            "compare": "show which blocks of a scan, or of a map, differ from those of a map",
            "spots": "find spots for a start or a goal of a robot",
            "preview": "draw a map: plan with heights, and a view in 3D",
            "view": "write maps as an HTML page with a 3D view and heights",
        },
        "files for other programs": {
            "export": "write maps for other programs: meshes, arrays, images, occupancy grids",
            "sheet": "write a build sheet (PDF, CSV) for building a map in wood",
            "dataset": "write very many maps into few files, for machine learning",
        },
        "simulation": {
            "open": "open a world in Gazebo",
            "drive": "drive a robot over a map in Gazebo and report how far it got",
            "spawn": "spawn a map or a robot in the running simulation",
            "respawn": "replace the map of the running simulation by the next one",
            "remove": "delete models from the running simulation",
            "experiment": "measure what maps cost a simulator while robots drive on them",
        },
        "information": {
            "examples": "list the recipes to start from, or copy them",
            "obstacles": "list the kinds of obstacles and their parameters",
            "schema": "print the JSON Schema of recipe files, or of the parameters of a command",
            "sim": "list the simulators with version and path, or how to install them",
            "doctor": "list what is installed, what is missing and what it is needed for",
            "completion": "print what makes bash, zsh or fish complete commands and flags",
            "man": "print the manual page of rsegen or of a command",
        },
    }
)
"""Every command with its line of help, in the groups of `rsegen --help`."""

COMMANDS: Mapping[str, str] = MappingProxyType(
    {name: help_ for group in GROUPS.values() for name, help_ in group.items()}
)
"""Every command with its line of help."""


_TOGETHER: Mapping[str, Iterable[str]] = {
    "worlds": ("generate", "series", "terrain"),
    "measured": ("import", "scan"),
    "pictures": ("spots", "preview", "view"),
    "files": GROUPS["files for other programs"],
    "simulation": GROUPS["simulation"],
    "information": GROUPS["information"],
}
"""The modules that have several commands, which are alike; any other has the name of its command."""


def module_of(command: str) -> str:
    """Return the name of the module that has the functions `add_COMMAND` and `run_COMMAND`."""
    return f"rsegen.cli.{next((module for module, names in _TOGETHER.items() if command in names), command)}"


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]  # argparse has no public name for it
    """The commands, of which the module of the named one adds its parser, and no other."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.choices = dict(COMMANDS)

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: Any = None) -> None:
        self.add(values[0])
        super().__call__(parser, namespace, values, option_string)

    def add(self, name: str) -> None:
        """Add the parser of a command, and the function that runs it, if it is not there yet."""
        if name not in self._name_parser_map:
            module, command = import_module(module_of(name)), self.add_parser(name)
            import_module("rsegen.cli.report").add_shared_flags(command, getattr(module, f"add_{name}"))
            command.set_defaults(run=getattr(module, f"run_{name}"))


def parser() -> Parser:
    """Return the parser of the whole command line."""
    top = Parser(
        prog="rsegen",
        usage="rsegen COMMAND [options]",
        description="Random Step Environments (NIST stepfields) as worlds and models for robot simulators.",
        epilog="Start with: rsegen generate --obstacle 'random levels=5' -o worlds",
    )
    top.add_argument("-V", "--version", action="version", version=f"rsegen {__version__}")
    top.add_subparsers(action=_Commands, prog="rsegen", metavar="COMMAND", help=argparse.SUPPRESS)
    for title, commands in GROUPS.items():
        top.add_rows(title, commands.items)
    return top


def parser_of(command: str) -> Parser:
    """Return the parser of one command."""
    (commands,) = (action for action in parser()._actions if isinstance(action, _Commands))
    commands.add(command)
    made: Parser = commands._name_parser_map[command]
    return made


OVERVIEW = """\
rsegen makes Random Step Environments (NIST stepfields) as worlds and models for robot simulators.

  rsegen generate --obstacle 'random levels=5' -o worlds   make a world
  rsegen open worlds/rse_0000                              open it in Gazebo
  rsegen examples                                          list recipes to start from
  rsegen gui                                               shape a map with the mouse
  rsegen --help                                            list all commands
"""
"""What `rsegen` alone prints."""


def complete(top: Parser) -> None:
    """Answer a shell that asks what may follow, and end; return if none asks (`_ARGCOMPLETE` is argcomplete's own)."""
    if "_ARGCOMPLETE" not in os.environ:
        return
    import argcomplete

    (commands,) = (action for action in top._actions if isinstance(action, _Commands))
    words = os.environ.get("COMP_LINE", "").split()[1:]
    named = next((word for word in words if word in COMMANDS), None)
    if named:
        commands.add(named)
    for name in COMMANDS:  # argcomplete looks into each parser
        if name not in commands._name_parser_map:
            commands._name_parser_map[name] = Parser(prog=f"rsegen {name}")
    commands.choices = commands._name_parser_map
    argcomplete.autocomplete(top, always_complete_options="long")
