"""The command `rsegen terrain`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rsegen.cli.flags import add_input
from rsegen.cli.generate import add_output_flags, produce
from rsegen.cli.parser import Parser
from rsegen.cli.report import Report, checked_flags, counting
from rsegen.field.crossing import SIDE
from rsegen.learning.terrain_design import TerrainDesign
from rsegen.measuring.parameters import By, ByRobot
from rsegen.params.command import Shell, add_flags
from rsegen.params.sorts import Integer, ListOf
from rsegen.params.streams import SEEDS

if TYPE_CHECKING:
    from rsegen.learning.terrain import Terrain


@dataclass(frozen=True, kw_only=True, slots=True)
class _Tiles:
    """Write one field of many maps for a curriculum: rows along x from the easiest to the hardest."""

    seed: Annotated[int | None, Integer(0, SEEDS - 1, help="seed of all recipes"), Shell(default="that of each")] = None
    spots: Annotated[
        Sequence[float] | None,
        ListOf(SIDE, 2, help="add a start spot to each tile, for a robot of this length and width"),
        Shell(metavar="L,W"),
    ] = None
    by: By = "steps.rms"
    robot: ByRobot = None


def add_terrain(command: Parser) -> None:
    """Add the flags of `rsegen terrain`."""
    epilog = "Each column along y is of one recipe. NAME_0000.json has the difficulty, kind and origin of each tile. "
    command.explain(_Tiles.__doc__, f"{epilog}docs/learning.md shows how to use it for training.")
    text = "YAML or JSON file, or the name of an example; each recipe has the same number of columns"
    add_input(command.group("input"), text, name="recipes", nargs="+")
    group = command.group("terrain")
    add_flags(group, TerrainDesign)
    add_flags(group, _Tiles)
    add_output_flags(command)


def run_terrain(arguments: argparse.Namespace) -> Report:
    """Write the terrain as a map, and the list of its tiles next to it."""
    from rsegen.learning.terrain import Terrain
    from rsegen.recipe.recipe_file import load, or_example

    values = checked_flags(TerrainDesign, arguments) | checked_flags(_Tiles, arguments)
    seed, size = values.pop("seed", None), values.pop("spots", None)
    recipes = [load(or_example(name)) for name in arguments.recipes]
    if seed is not None:
        recipes = [replace(recipe, seed=seed) for recipe in recipes]
    terrain = Terrain(recipes=recipes, **values)
    path = Path(arguments.folder) / f"{terrain.name}_0000.json"
    with counting(terrain.rows * terrain.columns, "tile") as progress:
        terrain = replace(terrain, progress=progress)  # the bar needs a count, which the terrain has checked
        report = produce(terrain.recipe, arguments, {path.name: lambda: tiles_json(terrain, size)})
    return report if arguments.json else replace(report, notes=[f"its tiles: {path}"])


def tiles_json(terrain: Terrain, robot_size: tuple[float, float] | None = None) -> bytes:
    """Return the content of NAME_0000.json: difficulty, kind, map and origin of each tile; metres, radians.

    robot_size: length and width of a robot, for which each tile gets a spot to start at
    """
    spots = {} if robot_size is None else {"spots": terrain.spots(robot_size)[:, :, 0].tolist()}
    tiles = {
        "name": terrain.name,
        "tile_size": list(terrain.tile_size),
        "difficulty": terrain.difficulties.tolist(),
        "kinds": list(terrain.kinds),
        "maps": terrain.maps.tolist(),
        "origins": terrain.origins.tolist(),
        **spots,
    }
    return json.dumps(tiles).encode() + b"\n"
