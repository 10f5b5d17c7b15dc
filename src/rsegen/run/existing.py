"""The maps of a recipe that exist in a folder already, to the byte: a run that is resumed need not make them again.

A folder whose recipe.json is the one that would be written, and whose files are as its journal says, is that map.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.io.checksums import Checksum
from rsegen.io.input_files import regular_content
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe
from rsegen.run.journal import compare, read_errors, read_journal, refuse_link, refuse_loss


def existing_maps(recipe: Recipe, folder: Path, is_complete: Callable[[str], bool]) -> list[int]:
    """Return the indices of the maps in `folder` that are kept: complete, by what `is_complete` says of a map's folder.

    OutputError for the first folder that has a map's name and holds something else, or a file that was changed.
    """
    names = os.listdir(folder) if folder.is_dir() else ()
    indices = (map_index_of(recipe, name) for name in names)
    homes = ((index, folder / recipe.map_name(index)) for index in sorted(one for one in indices if one is not None))
    return [index for index, home in homes if is_kept(home, map_json(recipe, index), is_complete)]


def is_kept(home: Path, recipe_file: bytes, is_complete: Callable[[str], bool]) -> bool:
    """Return whether the map of that recipe.json in the folder `home` is kept; if not, the folder may be replaced.

    OutputError if it holds something else than this map, or a file that was changed or would be lost.
    """
    refuse_link(home)
    with read_errors(home):
        journal = read_journal(home)
        if journal is None or Checksum.of(recipe_file) not in journal.files.get("recipe.json", ()):
            raise OutputError(
                f"{home}: exists already and is not this map of rsegen: its journal is missing, or says another seed, "
                "parameter or version; give those of the run that was stopped, or another folder or --name"
            )
        found = compare(home, journal)
    for name in found.changed:
        raise OutputError(
            f"{home / name}: was changed after rsegen wrote it; delete it to have the map made again, or give "
            "another folder"
        )
    if not found.missing and is_complete(str(home)):
        return True
    refuse_loss(home, "map")
    return False


def has_content(path: str, content: bytes) -> bool:
    """Return whether a file exists and has this content."""
    return regular_content(path, len(content) + 1) == content


def map_index_of(recipe: Recipe, name: str) -> int | None:
    """Return the index of the recipe's map of this name, None if it has no such map."""
    match = re.fullmatch(r"([0-9]{4,19})", name.removeprefix(f"{recipe.name}_"))
    index = int(match[0]) if match else -1
    return index if index in recipe.indices and recipe.map_name(index) == name else None
