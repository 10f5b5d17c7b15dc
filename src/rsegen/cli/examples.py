"""rsegen examples: recipes to start from."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.commands.parameters import Force
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import FilePath


@dataclass(frozen=True, kw_only=True, slots=True)
class _Copies:
    """List the recipes that come with rsegen, or copy them into a folder."""

    output: Annotated[Path | None, FilePath(help="folder to copy them into"), Shell(("-o", "--output"), "DIR")] = None
    force: Force = False


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = "The name of an example works wherever a recipe is expected: rsegen generate peak -o worlds"
    command = add_command(commands, "examples", _Copies, epilog=epilog)
    add_flags(command, _Copies)


def run(arguments: argparse.Namespace) -> Report:
    """List them, or copy them."""
    from rsegen.io.recipe_file import load
    from rsegen.recipe.examples import EXAMPLES
    from rsegen.run.single_files import copy_examples

    if arguments.output is not None:
        copies = [str(path) for path in copy_examples(Path(arguments.output), force=bool(arguments.force))]
        return Report(lines=copies, content={"files": copies})
    described = {name: load(path).description for name, path in EXAMPLES.items()}
    width = max(map(len, described))
    content = [{"name": name, "description": text, "file": str(EXAMPLES[name])} for name, text in described.items()]
    return Report(lines=(f"{name:<{width}}  {text}" for name, text in described.items()), content=content)
