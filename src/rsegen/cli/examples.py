"""rsegen examples: recipes to start from."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from rsegen.cli.flags import Subparsers, folder
from rsegen.io.recipe_file import load
from rsegen.io.writer import refuse_taken_file, write_file
from rsegen.recipe.examples import EXAMPLES


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "examples",
        description="List the recipes that come with rsegen, or copy them into a folder.",
        epilog="The name of an example works wherever a recipe is expected: rsegen generate peak -o worlds",
    )
    command.add_argument("-o", "--output", type=folder, metavar="DIR", help="folder to copy them into")
    command.add_argument("--force", action="store_true", help="replace existing files")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print them, or copy them."""
    if arguments.output:
        copies = {path: arguments.output / path.name for path in EXAMPLES.values()}
        _copy(copies, force=arguments.force)
        print("\n".join(map(str, copies.values())))
    else:
        print("\n".join(_report()))


def _copy(copies: dict[Path, Path], *, force: bool) -> None:
    """All of them, or none where one is there already."""
    for copy in copies.values():
        refuse_taken_file(copy, force=force)
    for path, copy in copies.items():
        write_file([path.read_bytes()], copy, force=force)


def _report() -> Iterator[str]:
    width = max(map(len, EXAMPLES))
    for name, path in EXAMPLES.items():
        yield f"{name:<{width}}  {load(path).description}"
