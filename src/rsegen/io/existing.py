"""The maps of a recipe that exist in a folder already, to the byte: a run that is resumed need not make them again.

A folder whose recipe.json is the one that would be written, and whose files are as its record says, is that map.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from rsegen.errors import OutputError, ParameterError
from rsegen.io.contents import compare, refuse_link, refuse_loss
from rsegen.io.input_files import regular_content
from rsegen.io.record import RECORD, WrittenFile, read_record
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
    """The indices of the maps in `folder` that are kept: complete, by what `is_complete` says of a map's folder.

    OutputError for the first folder that has a map's name and holds something else, or a file that was changed.
    """
    homes = ((index, os.path.join(folder, recipe.map_name(index))) for index in _taken(recipe, folder))
    return [index for index, home in homes if is_kept(Path(home), map_json(recipe, index), is_complete)]


def is_kept(home: Path, recipe_file: bytes, is_complete: Callable[[str], bool]) -> bool:
    """Whether the map of that recipe.json in the folder `home` is kept; if not, the folder may be replaced.

    OutputError if it holds something else than this map, or a file that was changed or would be lost.
    """
    refuse_link(home)
    record = read_record(home)
    if record is None and not _is_cut_off(home):
        _refuse_other_map(home, is_this_map=has_content(str(home / "recipe.json"), recipe_file))
    if record is not None:
        expected = WrittenFile.of(recipe_file)
        _refuse_other_map(home, is_this_map=expected in record.files.get("recipe.json", ()))
        found = compare(home, record)
        for name in found.changed:
            raise OutputError(
                f"{home / name}: was changed after rsegen wrote it; delete it to have the map made again, or give "
                "another folder"
            )
        if not found.damaged and is_complete(str(home)):
            return True
    refuse_loss(home, "map")
    return False


def _refuse_other_map(home: Path, *, is_this_map: bool) -> None:
    if not is_this_map:
        raise OutputError(
            f"{home}: exists already and is not this map: its recipe.json is missing, or says another seed, "
            "parameter or version of rsegen; give those of the run that was stopped, or another folder or --name"
        )


def _is_cut_off(home: Path) -> bool:
    """Whether a power failure left the record of a folder empty."""
    path = home / RECORD
    return path.is_file() and not path.stat().st_size


def count_complete(recipe: Recipe, folder: Path, is_complete: Callable[[str], bool]) -> int:
    """How many maps of the recipe are complete in `folder`, by what `is_complete` says of a map's folder."""
    return sum(is_complete(os.path.join(folder, recipe.map_name(index))) for index in _taken(recipe, folder))


def is_map_of(recipe: Recipe, name: str) -> bool:
    """Whether a map of the recipe has this name."""
    return _index(recipe, name) is not None


def has_content(path: str, content: bytes) -> bool:
    """Whether a file exists and has this content."""
    return regular_content(path, len(content) + 1) == content


def _taken(recipe: Recipe, folder: Path) -> list[int]:
    """In order, the indices of the maps whose names are taken: the folder is listed once, however many there are."""
    names = os.listdir(folder) if folder.is_dir() else ()
    found = (_index(recipe, name) for name in names)
    return sorted(index for index in found if index is not None)


def _index(recipe: Recipe, name: str) -> int | None:
    match = re.fullmatch(r"([0-9]{4,19})", name.removeprefix(f"{recipe.name}_"))
    index = int(match[0]) if match else -1
    return index if index in recipe.indices and recipe.map_name(index) == name else None
