"""rsegen preview: a map as a picture."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rsegen.cli.flags import add_target_recipe_flags
from rsegen.cli.report import Report, Subparsers, add_command
from rsegen.cli.targets import add_target_flags, picture_path, scene_of
from rsegen.commands.parameters import Force
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import FilePath, Flag


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing:
    """Draw a map: its plan with the heights, and a view in three dimensions."""

    output: Annotated[
        str,
        FilePath("a picture", help="picture: png, svg, pdf, jpg or webp, by its ending"),
        Shell(("-o", "--output"), "FILE", required=True),
    ]
    outlines: Annotated[
        bool, Flag(help="draw on the plan which cells each obstacle covers, numbered from 0 as in error messages")
    ] = False
    force: Force = False


def add(commands: Subparsers) -> None:
    """Add the parser of this command."""
    epilog = "Needs no screen. The plan counts cells below and on the left, and metres above and on the right."
    command = add_command(commands, "preview", _Drawing, epilog=epilog)
    add_target_flags(command)
    add_flags(command.add_argument_group("output"), _Drawing)
    add_target_recipe_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> Report:
    """Draw, and write the picture."""
    from rsegen.exporters.pictures.preview import image_format, preview
    from rsegen.run.store import write_file

    path = picture_path(arguments.output, force=bool(arguments.force)) or Path()
    scene = scene_of(arguments)
    picture = preview(scene, image_format(path), outlines=bool(arguments.outlines))
    write_file([picture], path, force=bool(arguments.force))
    content = {"file": str(path), "map": scene.name, "seed": scene.recipe.seed}
    return Report(lines=[f"{path}: {scene.name}, seed {scene.recipe.seed}"], content=content)
