"""What a command can look at: a recipe file, the folder of a map, or a folder of such folders."""

from __future__ import annotations

import argparse
import os.path
from collections.abc import Sequence
from pathlib import Path

from rsegen.errors import FileError, ParameterError, shown
from rsegen.recipe import Recipe
from rsegen.recipe_file import load
from rsegen.room import refuse_too_large
from rsegen.scene import Scene, compose


def add_target_flags(command: argparse.ArgumentParser) -> None:
    """Where to look, and which map."""
    where = "a recipe (YAML, JSON), the folder of a map, or a folder of maps"
    command.add_argument("target", metavar="RECIPE-or-DIR", help=where)
    command.add_argument("--map", metavar="INDEX", help="which map, by its index or its name (default: the first)")


def recipes(target: str) -> Sequence[Recipe]:
    """The recipe of a file or of a map's folder, or of every map in a folder; FileError where there is none."""
    path = Path(target)
    if not os.path.isdir(target):
        return [load(path)]
    own = path / "recipe.json"
    files = [own] if own.is_file() else sorted(path.glob("*/recipe.json"))
    if not files:
        raise FileError(f"{target}: no map in it, nor in its folders (a map's folder has a recipe.json)")
    return [load(file) for file in files]


def chosen(target: str, which: str | None) -> Scene:
    """The scene of one map of `target`: the given one, or the first."""
    found = recipes(target)
    for recipe in found:
        index = recipe.first_map if which is None else _index(recipe, which)
        if index is not None:
            refuse_too_large(recipe)
            return compose(recipe, index)
    first, last = found[0].map_name(found[0].indices[0]), found[-1].map_name(found[-1].indices[-1])
    raise ParameterError("--map", f"there is no map {shown(which)} in {target}; give an index or name, {first}..{last}")


def _index(recipe: Recipe, which: str) -> int | None:
    digits = which.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and len(digits) < 20 and int(digits) in recipe.indices else None
