"""Build sheets on disk.

Scene --sheet--> the content of a file --write_file--> PDF or CSV
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from rsegen.exporters.scene import Scene, compose
from rsegen.exporters.sheet import CutSettings, refuse_unbuildable, sheet, sheet_format
from rsegen.io.resources import refuse_too_large
from rsegen.io.writer import refuse_taken_file, write_file
from rsegen.recipe.recipe import Recipe


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

    Nothing is written before all of them are made; `progress` is told of each page of a PDF. Raises an OutputError
    where a file is there already, unless `force`; TooLarge or a ParameterError where the map has no sheet.
    """
    saw = saw or CutSettings()
    formats = {path: sheet_format(path) for path in paths}
    for path in formats:
        refuse_taken_file(path, force=force)
    refuse_too_large(recipe)
    refuse_unbuildable(recipe, saw)
    scene = compose(recipe, index)
    made = {path: sheet(scene, saw, format_, progress=progress) for path, format_ in formats.items()}
    for path, content in made.items():
        write_file([content], path, force=force)
    return scene
