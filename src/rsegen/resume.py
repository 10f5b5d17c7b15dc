"""Which maps of a recipe are there already, to the byte: what a run that was stopped need not make again.

Folders appear whole or not at all, so a folder with a world whose recipe.json is the one that would be written is that
map. With pictures and other formats it is complete if it has these too, the formats with the same options.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from rsegen.codec import to_json
from rsegen.errors import OutputError
from rsegen.params import Json
from rsegen.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Wanted:
    """What a map is to have beside its world: a picture, and formats with their options as formats.json says them."""

    preview: bool = False
    formats: dict[str, Json] = field(default_factory=dict)

    def stands(self, home: str) -> bool:
        """Whether a map's folder has its world, and all of this."""
        if not os.path.isfile(os.path.join(home, f"{os.path.basename(home)}.world")):
            return False
        if self.preview and not os.path.isfile(os.path.join(home, "preview.png")):
            return False
        there = _formats(home) if self.formats else {}
        return all(there.get(name) == options for name, options in self.formats.items())


def complete(recipe: Recipe, folder: Path, wanted: Wanted) -> frozenset[int]:
    """The indices of the maps that stand in `folder` with all that is wanted.

    OutputError for the first folder that has a map's name and holds something else.
    """
    expected = recipe_files(recipe)
    found = set()
    for index in _taken(recipe, folder):
        home = os.path.join(folder, recipe.map_name(index))
        if not _holds(os.path.join(home, "recipe.json"), expected(index)):
            raise OutputError(
                f"{home}: is there already and is not this map: its recipe.json is missing, or says another seed, "
                "parameter or version of rsegen; give those of the run that was stopped, or another folder or --name"
            )
        if wanted.stands(home):
            found.add(index)
    return frozenset(found)


def recipe_files(recipe: Recipe) -> Callable[[int], bytes]:
    """What gives recipe.json of map `index`: the text of the first, in which only the index is another."""
    first = recipe.first_map
    line = b'\n  "first_map": %d,\n'
    before, _, after = to_json(replace(recipe, maps=1)).encode().partition(line % first)
    return lambda index: before + line % index + after


def is_map_of(recipe: Recipe, name: str) -> bool:
    """Whether a map of the recipe is called so."""
    return _index(recipe, name) is not None


def standing(recipe: Recipe, folder: Path, wanted: Wanted) -> int:
    """How many maps of a run that was stopped stand in `folder`, with all that is wanted."""
    return sum(wanted.stands(os.path.join(folder, recipe.map_name(index))) for index in _taken(recipe, folder))


def _taken(recipe: Recipe, folder: Path) -> list[int]:
    """In order, the indices of the maps whose names are taken: one look into the folder, however many there are."""
    names = os.listdir(folder) if folder.is_dir() else ()
    found = (_index(recipe, name) for name in names)
    return sorted(index for index in found if index is not None)


def _index(recipe: Recipe, name: str) -> int | None:
    match = re.fullmatch(r"([0-9]{4,19})", name.removeprefix(f"{recipe.name}_"))
    index = int(match[0]) if match else -1
    return index if index in recipe.indices and recipe.map_name(index) == name else None


def _formats(home: str) -> dict[str, Json]:
    """The formats that are there, with their options; none where the file that lists them is no such list."""
    try:
        with open(os.path.join(home, "formats.json"), "rb") as file:
            found = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _holds(path: str, content: bytes) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(len(content) + 1) == content
    except OSError:
        return False
