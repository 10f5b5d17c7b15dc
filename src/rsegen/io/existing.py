"""The maps of a recipe that exist in a folder already, to the byte: a run that is resumed need not make them again.

Folders appear whole or not at all, so a folder whose recipe.json is the one that would be written is that map.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from rsegen.errors import OutputError, ParameterError
from rsegen.io.input_files import open_regular
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe


class OnExisting(Enum):
    """What a run does with maps that exist in its folder already."""

    REFUSE = "refuse them, and make nothing"
    REPLACE = "replace them"
    KEEP = "keep those that are complete, and make the others"

    @classmethod
    def of(cls, *, force: bool, resume: bool) -> OnExisting:
        """What two flags ask for; a ParameterError for both together."""
        if force and resume:
            raise ParameterError("resume", "--resume and --force exclude each other")
        return cls.REPLACE if force else cls.KEEP if resume else cls.REFUSE


def existing_maps(recipe: Recipe, folder: Path, is_complete: Callable[[str], bool]) -> list[int]:
    """The indices of the maps in `folder` that are complete, by what `is_complete` says of a map's folder.

    OutputError for the first folder that has a map's name and holds something else.
    """
    found = []
    for index in _taken(recipe, folder):
        home = os.path.join(folder, recipe.map_name(index))
        refuse_other_map(home, map_json(recipe, index))
        if is_complete(home):
            found.append(index)
    return found


def refuse_other_map(home: str, recipe_file: bytes) -> None:
    """Raise an OutputError if the folder `home` does not hold the map of that recipe.json."""
    if not has_content(os.path.join(home, "recipe.json"), recipe_file):
        raise OutputError(
            f"{home}: is there already and is not this map: its recipe.json is missing, or says another seed, "
            "parameter or version of rsegen; give those of the run that was stopped, or another folder or --name"
        )


def count_complete(recipe: Recipe, folder: Path, is_complete: Callable[[str], bool]) -> int:
    """How many maps of the recipe are complete in `folder`, by what `is_complete` says of a map's folder."""
    return sum(is_complete(os.path.join(folder, recipe.map_name(index))) for index in _taken(recipe, folder))


def is_map_of(recipe: Recipe, name: str) -> bool:
    """Whether a map of the recipe has this name."""
    return _index(recipe, name) is not None


def has_content(path: str, content: bytes) -> bool:
    """Whether a file exists and has this content."""
    try:
        with open_regular(path) as file:
            return file.read(len(content) + 1) == content
    except OSError:
        return False


def _taken(recipe: Recipe, folder: Path) -> list[int]:
    """In order, the indices of the maps whose names are taken: the folder is listed once, however many there are."""
    names = os.listdir(folder) if folder.is_dir() else ()
    found = (_index(recipe, name) for name in names)
    return sorted(index for index in found if index is not None)


def _index(recipe: Recipe, name: str) -> int | None:
    match = re.fullmatch(r"([0-9]{4,19})", name.removeprefix(f"{recipe.name}_"))
    index = int(match[0]) if match else -1
    return index if index in recipe.indices and recipe.map_name(index) == name else None
