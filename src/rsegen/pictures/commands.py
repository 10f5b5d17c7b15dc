"""The command `rsegen preview`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import radians
from typing import Annotated, Any

from rsegen.cli.flags import (
    add_target_flags,
    add_target_recipe_flags,
    scene_of_flags,
    which_map,
)
from rsegen.cli.parameters import Force
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, checked_flags
from rsegen.errors import ParameterError
from rsegen.field.crossing import robot_that_crosses
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import FilePath, Flag, Float, ListOf, Reference
from rsegen.pictures.flags import picture_of


@dataclass(frozen=True, kw_only=True, slots=True)
class _Preview:
    """Draw a map: its plan with the heights, and a view in three dimensions."""

    output: Annotated[
        str,
        FilePath("a picture", help="picture: png, svg, pdf, jpg or webp, by its ending"),
        Shell(("-o", "--output"), "FILE", required=True),
    ]
    outlines: Annotated[
        bool, Flag(help="draw on the plan which cells each obstacle covers, numbered from 0 as in error messages")
    ] = False
    paper: Annotated[
        bool,
        Flag(
            help="for one column of a paper: 8.9 cm wide, letters of 7 points, no title, 300 pixels per inch; "
            "svg and pdf are vector graphics"
        ),
    ] = False
    robot: Annotated[
        str | None,
        Reference("KIND or FILE", help="robot to draw at rest on the map: its kind, or a file"),
    ] = None
    at: Annotated[
        Sequence[float] | None,
        ListOf(Float(-1e6, 1e6), 3, help="where the robot is put down: x and y [m], and its heading [degrees]"),
        Shell(metavar="X,Y,HEADING", default="0,0,0"),
    ] = None
    force: Force = False


def add_preview(command: Parser) -> None:
    """Add the flags of `rsegen preview`."""
    epilog = "Needs no screen. The plan counts cells below and on the left, and metres above and on the right."
    command.explain(_Preview.__doc__, epilog)
    add_target_flags(command)
    add_flags(command.group("output"), _Preview)
    add_target_recipe_flags(command)


def run_preview(arguments: argparse.Namespace) -> Report:
    """Draw, and write the picture."""
    from rsegen.gazebo.map_summary import covered_obstacles_in_words
    from rsegen.pictures.preview import preview

    picture = picture_of(arguments.output, force=arguments.force)
    assert picture  # noqa: S101  # -o is required
    drawing = _Preview(**checked_flags(_Preview, arguments))
    if drawing.at and not drawing.robot:
        raise ParameterError("--at", "is the place of a robot; use --robot too")
    robot: Any = robot_that_crosses(drawing.robot, "--robot") if drawing.robot else None
    x, y, heading = drawing.at or (0.0, 0.0, 0.0)
    scene = scene_of_flags(arguments)
    try:
        at = x, y, radians(heading)
        picture.write(partial(preview, scene, outlines=drawing.outlines, robot=robot, at=at, paper=drawing.paper))
    except ParameterError as error:  # of x or y
        raise ParameterError("--at" if error.where in ("x", "y") else f"--{error.where}", error.problem) from None
    content = {"file": str(picture.path), "map": scene.name, "seed": scene.recipe.seed}
    lines = [f"{picture.path}: {scene.name}, seed {scene.recipe.seed}"]
    covered = (f"warning: {text}" for text in covered_obstacles_in_words(scene))
    return Report(lines=lines, content=content, notes=[*which_map(arguments.target, arguments.map), *covered])
