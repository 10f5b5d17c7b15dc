"""rsegen view: maps as a page for browsers."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Annotated

from rsegen.cli.flags import add_target_recipe_flags
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report
from rsegen.cli.targets import add_target_flags, maps_of_flags
from rsegen.commands.parameters import Force
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import FilePath


@dataclass(frozen=True, kw_only=True, slots=True)
class _Page:
    """Write maps as one HTML file with a 3D view, the plan, heights, metrics and the recipe; it needs no internet."""

    output: Annotated[str, FilePath("a file", help="HTML file"), Shell(("-o", "--output"), "FILE", required=True)]
    force: Force = False


def add_view(command: Parser) -> None:
    """Add the flags of `rsegen view`."""
    command.explain(_Page.__doc__)
    add_target_flags(command, "all, to choose from on the page")
    add_flags(command.add_argument_group("output"), _Page)
    add_target_recipe_flags(command)


def run_view(arguments: argparse.Namespace) -> Report:
    """Make the page, and write it."""
    from rsegen.run.single_files import html_path, view_all
    from rsegen.run.store import refuse_taken_file

    path = html_path(arguments.output)
    refuse_taken_file(path, force=bool(arguments.force))
    recipes = maps_of_flags(arguments)
    page = view_all(recipes)
    page.save(path, force=bool(arguments.force))
    maps, size = sum(recipe.maps for recipe in recipes), len(page.html)
    first = recipes[0]
    named = f"{first.map_name(first.first_map)}, seed {first.seed}" if maps == 1 else f"{maps} maps"
    content = {"file": str(path), "maps": maps, "bytes": size}
    return Report(lines=[f"{path}: {named}, {size:,} bytes"], content=content)
