"""From recipes to files of other programs on disk, without worlds.

Recipe --compose--> Scene --exported--> Bundle --write--> files
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import fsum, prod
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.exporters.formats import Format, bytes_a_cell, exported, refuse_unready
from rsegen.exporters.scene import compose
from rsegen.io.resources import maps_in_memory, refuse_too_large, refuse_too_many
from rsegen.io.sidecars import Sidecars
from rsegen.io.work import WORKERS, run_in_order
from rsegen.io.writer import refuse_not_a_folder, refuse_taken, write
from rsegen.recipe.recipe import Recipe


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
    workers: int = 1,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write every map of some recipes in other formats, without its world, as `folder/NAME_000k`.

    `force` replaces what was exported before, never a world; `workers` and `progress` are as in `generate`. Raises an
    OutputError before anything is written where a map's folder is taken, or two maps have one name; TooLarge where
    there is no room for the maps.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    refuse_unready(formats)
    refuse_not_a_folder(folder)
    for recipe in recipes:
        refuse_too_large(recipe, bytes_a_cell(formats))
    refuse_too_many(sum(recipe.maps for recipe in recipes), folder)
    _refuse_unfit(recipes, folder, force=force)
    order = _Order(
        folder=folder,
        formats=tuple(formats),
        force=force,
        seconds=_seconds(recipes, formats),
        at_once=min((maps_in_memory(recipe, bytes_a_cell(formats)) for recipe in recipes), default=1),
    )
    maps = [(recipe, index) for recipe in recipes for index in recipe.indices]
    return run_in_order(order, maps, workers, progress)


_Map = tuple[Recipe, int]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Order:
    """In which formats to write maps, where and how."""

    folder: Path
    formats: tuple[Format, ...]
    force: bool
    seconds: float
    at_once: int

    def map_name(self, one: _Map) -> str:
        recipe, index = one
        return recipe.map_name(index)

    def __call__(self, maps: Iterable[_Map]) -> tuple[ExportedMap, ...]:
        return tuple(map(self.made, maps))

    def made(self, one: _Map) -> ExportedMap:
        bundle, home = exported(compose(*one), self.formats), self.folder / self.map_name(one)
        return ExportedMap(folder=home, names=write(bundle, home, force=self.force))


def _seconds(recipes: Sequence[Recipe], formats: Sequence[Format]) -> float:
    """About how long a map takes, in the mean."""
    extras, maps = Sidecars(formats=formats), sum(recipe.maps for recipe in recipes)
    return fsum(recipe.maps / maps * extras.seconds(prod(recipe.grid.shape)) for recipe in recipes)


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
