"""rsegen preview: a map as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path

from rsegen.cli.flags import Subparsers, add_force_flag, add_target_recipe_flags
from rsegen.cli.targets import add_target_flags, scene_of
from rsegen.exporters.pictures.preview import image_format, preview
from rsegen.run.store import refuse_taken_file, write_file


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "preview",
        description="Draw a map: its plan with the heights, and a view in three dimensions. Needs no screen. The plan "
        "counts the cells of recipes below and on the left, and metres above and on the right.",
    )
    add_target_flags(command)
    group = command.add_argument_group("output")
    text = "png, svg, pdf, jpg or webp, by its ending (required)"
    group.add_argument("-o", "--output", required=True, metavar="FILE", help=text)
    text = "draw on the plan which cells each obstacle covers; they are numbered from 0, as in error messages"
    group.add_argument("--outlines", action="store_true", help=text)
    add_force_flag(group, "an existing picture")
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Draw, and write the picture."""
    path = Path(arguments.output)
    format_ = image_format(path)
    refuse_taken_file(path, force=arguments.force)
    scene = scene_of(arguments)
    write_file([preview(scene, format_, outlines=arguments.outlines)], path, force=arguments.force)
    print(f"{path}: {scene.name}, seed {scene.recipe.seed}")
