"""From recipes to files of other programs on disk, and to build sheets, without worlds.

Recipe --compose--> Scene --exported--> Bundle --write--> files
Recipe --compose--> Scene --sheet--> a PDF and a CSV
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.formats import Format, bytes_a_cell, exported, refuse_unready
from rsegen.recipe import Recipe
from rsegen.room import refuse_too_large, refuse_too_many
from rsegen.scene import Scene, compose
from rsegen.sheet import Saw, refuse_unbuildable, sheet, sheet_format
from rsegen.writer import refuse_not_a_folder, refuse_taken, refuse_taken_file, write, write_file


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportedMap:
    """One map in other formats on disk: its folder, and the names of the files in it."""

    folder: Path
    names: tuple[str, ...]


def export_maps(
    recipes: Sequence[Recipe],
    folder: str | Path,
    formats: Sequence[Format],
    *,
    force: bool = False,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write every map of some recipes in other formats, without its world, as `folder/NAME_000k`.

    `force` replaces what was exported before, never a world. Raises an OutputError before anything is written where a
    map's folder is taken, or two maps have one name; TooLarge where there is no room for the maps.
    """
    folder = Path(folder)
    refuse_unready(formats)
    refuse_not_a_folder(folder)
    for recipe in recipes:
        refuse_too_large(recipe, bytes_a_cell(formats))
    refuse_too_many(sum(recipe.maps for recipe in recipes), folder)
    _refuse_unfit(recipes, folder, force=force)
    made = []
    for recipe in recipes:
        for index in recipe.indices:
            bundle, home = exported(compose(recipe, index), formats), folder / recipe.map_name(index)
            made.append(ExportedMap(folder=home, names=write(bundle, home, force=force)))
            if progress:
                progress(made[-1])
    return tuple(made)


def write_sheets(
    recipe: Recipe,
    index: int,
    paths: Iterable[Path],
    saw: Saw | None = None,
    *,
    force: bool = False,
    progress: Callable[[object], None] | None = None,
) -> Scene:
    """Write the build sheet of one map into files, each in the format that its name asks for; gives the map.

    Nothing is written before all of them are made; `progress` is told of each page of a PDF. Raises an OutputError
    where a file is there already, unless `force`; TooLarge or a ParameterError where the map has no sheet.
    """
    saw = saw or Saw()
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


def _refuse_unfit(recipes: Sequence[Recipe], folder: Path, *, force: bool) -> None:
    """Raise an OutputError where two maps have one name, a folder is taken, or a world would be replaced."""
    seen = set()
    for name in (recipe.map_name(index) for recipe in recipes for index in recipe.indices):
        if name in seen:
            raise OutputError(f"{folder / name}: two of the maps have this name; export them into folders of their own")
        seen.add(name)
        refuse_taken([folder / name], force=force)
        if (folder / name / f"{name}.world").exists():
            raise OutputError(f"{folder / name}: has a world in it, so it is not replaced; give another folder")
