"""rsegen sheet: what a person builds a map in wood by."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_parameter_flags, given
from rsegen.cli.targets import add_target_flags, found
from rsegen.errors import ParameterError
from rsegen.room import refuse_too_large
from rsegen.scene import compose
from rsegen.sheet import Saw, refuse_unbuildable, sheet, sheet_format
from rsegen.writer import refuse_taken_file, write_file


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "sheet",
        help="write what a person builds a map in wood by: heights in every cell, what to cut",
        description="Write the build sheet of a map: how its pallets stand, what timber to buy and how to cut it, and "
        " a page for each pallet with the height in every cell and the order of placing.",
        epilog="rsegen import reads the CSV again.",
    )
    add_target_flags(command)
    command.add_argument("-o", "--output", required=True, metavar="FILE", help="pdf or csv, by its ending")
    command.add_argument("--csv", metavar="FILE", help="write the same as CSV, too: a row for each cell")
    command.add_argument("--force", action="store_true", help="replace files that are there already")
    add_parameter_flags(command.add_argument_group("sawing"), Saw, asdict(Saw()))
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make the sheets, and write them."""
    formats = _formats(arguments)
    for path in formats:
        refuse_taken_file(path, force=arguments.force)
    saw = Saw(**given(Saw, arguments))
    _, recipe, index = found(arguments.target, arguments.map)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    made = {path: sheet(scene, saw, format_) for path, format_ in formats.items()}
    for path, content in made.items():
        write_file([content], path, force=arguments.force)
        print(f"{path}: {scene.name}, seed {scene.recipe.seed}")


def _formats(arguments: argparse.Namespace) -> dict[Path, str]:
    """The files to write, and the format of each."""
    path = Path(arguments.output)
    formats = {path: sheet_format(path)}
    if arguments.csv is None:
        return formats
    other = Path(arguments.csv)
    if sheet_format(other) != "csv" or formats[path] == "csv":
        raise ParameterError("--csv", f"{other} beside {path}; give one name of .csv, and -o one of .pdf")
    return {**formats, other: "csv"}
