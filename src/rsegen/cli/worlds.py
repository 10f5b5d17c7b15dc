"""The commands that write worlds of recipes: generate, series and terrain; and what all share that write worlds."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rsegen.cli.commands import Parser
from rsegen.cli.edge import how_to_go_on
from rsegen.cli.flags import add_format_rows, add_input, add_recipe_flags, recipe_from
from rsegen.cli.report import Report, call, checked_flags, counting, maps_bar
from rsegen.commands.maps import generate, series
from rsegen.commands.parameters import By, ByRobot
from rsegen.field.limits import SIDE
from rsegen.params.command import Shell, add_flags, declared, given
from rsegen.params.sorts import Integer, ListOf
from rsegen.params.streams import SEEDS
from rsegen.recipe.terrain_design import TerrainDesign

if TYPE_CHECKING:
    from rsegen.recipe.recipe import Recipe
    from rsegen.run.series import Series
    from rsegen.run.series_rows import SeriesRow
    from rsegen.run.worlds import Generated, GeneratedMap


SHOWN = 10
"""Maps that a report names one by one."""


def add_generate(command: Parser) -> None:
    """Add the flags of `rsegen generate`."""
    epilog = "rsegen obstacles lists the kinds of obstacles and their parameters."
    command.explain(generate.__doc__, epilog)
    add_input(command.add_argument_group("input"))
    add_output_flags(command)
    add_recipe_flags(command)


def add_output_flags(command: Parser) -> None:
    """Add where to write worlds, and how."""
    add_flags(command.add_argument_group("output"), generate)
    add_format_rows(command)


def run_generate(arguments: argparse.Namespace) -> Report:
    """Generate, and say what was made."""
    return produce(recipe_from(arguments), arguments)


def produce(
    recipe: Recipe, arguments: argparse.Namespace, beside: Mapping[str, Callable[[], bytes]] | None = None
) -> Report:
    """Write the maps of a recipe, and say what was made.

    beside: as in `generate`
    """
    options = run_options(generate, arguments)
    with going_on(arguments, recipe), maps_bar(recipe) as progress:
        made = call(generate, arguments, recipe, **options, progress=progress, beside=beside)
    return Report(lines=_lines(made), content=lambda: _content(made))


def run_options(function: Callable[..., object], arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the flags say of a run, by default with as many workers as there are cores; not yet checked."""
    from rsegen.run.execute import cores

    said = {"workers": cores()} | given(function, arguments)
    for format_ in said.get("formats", ()):
        if format_.left_out and not arguments.quiet:
            print(f"rsegen: {format_.left_out}", file=sys.stderr)
    return said


def going_on(arguments: argparse.Namespace, *recipes: Recipe) -> AbstractContextManager[None]:
    """Add to the message of a run that is stopped how its maps are completed."""
    then = "makes all of them again" if arguments.force else "makes the others"
    return how_to_go_on(*recipes, resume=not arguments.force, then=then)


def _content(made: Generated) -> dict[str, object]:
    """Return the maps that were made, for programs; `already` names the maps that --resume found, if any."""
    return {
        "folder": str(made.folder),
        "seed": made.recipe.seed,
        "maps": [
            {
                "name": generated.name,
                "index": generated.index,
                "folder": str(generated.folder),
                "world": str(generated.world),
                "size": list(generated.cells),
                "size_m": list(generated.extent),
                "levels": list(generated.level_counts),
                "level_counts": generated.level_counts,
                "files": [str(path) for path in generated.files],
                "warnings": list(generated.warnings),
            }
            for generated in made.maps
        ],
    } | ({"already": [made.recipe.map_name(index) for index in made.already]} if made.already else {})


def _lines(made: Generated) -> Iterator[str]:
    if made.already:
        yield f"{_count(len(made.already))} there already, seed {made.recipe.seed}"
    if not made.maps:
        return
    from rsegen.exporters.map_summary import size_in_words

    size = size_in_words(made.recipe.grid.shape, made.maps[0].cells)
    yield f"{_count(len(made.maps))} of {size}, seed {made.recipe.seed}:"
    for generated in made.maps[:SHOWN]:
        yield f"  {generated.world}"
    if len(made.maps) > SHOWN:
        yield f"  and {len(made.maps) - SHOWN} more in {made.folder}"
    if made.recipe.is_constrained and (scene := made.maps[0].scene):
        from rsegen.exporters.constraint_report import describe_constraints

        yield from describe_constraints(scene)
    for text in dict.fromkeys(text for generated in made.maps for text in generated.warnings):
        yield f"warning: {text}"
    yield from _how_to_open(made.maps[0], made.folder, made.recipe.simulator)


def _count(maps: int) -> str:
    return f"{maps} map{'s'[: maps > 1]}"


def _how_to_open(first: GeneratedMap, folder: Path, simulator: str) -> Iterator[str]:
    """Yield lines to copy. Worlds name meshes relative to them; Gazebo Classic before 11.3 looks in `.` for them."""
    if simulator == "both":
        yield f"Gazebo Sim:     gz sim {shlex.quote(str(first.world))}"
    yield f"Gazebo Classic: cd {shlex.quote(str(first.folder))} && gazebo {shlex.quote(first.world.name)}"
    if (first.folder / "model.sdf").is_file():
        home = shlex.quote(str(folder.resolve()))
        yield f"as a model (model://{first.name}) in other worlds:"
        yield f"  export GZ_SIM_RESOURCE_PATH={home} IGN_GAZEBO_RESOURCE_PATH={home} GAZEBO_MODEL_PATH={home}"


