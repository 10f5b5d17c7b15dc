"""Writes the build sheet of a map as PDF or CSV files.

Scene --sheet--> the content of a file --write_file--> PDF or CSV
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from rsegen.exporters.scene import Scene, compose
from rsegen.exporters.sheet import CutSettings, refuse_unbuildable, sheet, sheet_format
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.recipe import Recipe
from rsegen.run.store import refuse_taken_file, write_paths


def write_sheets(
    recipe: Recipe,
    index: int,
    paths: Iterable[Path],
    saw: CutSettings | None = None,
    *,
    force: bool = False,
    progress: Callable[[object], None] | None = None,
) -> Scene:
    """Write the build sheet of one map into files, each in the format that its name asks for; gives the map.

    All are made before the first is written; `progress` is called after each page of a PDF. Raises an OutputError if a
    file exists already, unless `force`; TooLarge or a ParameterError if the map cannot have a sheet.
    """
    saw = saw or CutSettings.default(recipe.units)
    formats = {path: sheet_format(path) for path in paths}
    for path in formats:
        refuse_taken_file(path, force=force)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    write_paths({path: sheet(scene, saw, format_, progress=progress) for path, format_ in formats.items()}, force=force)
    return scene
