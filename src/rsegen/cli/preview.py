"""rsegen preview: a map as a picture."""

from __future__ import annotations

import argparse
from pathlib import Path

from rsegen.cli.flags import Subparsers
from rsegen.cli.targets import add_target_flags
from rsegen.exporters.pictures.preview import image_format, preview_image
from rsegen.io.targets import chosen
from rsegen.io.writer import refuse_taken_file, write_file


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "preview",
        help="draw a map: plan with heights, and a view in 3D",
        description="Draw a map: its plan with the heights, and a view in three dimensions. Needs no screen.",
    )
    add_target_flags(command)
    command.add_argument(
        "-o", "--output", required=True, metavar="FILE", help="png, svg, pdf, jpg or webp, by its ending"
    )
    command.add_argument("--force", action="store_true", help="replace a picture that is there already")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Draw, and write the picture."""
    path = Path(arguments.output)
    format_ = image_format(path)
    refuse_taken_file(path, force=arguments.force)
    scene = chosen(arguments.target, arguments.map)
    write_file([preview_image(scene, format_)], path, force=arguments.force)
    print(f"{path}: {scene.name}, seed {scene.recipe.seed}")
