"""Which maps of a recipe are there already, to the byte: what a run that was stopped need not make again.

Folders appear whole or not at all, so a folder whose recipe.json is the one that would be written is that map.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe


def complete(recipe: Recipe, folder: Path, stand: Callable[[str], bool]) -> frozenset[int]:
    """The indices of the maps in `folder` of which `stand` says that all is there that is asked for.

    OutputError for the first folder that has a map's name and holds something else.
    """
    found = set()
    for index in _taken(recipe, folder):
        if is_complete(os.path.join(folder, recipe.map_name(index)), map_json(recipe, index), stand):
            found.add(index)
    return frozenset(found)


def is_complete(home: str, recipe_file: bytes, stand: Callable[[str], bool]) -> bool:
    """Whether the map of that recipe.json, which stands in `home`, has all that is asked for; else an OutputError."""
    if not _holds(os.path.join(home, "recipe.json"), recipe_file):
        raise OutputError(
            f"{home}: is there already and is not this map: its recipe.json is missing, or says another seed, "
            "parameter or version of rsegen; give those of the run that was stopped, or another folder or --name"
        )
    return stand(home)


def is_map_of(recipe: Recipe, name: str) -> bool:
    """Whether a map of the recipe is called so."""
    return _index(recipe, name) is not None


def standing(recipe: Recipe, folder: Path, stand: Callable[[str], bool]) -> int:
    """How many maps of a run that was stopped stand in `folder`, with all that is asked for."""
    return sum(stand(os.path.join(folder, recipe.map_name(index))) for index in _taken(recipe, folder))


def _taken(recipe: Recipe, folder: Path) -> list[int]:
    """In order, the indices of the maps whose names are taken: one look into the folder, however many there are."""
    names = os.listdir(folder) if folder.is_dir() else ()
    found = (_index(recipe, name) for name in names)
    return sorted(index for index in found if index is not None)


def _index(recipe: Recipe, name: str) -> int | None:
    match = re.fullmatch(r"([0-9]{4,19})", name.removeprefix(f"{recipe.name}_"))
    index = int(match[0]) if match else -1
    return index if index in recipe.indices and recipe.map_name(index) == name else None


def _holds(path: str, content: bytes) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(len(content) + 1) == content
    except OSError:
        return False
