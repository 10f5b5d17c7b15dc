"""rsegen examples: recipes to start from."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from rsegen.cli.flags import Subparsers, add_force_flag, folder
from rsegen.io.recipe_file import load
from rsegen.recipe.examples import EXAMPLES
from rsegen.run.single_files import copy_examples


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "examples",
        description="List the recipes that come with rsegen, or copy them into a folder.",
        epilog="The name of an example works wherever a recipe is expected: rsegen generate peak -o worlds",
    )
    command.add_argument("-o", "--output", type=folder, metavar="DIR", help="folder to copy them into")
    add_force_flag(command, "existing copies")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print them, or copy them."""
    if arguments.output:
        print("\n".join(map(str, copy_examples(arguments.output, force=arguments.force))))
    else:
        print("\n".join(_report()))


def _report() -> Iterator[str]:
    width = max(map(len, EXAMPLES))
    for name, path in EXAMPLES.items():
        yield f"{name:<{width}}  {load(path).description}"
