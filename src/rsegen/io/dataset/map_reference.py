"""Reads DIR#17, one map of a data set, wherever a recipe file can be given; and finds the folder of a data set."""

from __future__ import annotations

import os.path
import re
from pathlib import Path

from rsegen.errors import ParameterError
from rsegen.io.recipe_file import load
from rsegen.recipe.recipe import Recipe


def recipe_in(path: str | Path) -> Recipe:
    """The recipe in a file or, if there is no such file, of the map of a data set that DIR#INDEX names."""
    match = re.fullmatch(r"(.+)#([0-9]{1,19})", str(path))
    if not match or os.path.lexists(path):
        return load(path)
    from rsegen.io.dataset.manifest import read_manifest

    layout, place = read_manifest(Path(match[1]))[0], int(match[2])
    if place >= layout.maps:
        raise ParameterError(str(path), f"there is no map {place} in the data set; give 0..{layout.maps - 1}")
    recipe, index = layout.map_at(place)
    return recipe.alone(index)


def dataset_at(path: Path) -> Path | None:
    """The folder of a data set, if the path is a folder or a manifest; else None."""
    if path.is_dir():
        return path
    from rsegen.io.dataset.manifest import MANIFEST

    return path.parent if path.name == MANIFEST and path.is_file() else None
