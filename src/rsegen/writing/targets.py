"""The maps that a path or name stands for: a recipe file, an example, a map's folder, a folder of maps, or DIR#17.

DIR#17, a map of a data set, can be given wherever a recipe file can; a file of that very name comes first.
"""

from __future__ import annotations

import os.path
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from rsegen.errors import FileError, ParameterError, shown
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.recipe_file import or_example, recipe_in


class ChosenMap(NamedTuple):
    """A map of a recipe, and the file that the recipe is from."""

    file: Path
    recipe: Recipe
    map: int


def recipe_files_in(folder: Path) -> list[Path]:
    """Return the recipe files of the maps in a folder, in the order of their names."""
    return sorted(folder.glob("*/recipe.json"))


def recipe_files(target: str) -> list[Path]:
    """Return a recipe's file, or that of a map's folder, or of every map in a folder; FileError if there is none."""
    path = or_example(target)
    own = path / "recipe.json" if os.path.isdir(target) else path
    files = [own] if own == path or own.is_file() else recipe_files_in(path)
    if not files:
        raise FileError(
            f"{target}: no map in it, nor in its folders (a map's folder has a recipe.json; DIR#0 is one of a data set)"
        )
    return files


def chosen_map(target: str, which: str | None, where: str = "map") -> ChosenMap:
    """Return the given map of a target, or the first; errors about `which` name the flag or parameter `where`."""
    files = recipe_files(target)
    if which is not None and which.isdecimal():  # an index that maps of several recipes in the folder may have
        like = [file.parent.name for file in files if re.fullmatch(rf".*_0*{int(which[:20])}", file.parent.name)]
        if len(like) > 1:
            raise ParameterError(where, f"{shown(which)} may be {' or '.join(like[:3])}; use the full name")
    return one_of(((file, recipe_in(file)) for file in files), which, target, where)


def one_of(
    recipes: Iterable[tuple[Path, Recipe]], which: int | str | None, target: str, where: str = "map"
) -> ChosenMap:
    """Return the given map of some recipes, each with its file, or the first; a message calls them `target`."""
    names = []
    for file, recipe in recipes:
        index = recipe.first_map if which is None else index_of(recipe, str(which))
        if index is not None:
            return ChosenMap(file, recipe, index)
        names += [recipe.map_name(recipe.indices[0]), recipe.map_name(recipe.indices[-1])]
    known = "..".join(dict.fromkeys([names[0], names[-1]]))  # one name of a single map
    raise ParameterError(where, f"there is no map {shown(which)} in {target}; use an index or name, {known}")


def map_index(recipe: Recipe, which: int | str | None) -> int:
    """Return the index of a map of a recipe, given by index or name; the first by default."""
    return one_of([(Path(), recipe)], which, "the recipe").map


def index_of(recipe: Recipe, which: str) -> int | None:
    """Return the index of a recipe's map that is given by index or name; None if it has no such map."""
    digits = which.removeprefix(f"{recipe.name}_")
    return int(digits) if digits.isdecimal() and len(digits) < 20 and int(digits) in recipe.indices else None
