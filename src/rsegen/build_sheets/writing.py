"""Write build sheets: all are made before the first file is written, whole or not at all (`writing/store.py`)."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rsegen.build_sheets.cut_settings import CutSettings
from rsegen.build_sheets.document import refuse_unbuildable, sheet, sheet_format
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene, compose
from rsegen.writing.resources import refuse_too_large
from rsegen.writing.store import refuse_taken_file, write_files


def write_sheets(
    recipe: Recipe, index: int, paths: Iterable[Path], saw: CutSettings | None = None, *, force: bool = False
) -> Scene:
    """Write the build sheet of one map into files, each in the format that its name asks for; gives the map.

    All are made before the first is written. Raises an OutputError if a file exists already, unless `force`; TooLarge
    or a ParameterError if the map cannot have a sheet.
    """
    # Everything that may be wrong is checked first, as a map and its sheet take their time.
    saw = saw or CutSettings.default(recipe.units)
    formats = {path: sheet_format(path) for path in paths}
    for path in formats:
        refuse_taken_file(path, force=force)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    write_files({path: [sheet(scene, saw, format_)] for path, format_ in formats.items()}, force=force)
    return scene
