"""Writes maps in the formats of other programs, without worlds, or adds formats to maps that exist.

recipes --plan_exports--> ExportsPlan --run: compose, exported, write or add, for each map--> ExportedMap of each
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import fsum, prod
from pathlib import Path, PurePosixPath

from rsegen.errors import OutputError, UserError
from rsegen.exporters.formats import Format, exported, options
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.scene import compose
from rsegen.io.existing import has_content, is_map_of
from rsegen.io.recipe_file import load
from rsegen.io.resources import check_needs
from rsegen.io.sidecars import FORMATS_FILE, Sidecars, listed_formats
from rsegen.io.work import WORKERS, RunPlan, run
from rsegen.io.writer import add, refuse_not_a_folder, refuse_not_ours, write
from rsegen.recipe.codec import map_json
from rsegen.recipe.recipe import Recipe

_RECIPE = "recipe.json"


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportedMap:
    """One map in other formats on disk: its folder, and the names of the files that were written into it."""

    folder: Path
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MapExport:
    """A map to export; `adds`: into its folder, which exists and keeps everything else."""

    recipe: Recipe
    index: int
    adds: bool


ExportsPlan = RunPlan[MapExport, ExportedMap]


def export_maps(
    recipes: Sequence[Recipe],
    folder: str | Path,
    formats: Sequence[Format],
    *,
    force: bool = False,
    workers: int = 1,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write every map of some recipes in other formats as `folder/NAME_000k`, without its world.

    If the map is there already, as a world or exported before, the formats are added and all else stays; `force`
    replaces formats that it has. `workers` and `progress` are as in `generate`. Raises an OutputError before anything
    is written if a folder of that name holds something else, a format is there already, or two maps have one name;
    TooLarge if memory or disk space are too small.
    """
    return run(plan_exports(recipes, Path(folder), formats, force=force, workers=workers), progress)


def plan_exports(
    recipes: Sequence[Recipe], folder: Path, formats: Sequence[Format], *, force: bool = False, workers: int = 1
) -> ExportsPlan:
    """Check that all maps can be exported into a folder, and plan it; nothing is written. Raises as `export_maps`."""
    workers, sidecars = WORKERS.check("workers", workers), Sidecars(formats=tuple(formats))
    for recipe in recipes:
        sidecars.refuse(recipe)
    refuse_not_a_folder(folder)
    needs = check_needs(recipes, sum(recipe.maps for recipe in recipes), folder, sidecars.bytes_per_cell)
    maps = [(recipe, index) for recipe in recipes for index in recipe.indices]
    _refuse_same_names(maps, folder)
    seconds = _mean_seconds(recipes, sidecars)
    task = ExportTask(folder=folder, formats=sidecars.formats, force=force, seconds=seconds)
    return RunPlan(
        folder=folder,
        task=task,
        to_make=[task.planned(recipe, index) for recipe, index in maps],
        makes=lambda name: any(is_map_of(recipe, name) for recipe in recipes),
        needs=needs,
        workers=min(workers, needs.maps_at_once),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportTask:
    """Exports maps: all that a worker needs to know."""

    folder: Path
    formats: Sequence[Format]
    force: bool
    seconds: float

    def planned(self, recipe: Recipe, index: int) -> MapExport:
        """How a map is exported; an OutputError if it cannot be."""
        home, names = self.folder / recipe.map_name(index), [each.name for each in self.formats]
        if not os.path.lexists(home):
            return MapExport(recipe, index, adds=False)
        refuse_not_ours(home)
        if _holds(home, recipe, index):
            _refuse_taken_formats(home, names, force=self.force)
            return MapExport(recipe, index, adds=True)
        _refuse_loss(home, names, force=self.force)
        return MapExport(recipe, index, adds=False)

    def __call__(self, maps: Iterable[MapExport]) -> tuple[ExportedMap, ...]:
        """The maps, on disk."""
        return tuple(map(self._export, maps))

    def _export(self, one: MapExport) -> ExportedMap:
        home = self.folder / one.recipe.map_name(one.index)
        bundle = exported(compose(one.recipe, one.index), self.formats)
        if one.adds:
            return ExportedMap(folder=home, names=add(self._added(bundle, home), home))
        return ExportedMap(folder=home, names=write(bundle, home, force=self.force))

    def _added(self, bundle: Bundle, home: Path) -> Bundle:
        """What is added to a map that exists: its recipe.json stays, and formats.json lists the new formats too."""
        listed = {**(listed_formats(str(home)) or {}), **options(self.formats)}
        text = json.dumps(listed, indent=2) + "\n"
        added = {path: content for path, content in bundle.items() if path != PurePosixPath(_RECIPE)}
        return {**added, PurePosixPath(FORMATS_FILE): [text.encode()]}


def _holds(home: Path, recipe: Recipe, index: int) -> bool:
    """Whether a folder holds this map, whatever version of rsegen wrote its recipe.json."""
    if has_content(str(home / _RECIPE), map_json(recipe, index)):
        return True
    try:
        return load(home / _RECIPE) == recipe.alone(index)
    except UserError:
        return False


def _refuse_taken_formats(home: Path, names: Sequence[str], *, force: bool) -> None:
    """Raise an OutputError if a map has one of the formats and may not lose it."""
    listed = listed_formats(str(home))
    if listed is None:
        raise OutputError(f"{home / FORMATS_FILE}: is damaged, so no format is added; give another folder")
    for name in (name for name in names if os.path.lexists(home / name)):
        if name not in listed or (home / name).is_symlink() or not (home / name).is_dir():
            raise OutputError(f"{home / name}: was not exported by rsegen, so it is not replaced; give another folder")
        if not force:
            raise OutputError(f"{home / name}: is there already; give --force to replace it, or another folder")


def _refuse_loss(home: Path, names: Sequence[str], *, force: bool) -> None:
    """Raise an OutputError unless another map in the folder may be replaced, and nothing is lost but these formats."""
    others = sorted({path.name for path in home.iterdir()} - {_RECIPE, FORMATS_FILE, *names})
    if f"{home.name}.world" in others:
        raise OutputError(f"{home}: has the world of another map in it, so it is not replaced; give another folder")
    if not force:
        raise OutputError(
            f"{home}: is there already and is another map, of another seed or parameter; "
            "give --force to replace it, or another folder or --name"
        )
    if others:
        raise OutputError(
            f"{home}: has {others[0]} of another map in it, which would be lost; "
            "name all of its formats to replace them, or give another folder"
        )


def _mean_seconds(recipes: Sequence[Recipe], sidecars: Sidecars) -> float:
    """About how long a map takes, in the mean."""
    maps = sum(recipe.maps for recipe in recipes)
    return fsum(recipe.maps / maps * sidecars.seconds(prod(recipe.grid.shape)) for recipe in recipes)


def _refuse_same_names(maps: Iterable[tuple[Recipe, int]], folder: Path) -> None:
    """Raise an OutputError if two maps have one name."""
    seen = set()
    for name in (recipe.map_name(index) for recipe, index in maps):
        if name in seen:
            raise OutputError(f"{folder / name}: two of the maps have this name; export them into folders of their own")
        seen.add(name)
