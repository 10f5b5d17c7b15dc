"""rsegen schema: the JSON Schema of a recipe file, or of the parameters of a command."""

from __future__ import annotations

import argparse
import json

from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.errors import UnknownName

_ALIKE = ("drive", "spots", "experiment", "open", "spawn", "respawn", "remove")
FUNCTIONS = {"generate": "generate", "series": "series", "dataset": "make_dataset", "export": "export_maps"} | {
    name: name for name in _ALIKE
}
"""The function of `rsegen` that each command is."""


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    text = "Print the JSON Schema (2020-12) of recipe files, by which editors complete and check recipes; or of the "
    command = add_command(commands, "schema", text=f"{text}parameters of a command, of which a form can be made.")
    command.add_argument("command", nargs="?", metavar="COMMAND", help=", ".join(FUNCTIONS))


def run(arguments: argparse.Namespace) -> Report:
    """Print it."""
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
