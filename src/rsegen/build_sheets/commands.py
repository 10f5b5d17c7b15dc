"""The command `rsegen sheet`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from rsegen.build_sheets.cut_settings import CutSettings
from rsegen.cli.flags import (
    add_target_flags,
    add_target_recipe_flags,
    map_of_flags,
    which_map,
)
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.errors import ParameterError
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
    add_flags(command.group("output"), _Files)
    add_flags(command.group("cutting"), CutSettings)
    add_target_recipe_flags(command)


def run_sheet(arguments: argparse.Namespace) -> Report:
    """Write the build sheet, as PDF, CSV or both."""
    from rsegen.build_sheets.document import sheet_format, write_sheets

    paths = [Path(arguments.output)]
    if arguments.csv is not None:
        paths.append(Path(arguments.csv))
        if [sheet_format(path) == "csv" for path in paths] != [False, True]:
            given_names = f"{paths[1]} with -o {paths[0]}"
            raise ParameterError("--csv", f"{given_names}; --csv needs a name that ends in .csv, and -o one in .pdf")
    settings = given(CutSettings, arguments, arguments.units)
    _, recipe, index = map_of_flags(arguments)
    saw = replace(CutSettings.default(recipe.units), **settings)
    scene = write_sheets(recipe, index, paths, saw, force=bool(arguments.force))
    content = {"files": [str(path) for path in paths], "map": scene.name, "seed": scene.recipe.seed}
    lines = [f"{path}: {scene.name}, seed {scene.recipe.seed}" for path in paths]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))
