"""The commands that look at a map: info, spots, preview and view."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from math import degrees, radians
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.commands import Parser
from rsegen.cli.flags import (
    PictureName,
    add_target_flags,
    add_target_recipe_flags,
    is_of_flags,
    maps_of_flags,
    picture_of,
    scene_of,
    target_of,
    which_map,
)
from rsegen.cli.report import Report, checked_flags, counted, robot_kinds
from rsegen.cli.worlds import SHOWN
from rsegen.commands.parameters import Force
from rsegen.commands.simulation import spots
from rsegen.errors import ParameterError
from rsegen.params.command import Shell, add_flags, default, flags_in_errors, given
from rsegen.params.sorts import FilePath, Flag, Float, ListOf, Reference, parameters

if TYPE_CHECKING:
    from rsegen.exporters.scene import Scene
    from rsegen.standing.spots import Spot


_CONSTRAINTS = ("max_step", "crossable_by", "inventory")

_LONGEST = 100
"""Letters of an obstacle: a matrix may have thousands."""


def add_info(command: Parser) -> None:
    """Add the flags of `rsegen info`."""
    text = "Print the size of a map, its obstacles, the blocks of each level, and its cost in faces and bytes."
    command.explain(text)
    add_target_flags(command)
    text = "compare every file in DIR, and in the maps in it, with the sizes and checksums that rsegen recorded"
    command.add_argument_group("output").add_argument("--verify", action="store_true", help=text)
    add_target_recipe_flags(command)


def run_info(arguments: argparse.Namespace) -> Report:
    """Summarise the map, or verify a folder."""
    if arguments.verify:
        return _verified(arguments)
    scene = scene_of(arguments)
    content = _summary(scene)
    return Report(lines=_lines(scene, content), content=content, notes=which_map(arguments.target, arguments.map))


def _verified(arguments: argparse.Namespace) -> Report:
    """Compare a folder with its records, and say what was compared."""
    from rsegen.run.journal import verify

    if arguments.target is None or arguments.map is not None or is_of_flags(arguments):
        raise ParameterError("--verify", "needs a folder that rsegen wrote, and no recipe")
    verified = verify(arguments.target)
    unlisted = [str(path) for path in verified.unlisted]
    lines = [f"{counted(verified.files, 'file')} in {counted(verified.folders, 'folder')} as rsegen wrote them"]
    lines += [f"not written by rsegen: {path}" for path in unlisted]
    return Report(lines=lines, content={"folders": verified.folders, "files": verified.files, "unlisted": unlisted})


def _summary(scene: Scene) -> dict[str, Any]:
    from rsegen.exporters.map_summary import costs, switched_off, warnings
    from rsegen.exporters.scene import fingerprint
    from rsegen.recipe.codec import needed_plugins

    field, recipe = scene.field, scene.recipe
    added = {"plugins": needed_plugins(recipe), "switched_off": switched_off(recipe)}
    return {
        "name": scene.name,
        "seed": recipe.seed,
        "size": list(field.shape),
        "size_m": list(field.extent),
        "unit_cm": recipe.unit_cm,
        "levels": list(field.level_counts()),
        "level_counts": field.level_counts(),
        "fingerprint": fingerprint(field.blocks),
        "obstacles": [obstacle.entry() for _, obstacle in recipe.enabled_obstacles],
        "constraints": {name: value for name, value in recipe.entry().items() if name in _CONSTRAINTS},
        "mesh_type": recipe.mesh_type,
        **costs(scene)._asdict(),
        "warnings": list(warnings(scene)),
        **{name: known for name, known in added.items() if known},
    }


def _lines(scene: Scene, content: Mapping[str, Any]) -> Iterator[str]:
    from rsegen.exporters.map_summary import size_in_words
    from rsegen.exporters.numbers import lengths_in
    from rsegen.recipe.codec import row_text

    recipe, (along_x, along_y) = scene.recipe, scene.field.extent
    blocks = sum(content["level_counts"].values())
    yield f"{scene.name}, seed {recipe.seed}"
    yield f"size     {size_in_words(recipe.grid.shape, scene.field.shape)}, {along_x:g} x {along_y:g} m"
    written = lengths_in(recipe.units)
    in_levels = f"in levels of {written.level(1, recipe.unit_cm)} {written.unit}"
    yield f"blocks   {blocks:,} {in_levels}, fingerprint {content['fingerprint']}"
    for level, count in content["level_counts"].items():
        high = written.level(level, recipe.unit_cm)
        yield f"  level {level:>3}  {high:>7} {written.unit}  {count:>9,}  {count / blocks:6.1%}"
    cost = ", ".join(counted(content[f"{what}s"], what) for what in ("model", "collision", "face"))
    yield f"costs    mesh type {recipe.mesh_type}: {cost}, {content['bytes']:,} bytes"
    for _, placed in recipe.enabled_obstacles[:SHOWN]:
        text = row_text(placed)
        yield f"obstacle {text if len(text) <= _LONGEST else f'{text[:_LONGEST]}...'}"
    if len(recipe.enabled_obstacles) > SHOWN:
        yield f"         and {len(recipe.enabled_obstacles) - SHOWN} more"
    for name, value in content["constraints"].items():
        yield f"demand   {name} {parameters(type(recipe))[name].format(value)}"
    for kind, source in content.get("plugins", {}).items():
        yield f"plug-in  {kind} of {source}"
    yield from (f"off      {obstacle}" for obstacle in content.get("switched_off", ()))
    yield from (f"warning: {text}" for text in content["warnings"])


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
    command.explain(_Preview.__doc__, epilog)
    add_target_flags(command)
    add_flags(command.add_argument_group("output"), _Preview)
    add_target_recipe_flags(command)


def run_preview(arguments: argparse.Namespace) -> Report:
    """Draw, and write the picture."""
    from rsegen.exporters.pictures.preview import preview
    from rsegen.robots import robot_of

    picture = picture_of(arguments.output, force=arguments.force)
    assert picture  # noqa: S101  # -o is required
    drawing = _Preview(**checked_flags(_Preview, arguments))
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
