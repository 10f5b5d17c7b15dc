"""The commands that draw maps: spots, preview and view."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import degrees, radians
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.commands import Parser
from rsegen.cli.flags import (
    PictureName,
    add_target_flags,
    add_target_recipe_flags,
    maps_of_flags,
    picture_of,
    scene_of,
    target_of,
    which_map,
)
from rsegen.cli.report import Report, checked_flags, robot_kinds
from rsegen.commands.parameters import Force
from rsegen.commands.simulation import spots
from rsegen.errors import ParameterError
from rsegen.params.command import Shell, add_flags, default, flags_in_errors, given
from rsegen.params.sorts import FilePath, Flag, Float, ListOf, Reference

if TYPE_CHECKING:
    from rsegen.standing.spots import Spot


@dataclass(frozen=True, kw_only=True, slots=True)
class _Outlines:
    """The picture that the shell can ask for."""

    output: Annotated[
        PictureName, Shell(help="draw the outlines of the robot on the plan: png, svg, pdf, jpg or webp, by its ending")
    ] = None
    force: Force = False


def add_spots(command: Parser) -> None:
    """Add the flags of `rsegen spots`."""
    epilog = "rsegen drive --route random with the same seed starts there."
    command.explain(spots.__doc__, f"{epilog} {robot_kinds()}")
    add_target_flags(command)
    add_flags(command.add_argument_group("spots"), spots, without=["map"])
    add_flags(command.add_argument_group("output"), _Outlines)
    add_target_recipe_flags(command, ("seed",))


def run_spots(arguments: argparse.Namespace) -> Report:
    """Find and draw them."""
    from rsegen.exporters.pictures.robot_plots import spots_plot
    from rsegen.params.streams import fresh_seed
    from rsegen.robots import robot_of
    from rsegen.simulation.worlds import world_of
    from rsegen.standing.spots import Outline, body_of_size

    picture = picture_of(arguments.output, force=arguments.force)
    with flags_in_errors(spots):
        said = {"seed": fresh_seed()} | given(spots, arguments)
        target = target_of(arguments, () if arguments.target is None else ("seed",))
        scene = world_of(target, arguments.map).scene()
        places = spots(scene, **{name: value for name, value in said.items() if name != "map"})
        if picture:
            size, robot = said.get("size"), said.get("robot", default(spots, "robot"))
            outline = Outline.of(body_of_size(*size) if size else robot_of(robot).body_or_box)
            picture.write(partial(spots_plot, scene, outline, places))
    content = {"map": scene.name, "seed": said["seed"], "spots": [asdict(place) for place in places]}
    lines = [f"{scene.name}, seed {said['seed']}:", *_rows(places)]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


def _rows(places: Sequence[Spot]) -> Iterator[str]:
    yield "spot    x [m]    y [m]    z [m]  yaw [deg]  tilt [deg]"
    for index, spot in enumerate(places):
        place = "".join(f"{value:9.3f}" for value in (spot.x, spot.y, spot.z))
        yield f"{index:>4}{place}{degrees(spot.yaw):11.1f}{degrees(spot.tilt):12.2f}"


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
    paper: Annotated[
        bool,
        Flag(
            help="for one column of a paper: 8.9 cm wide, letters of 7 points, no title, 300 pixels per inch; "
            "svg and pdf are vector graphics"
        ),
    ] = False
    robot: Annotated[
        str | None,
        Reference("KIND or FILE", help="robot to draw where it settles: its kind, or a file of it"),
    ] = None
    at: Annotated[
        tuple[float, float, float] | None,
        ListOf(Float(-1e6, 1e6), 3, help="where the robot is put down: x and y [m], and its heading [degrees]"),
        Shell(metavar="X,Y,HEADING", default="0,0,0"),
    ] = None
    force: Force = False


def add_preview(command: Parser) -> None:
    """Add the flags of `rsegen preview`."""
    epilog = "Needs no screen. The plan counts cells below and on the left, and metres above and on the right."
    command.explain(_Drawing.__doc__, epilog)
    add_target_flags(command)
    add_flags(command.add_argument_group("output"), _Drawing)
    add_target_recipe_flags(command)


def run_preview(arguments: argparse.Namespace) -> Report:
    """Draw, and write the picture."""
    from rsegen.exporters.pictures.preview import preview
    from rsegen.robots import robot_of

    picture = picture_of(arguments.output, force=arguments.force)
    assert picture  # noqa: S101  # -o is required
    drawing = _Drawing(**checked_flags(_Drawing, arguments))
    if drawing.at and not drawing.robot:
        raise ParameterError("--at", "is the place of a robot; give --robot too")
    robot = robot_of(drawing.robot, "--robot").body if drawing.robot else None
    x, y, heading = drawing.at or (0.0, 0.0, 0.0)
    scene = scene_of(arguments)
    try:
        at = x, y, radians(heading)
        picture.write(partial(preview, scene, outlines=drawing.outlines, robot=robot, at=at, paper=drawing.paper))
    except ParameterError as error:  # of x or y
        raise ParameterError("--at" if error.where in ("x", "y") else f"--{error.where}", error.problem) from None
    content = {"file": str(picture.path), "map": scene.name, "seed": scene.recipe.seed}
    lines = [f"{picture.path}: {scene.name}, seed {scene.recipe.seed}"]
    return Report(lines=lines, content=content, notes=which_map(arguments.target, arguments.map))


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
    recipes = [*maps_of_flags(arguments)]
    page = view_all(recipes)
    page.save(path, force=bool(arguments.force))
    maps, size = sum(recipe.maps for recipe in recipes), len(page.html)
    first = recipes[0]
    named = f"{first.map_name(first.first_map)}, seed {first.seed}" if maps == 1 else f"{maps} maps"
    content = {"file": str(path), "maps": maps, "bytes": size}
    return Report(lines=[f"{path}: {named}, {size:,} bytes"], content=content)
