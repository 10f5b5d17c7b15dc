"""rsegen schema: the JSON Schema of a recipe file."""

from __future__ import annotations

import argparse
import json

from rsegen.cli.flags import Subparsers
from rsegen.recipe.codec import schema


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "schema",
        description="Print the JSON Schema (2020-12) of recipe files; editors complete and check recipes by it.",
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print it."""
    print(json.dumps(schema(), indent=2))
