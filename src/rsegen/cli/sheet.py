"""rsegen sheet: a build sheet (PDF, CSV) for building a map in wood."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_force_flag, add_parameter_flags, add_target_recipe_flags, given
from rsegen.cli.targets import add_target_flags, map_of_flags
from rsegen.errors import ParameterError
from rsegen.exporters.sheet import CutSettings, sheet_format
from rsegen.run.single_files import write_sheets


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "sheet",
        description="Write the build sheet of a map: how its pallets are arranged, what timber to buy and how to "
        "cut it, and a page per pallet with the height of every block and the order of placing.",
        epilog="rsegen import reads the CSV again.",
    )
    add_target_flags(command)
    group = command.add_argument_group("output")
    group.add_argument("-o", "--output", required=True, metavar="FILE", help="pdf or csv, by its ending (required)")
    group.add_argument("--csv", metavar="FILE", help="also write it as CSV, one row per cell")
    add_force_flag(group, "existing files")
    add_parameter_flags(command.add_argument_group("cutting"), CutSettings)
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make the sheets, and write them."""
    paths = _paths(arguments)
    settings = given(CutSettings, arguments)
    _, recipe, index = map_of_flags(arguments)
    saw = replace(CutSettings.default(recipe.units), **settings)
    scene = write_sheets(recipe, index, paths, saw, force=arguments.force)
    print("\n".join(f"{path}: {scene.name}, seed {scene.recipe.seed}" for path in paths))


def _paths(arguments: argparse.Namespace) -> list[Path]:
    """The files to write."""
    path = Path(arguments.output)
    if arguments.csv is None:
        return [path]
    other = Path(arguments.csv)
    if sheet_format(other) != "csv" or sheet_format(path) == "csv":
        raise ParameterError("--csv", f"{other} beside {path}; give one name of .csv, and -o one of .pdf")
    return [path, other]