_ROWS = 12
"""Rows of a series that are printed."""


def add_series(command: Parser) -> None:
    """Add the flags of `rsegen series`."""
    epilog = "docs/difficulty.md defines difficulty, and shows how near the maps come to it."
    command.explain(series.__doc__, epilog)
    add_input(command.add_argument_group("input"))
    add_flags(command.add_argument_group("output"), series, only=declared(generate))
    add_format_rows(command)
    add_flags(command.add_argument_group("difficulty"), series, without=declared(generate))
    add_recipe_flags(command)


def run_series(arguments: argparse.Namespace) -> Report:
    """Make the series, and say how it rises."""
    recipe = recipe_from(arguments)
    options = run_options(series, arguments)
    with going_on(arguments, recipe), counting(recipe.maps) as progress:
        made = call(series, arguments, recipe, **options, progress=progress)
    return Report(lines=_series_lines(made), content=lambda: _series_content(made))


def _series_content(made: Series) -> dict[str, object]:
    rows = [asdict(row) | {"folder": str(made.folder / row.map)} for row in made.rows]
    files = {"table": str(made.table), "picture": str(made.picture)}
    return {"folder": str(made.folder), "seed": made.plan.recipe.seed, **files, "maps": rows}


def _series_lines(made: Series) -> Iterator[str]:
    from rsegen.exporters.numbers import decimal, lengths_in

    rows, there, written = made.rows, len(made.rows) - len(made.maps), lengths_in(made.plan.recipe.units)
    already = f", {there} there already" if there else ""
    yield f"{len(rows)} maps in {made.folder}, seed {made.plan.recipe.seed}{already}; lengths in {written.name}:"
    width, by_default = max(len(row.map) for row in rows), made.plan.by == declared(series)["by"].default
    names, unit = ("rms asked", "rms step") if by_default else ("asked", "measured"), made.plan.metric.unit
    yield f"  {'map':<{width}}" + "".join(f"{name:>12}" for name in ("difficulty", *names, "highest"))
    for row in _some(rows):
        values = (row.asked, unit), (row.measured, unit), (row.highest_step, "m")
        factors = ((value, written.per_metre if of == "m" else 1.0) for value, of in values)
        lengths = ("-" if value is None else f"{value * factor:.2f}" for value, factor in factors)
        yield f"  {row.map:<{width}}{decimal(row.difficulty):>12}" + "".join(f"{text:>12}" for text in lengths)
    if len(rows) > _ROWS:
        yield f"  ({len(rows) - len(_some(rows))} rows between them are left out)"
    for text in dict.fromkeys(text for generated in made.maps for text in generated.warnings):
        yield f"warning: {text}"
    yield f"all of it: {made.table}"
    yield f"a picture: {made.picture}"


def _some(rows: tuple[SeriesRow, ...]) -> list[SeriesRow]:
    """Return all rows, or some that are evenly spaced, with the last."""
    apart = -(-len(rows) // _ROWS)
    return [*rows[:-1:apart], rows[-1]]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Tiles:
    """Write one field of many maps for a curriculum: rows along x from the easiest to the hardest."""

    seed: Annotated[int | None, Integer(0, SEEDS - 1, help="seed of all recipes"), Shell(default="that of each")] = None
    spots: Annotated[
        tuple[float, float] | None,
        ListOf(SIDE, 2, help="add a spot for a start to each tile: a robot's length and width"),
        Shell(metavar="L,W"),
    ] = None
    by: By = "steps.rms"
    robot: ByRobot = None


def add_terrain(command: Parser) -> None:
    """Add the flags of `rsegen terrain`."""
    epilog = "Columns along y are of one recipe each. NAME_0000.json has the difficulty, kind and origin of each tile. "
    command.explain(_Tiles.__doc__, f"{epilog}docs/learning.md shows how to use it for training.")
    text = "YAML or JSON file, or the name of an example; each recipe has the same number of columns"
    add_input(command.add_argument_group("input"), text, name="recipes", nargs="+")
    group = command.add_argument_group("terrain")
    add_flags(group, TerrainDesign)
    add_flags(group, _Tiles)
    add_output_flags(command)


def run_terrain(arguments: argparse.Namespace) -> Report:
    """Write it, and say what was made."""
    from rsegen.io.recipe_file import load
    from rsegen.recipe.examples import or_example
    from rsegen.recipe.terrain import Terrain
    from rsegen.run.single_files import tiles_json

    values = checked_flags(TerrainDesign, arguments) | checked_flags(_Tiles, arguments)
    seed, size = values.pop("seed", None), values.pop("spots", None)
    recipes = [load(or_example(name)) for name in arguments.recipes]
    if seed is not None:
        recipes = [replace(recipe, seed=seed) for recipe in recipes]
    terrain = Terrain(recipes=recipes, **values)
    path = Path(arguments.folder) / f"{terrain.name}_0000.json"
    with counting(terrain.rows * terrain.columns * (1 if size is None else 2), "tile") as progress:
        terrain = replace(terrain, progress=progress)
        report = produce(terrain.recipe, arguments, {path.name: lambda: tiles_json(terrain, size)})
    return report if arguments.json else replace(report, notes=[f"its tiles: {path}"])
