"""rsegen view: maps as a page for browsers."""

from __future__ import annotations

import argparse
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_force_flag, add_target_recipe_flags
from rsegen.cli.targets import add_target_flags, map_of_flags, recipes_of
from rsegen.recipe.recipe import Recipe
from rsegen.run.single_files import html_path, view_all
from rsegen.run.store import refuse_taken_file


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "view",
        description="Write maps as one HTML file that any browser opens, without internet: a 3D view, the "
        "plan, the height of each cell under the mouse, metrics, and the recipe to copy.",
    )
    add_target_flags(command, usual="all, to choose from on the page")
    group = command.add_argument_group("output")
    group.add_argument("-o", "--output", required=True, metavar="FILE", help="HTML file (required)")
    add_force_flag(group, "an existing file")
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make the page, and write it."""
    path = html_path(arguments.output)
    refuse_taken_file(path, force=arguments.force)
    recipes = _recipes(arguments)
    view_all(recipes).save(path, force=arguments.force)
    maps = sum(recipe.maps for recipe in recipes)
    first = recipes[0]
    named = f"{first.map_name(first.first_map)}, seed {first.seed}" if maps == 1 else f"{maps} maps"
    print(f"{path}: {named}, {Path(path).stat().st_size:,} bytes")


def _recipes(arguments: argparse.Namespace) -> list[Recipe]:
    """The recipes of all maps of the target, or of the one that --map names."""
    if arguments.map is None:
        return [recipe for _, recipe in recipes_of(arguments)]
    _, recipe, index = map_of_flags(arguments)
    return [recipe.alone(index)]
