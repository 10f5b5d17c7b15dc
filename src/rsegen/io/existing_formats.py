"""The formats that a map in a folder has already: those that are kept, and those that may be replaced."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from rsegen.errors import OutputError, UserError
from rsegen.exporters.formats import Format, options
from rsegen.io.contents import compare, refuse_link, refuse_loss
from rsegen.io.existing import OnExisting, has_content
from rsegen.io.former import former_files
from rsegen.io.recipe_file import load
from rsegen.io.record import RECORD, Record
from rsegen.io.sidecars import FORMATS_FILE, listed_formats
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe

_RECIPE = "recipe.json"


def holds(home: Path, recipe: Recipe, index: int) -> bool:
    """Whether a folder holds this map, whatever version of rsegen wrote its recipe.json."""
    if has_content(str(home / _RECIPE), map_json(recipe, index)):
        return True
    try:
        return load(home / _RECIPE) == recipe.alone(index)
    except UserError:
        return False


def missing_formats(
    home: Path, record: Record | None, formats: Sequence[Format], on_existing: OnExisting
) -> tuple[Format, ...]:
    """The formats to write for a map that exists; an OutputError if it has one that may not be replaced."""
    listed = listed_formats(str(home))
    if listed is None:
        raise OutputError(f"{home / FORMATS_FILE}: is damaged, so no format is added; give another folder")
    refuse_link(home / FORMATS_FILE)
    missing = []
    for one in formats:
        exists = os.path.lexists(home / one.name)
        if exists:
            _refuse_foreign_format(home, record, one.name)
        if exists and on_existing is OnExisting.REFUSE:
            raise OutputError(f"{home / one.name}: exists already; give --force to replace it, or another folder")
        same = listed.get(one.name) == options([one])[one.name]
        if not (exists and on_existing is OnExisting.KEEP and same and _is_intact(home, record, one.name)):
            missing.append(one)
    return tuple(missing)


def _is_intact(home: Path, record: Record | None, name: str) -> bool:
    """Whether the folder of a format has every file of the record; that of 0.1, without one, need only be listed."""
    return record is None or compare(home, record, name).is_intact


def _refuse_foreign_format(home: Path, record: Record | None, name: str) -> None:
    """Raise an OutputError if the folder of a format has anything in it that rsegen did not write."""
    refuse_link(home / name)
    is_former = former_files(home, "map")
    foreign: Sequence[str] = [name] if not (home / name).is_dir() else []
    if record is not None:
        found = compare(home, record, name)
        foreign = [*foreign, *found.foreign, *found.changed]
    elif not is_former(f"{name}/"):
        foreign = [name]
    for path in foreign:
        raise OutputError(f"{home / path}: was not exported by rsegen, so it is not replaced; give another folder")


def refuse_other_map(home: Path, formats: Sequence[Format], on_existing: OnExisting) -> None:
    """Raise an OutputError unless another map in the folder may be replaced, and nothing is lost but these formats."""
    refuse_loss(home, "map")
    names = {_RECIPE, FORMATS_FILE, RECORD, *(each.name for each in formats)}
    others = sorted({path.name for path in home.iterdir()} - names)
    if f"{home.name}.world" in others:
        raise OutputError(f"{home}: has the world of another map in it, so it is not replaced; give another folder")
    if on_existing is not OnExisting.REPLACE:
        raise OutputError(
            f"{home}: exists already and is another map, of another seed or parameter; "
            "give --force to replace it, or another folder or --name"
        )
    if others:
        raise OutputError(
            f"{home}: has {others[0]} of another map in it, which would be lost; "
            "name all of its formats to replace them, or give another folder"
        )
