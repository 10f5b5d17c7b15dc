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

from rsegen.errors import OutputError
from rsegen.exporters.formats import Format, exported, options, refuse_unready
from rsegen.exporters.gazebo import Bundle
from rsegen.exporters.scene import compose
from rsegen.io.contents import refuse_link
from rsegen.io.existing import OnExisting
from rsegen.io.existing_formats import holds, missing_formats, refuse_other_map
from rsegen.io.exported_map import ExportedMap
from rsegen.io.joined_exports import joining, plan_joined_export, write_joined
from rsegen.io.record import read_record
from rsegen.io.resources import Needs, check_needs
from rsegen.io.sidecars import FORMATS_FILE, Sidecars, listed_formats
from rsegen.io.work import WORKERS, RunPlan, run
from rsegen.io.writer import FolderWriter, add, folder_writer, refuse_not_a_folder
from rsegen.recipe.recipe import Recipe

_RECIPE = "recipe.json"


@dataclass(frozen=True, kw_only=True, slots=True)
class MapExport:
    """A map to export in some formats; `adds`: into its folder, which exists and keeps everything else."""

    recipe: Recipe
    index: int
    formats: tuple[Format, ...]
    adds: bool = False


ExportsPlan = RunPlan[MapExport, ExportedMap]


def export_maps(  # noqa: PLR0913  # each is a flag of the command
    recipes: Sequence[Recipe],
    folder: str | Path,
    formats: Sequence[Format],
    *,
    force: bool = False,
    resume: bool = False,
    workers: int = 1,
    sync: bool = True,
    progress: Callable[[ExportedMap], None] | None = None,
) -> tuple[ExportedMap, ...]:
    """Write every map of some recipes in other formats as `folder/NAME_000k`, without its world.

    If the map exists already, as a world or exported before, the formats are added and all else stays; `force`
    replaces formats that it has, `resume` keeps those that are complete and have the same options. `workers`, `sync`
    and `progress` are as in `generate`; gives the maps that were written. Raises an OutputError before anything is
    written if a folder of that name holds something else, a format exists already, or two maps have one name; TooLarge
    if memory or disk space are too small. A format that joins the maps, such as `ros2` with a `package`, is alone,
    and writes them into one folder of that name: all of them or none.
    """
    on_existing, folder = OnExisting.of(force=force, resume=resume), Path(folder)
    together = joining(formats)
    if together:
        WORKERS.check("workers", workers)
        refuse_unready(formats)
        maps, _ = _checked_maps(recipes, folder, [together])
        return write_joined(plan_joined_export(maps, folder, together, on_existing), progress, sync=sync)
    return run(plan_exports(recipes, folder, formats, on_existing, workers, sync=sync), progress)


def plan_exports(
    recipes: Sequence[Recipe],
    folder: Path,
    formats: Sequence[Format],
    on_existing: OnExisting,
    workers: int = 1,
    *,
    sync: bool = True,
) -> ExportsPlan:
    """Check that all maps can be exported into a folder, and plan it; nothing is written. Raises as `export_maps`."""
    workers, sidecars = WORKERS.check("workers", workers), Sidecars(formats=tuple(formats))
    for recipe in recipes:
        sidecars.refuse(recipe)
    maps, needs = _checked_maps(recipes, folder, formats)
    planned = [planned_export(recipe, index, folder, sidecars.formats, on_existing) for recipe, index in maps]
    replaces = on_existing is OnExisting.REPLACE
    return RunPlan(
        folder=folder,
        task=ExportTask(folder=folder, replaces=replaces, seconds=_mean_seconds(recipes, sidecars), sync=sync),
        to_make=[one for one in planned if one.formats],
        existing=[one for one in planned if not one.formats],
        needs=needs,
        workers=min(workers, needs.maps_at_once),
        homes=[folder / one.recipe.map_name(one.index) for one in planned if one.adds],
    )


def _checked_maps(
    recipes: Sequence[Recipe], folder: Path, formats: Sequence[Format]
) -> tuple[Sequence[tuple[Recipe, int]], Needs]:
    """Every map of some recipes, and what they need; raises as `export_maps` does."""
    refuse_not_a_folder(folder)
    needs = check_needs(recipes, sum(recipe.maps for recipe in recipes), folder, formats=formats)
    maps = [(recipe, index) for recipe in recipes for index in recipe.indices]
    _refuse_same_names(maps, folder)
    return maps, needs


def planned_export(
    recipe: Recipe, index: int, folder: Path, formats: Sequence[Format], on_existing: OnExisting
) -> MapExport:
    """How a map is exported, in no format if it has them all; an OutputError if it cannot be."""
    home = folder / recipe.map_name(index)
    if not os.path.lexists(home):
        return MapExport(recipe=recipe, index=index, formats=tuple(formats))
    refuse_link(home)
    record = read_record(home)
    if not holds(home, recipe, index):
        refuse_other_map(home, formats, on_existing)
        return MapExport(recipe=recipe, index=index, formats=tuple(formats))
    missing = missing_formats(home, record, formats, on_existing)
    return MapExport(recipe=recipe, index=index, formats=missing, adds=True)


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportTask:
    """Exports maps: all that a worker needs to know."""

    folder: Path
    replaces: bool
    seconds: float
    sync: bool

    def __call__(self, maps: Iterable[MapExport]) -> tuple[ExportedMap, ...]:
        """The maps, on disk."""
        with folder_writer(self.folder, force=self.replaces, sync=self.sync) as writer:
            return tuple(self._export(one, writer) for one in maps)

    def _export(self, one: MapExport, writer: FolderWriter) -> ExportedMap:
        name = one.recipe.map_name(one.index)
        bundle, home = exported(compose(one.recipe, one.index), one.formats), self.folder / name
        if one.adds:
            return ExportedMap(folder=home, names=add(_added(bundle, home, one.formats), home, sync=self.sync))
        return ExportedMap(folder=home, names=writer.write(name, bundle))


def _added(bundle: Bundle, home: Path, formats: Sequence[Format]) -> Bundle:
    """What is added to a map that exists: its recipe.json stays, and formats.json lists the new formats too."""
    listed = {**(listed_formats(str(home)) or {}), **options(formats)}
    text = json.dumps(listed, indent=2) + "\n"
    added = {path: content for path, content in bundle.items() if path != PurePosixPath(_RECIPE)}
    return {**added, PurePosixPath(FORMATS_FILE): [text.encode()]}


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
