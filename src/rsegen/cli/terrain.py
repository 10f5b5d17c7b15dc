"""rsegen terrain: many maps in one field, in rows of rising difficulty."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rsegen.cli.bar import counting
from rsegen.cli.by_metric import add_by_flags, by_from
from rsegen.cli.flags import Subparsers, describe_flag, flag
from rsegen.cli.generate import add_output_flags, produce
from rsegen.io.recipe_file import load
from rsegen.params.sorts import Parameter, parameters
from rsegen.recipe.examples import or_example
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.terrain import SIZE, Terrain
from rsegen.run.single_files import tiles_json

_SORTS: Mapping[str, Parameter] = {**parameters(Terrain), "seed": parameters(Recipe)["seed"]}


def add(commands: Subparsers) -> None:
    """The parser of this command."""
    command = commands.add_parser(
        "terrain",
        description="Write one field of many maps for a curriculum: rows along x from the easiest to the hardest, "
        "columns along y of one recipe each. NAME_0000.json has the difficulty, kind and origin of each tile.",
        epilog="docs/learning.md shows how to use it for training.",
    )
    text = "YAML or JSON file, or the name of an example; each recipe has the same number of columns"
    command.add_argument_group("input").add_argument("recipes", nargs="+", metavar="RECIPE", help=text)
    group = command.add_argument_group("terrain")
    usual = {name: field.default for name, field in Terrain.__dataclass_fields__.items()} | {"difficulty": "0,1"}
    for name, sort in _SORTS.items():
        _, text = describe_flag(name, sort, usual.get(name))
        if name == "seed":
            text = "seed of all recipes (default: that of each)"
        group.add_argument(flag(name), dest=name, metavar=name.upper(), help=text)
    text = "add an even place for a start to each tile: the length and width of a robot in metres"
    group.add_argument("--spots", metavar="L,W", help=text)
    add_by_flags(group)
    add_output_flags(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Write it, and say what was made."""
    given = {name: getattr(arguments, name) for name in _SORTS}
    values: dict[str, Any] = {
        name: _SORTS[name].check(flag(name), _SORTS[name].parse(text))
        for name, text in given.items()
        if text is not None
    }
    seed = values.pop("seed", None)
    size = None if arguments.spots is None else SIZE.check("--spots", SIZE.parse(arguments.spots))
    terrain = Terrain(recipes=[_recipe(name, seed) for name in arguments.recipes], **values, **by_from(arguments))
    path = arguments.output / f"{terrain.name}_0000.json"
    with counting(terrain.rows * terrain.columns * (1 if size is None else 2), "tile") as progress:
        terrain = replace(terrain, progress=progress)
        recipe = terrain.recipe
        produce(recipe, arguments, {path.name: lambda: tiles_json(terrain, size)})
    if not arguments.json:
        print(f"its tiles: {path}")


def _recipe(name: str, seed: int | None) -> Recipe:
    recipe = load(or_example(name))
    return recipe if seed is None else replace(recipe, seed=seed)
