"""rsegen sheet: a build sheet (PDF, CSV) for building a map in wood."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from rsegen.cli.flags import add_target_recipe_flags
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.cli.targets import add_target_flags, map_of_flags, which_map
from rsegen.commands.parameters import Force
from rsegen.errors import ParameterError
from rsegen.exporters.cut_settings import CutSettings
from rsegen.params.command import Shell, add_flags, given
from rsegen.params.sorts import FilePath


@dataclass(frozen=True, kw_only=True, slots=True)
class _Files:
    """Write the build sheet of a map: its pallets, what timber to buy and how to cut it, and a page for each pallet."""

    output: Annotated[
        str,
        FilePath("a file", help="build sheet: pdf or csv, by its ending"),
        Shell(("-o", "--output"), "FILE", required=True),
    ]
    csv: Annotated[
        str | None,
        FilePath("a name that ends in .csv", help="also write it as CSV, one row per cell"),
        Shell(metavar="FILE"),
    ] = None
    force: Force = False


def add_sheet(command: Parser) -> None:
    """Add the flags of `rsegen sheet`."""
    epilog = (
        "A pallet's page has the height of every block and the order of placing. rsegen import reads the CSV again."
    )
    command.explain(_Files.__doc__, epilog)
    add_target_flags(command)
    add_flags(command.add_argument_group("output"), _Files)
    add_flags(command.add_argument_group("cutting"), CutSettings)
    add_target_recipe_flags(command)


def run_sheet(arguments: argparse.Namespace) -> Report:
    """Make the sheets, and write them."""
    from rsegen.run.single_files import write_sheets

    paths = _paths(arguments)
    settings = given(CutSettings, arguments, arguments.units)
    _, recipe, index = map_of_flags(arguments)
    saw = replace(CutSettings.default(recipe.units), **settings)
    scene = write_sheets(recipe, index, paths, saw, force=bool(arguments.force))
    content = {"files": [str(path) for path in paths], "map": scene.name, "seed": scene.recipe.seed}
    lines = [f"{path}: {scene.name}, seed {scene.recipe.seed}" for path in paths]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


def _paths(arguments: argparse.Namespace) -> list[Path]:
    """The files to write."""
    from rsegen.exporters.sheet import sheet_format

    path = Path(arguments.output)
    if arguments.csv is None:
        return [path]
    other = Path(arguments.csv)
    if sheet_format(other) != "csv" or sheet_format(path) == "csv":
        raise ParameterError("--csv", f"{other} beside {path}; give one name of .csv, and -o one of .pdf")
    return [path, other]
