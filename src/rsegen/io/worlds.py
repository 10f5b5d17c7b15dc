"""Writes the worlds of a recipe: `generate` is what the command line, the window and scripts call.

Recipe --plan_worlds--> WorldsPlan --make_worlds: compose, export, write, for each map--> Generated
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rsegen.exporters.formats import Format
from rsegen.exporters.gazebo import export
from rsegen.exporters.map_summary import warnings
from rsegen.exporters.scene import Scene, compose
from rsegen.io.existing import OnExisting, existing_maps
from rsegen.io.resources import check_needs
from rsegen.io.sidecars import Sidecars
from rsegen.io.work import WORKERS, RunPlan, run
from rsegen.io.writer import FolderWriter, folder_writer, refuse_not_a_folder, refuse_taken
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedMap:
    """One map on disk: its files, size (cells with frames, metres), number of blocks of each level, and warnings.

    `home` is the folder that all maps are in, `names` are those of the files in this map's own.
    """

    name: str
    index: int
    home: Path
    names: tuple[str, ...]
    cells: tuple[int, int]
    extent: tuple[float, float]
    level_counts: dict[int, int]
    warnings: tuple[str, ...]

    @property
    def folder(self) -> Path:
        """The map's own folder."""
        return self.home / self.name

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that were written."""
        return tuple(self.folder / name for name in self.names)

    @property
    def world(self) -> Path:
        """The file that a simulator opens."""
        return self.folder / f"{self.name}.world"


@dataclass(frozen=True, kw_only=True, slots=True)
class Generated:
    """The maps of a recipe on disk: those that were made, and the indices of those that existed already."""

    recipe: Recipe
    folder: Path
    maps: tuple[GeneratedMap, ...]
    already: tuple[int, ...] = ()


def generate(  # noqa: PLR0913  # each is a flag of the command
    recipe: Recipe,
    folder: str | Path,
    *,
    force: bool = False,
    resume: bool = False,
    preview: bool = False,
    sheet: bool = False,
    formats: Sequence[Format] = (),
    workers: int = 1,
    sync: bool = True,
    progress: Callable[[GeneratedMap], None] | None = None,
) -> Generated:
    """Write every map of a recipe as `folder/NAME_000k`; `progress` is called with each that is done, in their order.

    `force` replaces maps that exist already; `resume` keeps them, if each is the one that would be made, and makes
    the others; `preview` adds a picture to each, `sheet` a build sheet, `formats` files for other programs. With
    `workers` beyond 1, other processes take a part if that is quicker; a script then needs
    `if __name__ == "__main__":`. `sync` waits until the disk has the files: without it many small maps are made a
    little quicker, and a power failure may leave some of them empty, which `resume` makes again. Raises, before
    anything is written, an OutputError if a map's folder is taken or has files that rsegen did not write, TooLarge if
    memory or disk space are too small, a ParameterError if maps are too large for build sheets.
    """
    sidecars = Sidecars(preview=preview, sheet=sheet, formats=tuple(formats))
    on_existing = OnExisting.of(force=force, resume=resume)
    plan = plan_worlds(recipe, Path(folder), sidecars, on_existing, workers, sync=sync)
    return make_worlds(recipe, plan, progress)


WorldsPlan = RunPlan[int, GeneratedMap]
"""The plan of a run that makes worlds; its items are the indices of maps."""


def plan_worlds(
    recipe: Recipe,
    folder: Path,
    sidecars: Sidecars,
    on_existing: OnExisting,
    workers: int = 1,
    *,
    sync: bool = True,
) -> WorldsPlan:
    """Check that the worlds of a recipe can be made, and plan it; nothing is written. Raises as `generate` does."""
    workers, keep = WORKERS.check("workers", workers), on_existing is OnExisting.KEEP
    refuse_not_a_folder(folder)
    existing = existing_maps(recipe, folder, sidecars.complete_in) if keep else []
    sidecars.refuse(recipe)
    needs = check_needs([recipe], recipe.maps - len(existing), folder, formats=sidecars.formats)
    if not keep:
        homes = (os.path.join(folder, recipe.map_name(index)) for index in recipe.indices)
        refuse_taken(homes, force=on_existing is OnExisting.REPLACE)
    replace = on_existing is not OnExisting.REFUSE
    return RunPlan(
        folder=folder,
        task=WorldTask(recipe=recipe, folder=folder, replace=replace, sidecars=sidecars, sync=sync),
        to_make=_without(recipe.indices, existing),
        existing=existing,
        needs=needs,
        workers=min(workers, needs.maps_at_once),
    )


def make_worlds(recipe: Recipe, plan: WorldsPlan, progress: Callable[[GeneratedMap], None] | None = None) -> Generated:
    """Make the worlds of a plan; `progress` is called with each map that is done, in their order."""
    maps = run(plan, progress)
    return Generated(recipe=recipe, folder=plan.folder, maps=maps, already=tuple(plan.existing))


def write_world(scene: Scene, folder: Path, sidecars: Sidecars, writer: FolderWriter) -> GeneratedMap:
    """Write the world of one map, and its sidecars, by a writer of folders into `folder`."""
    bundle, name = {**export(scene), **sidecars.files(scene)}, scene.name
    return GeneratedMap(
        name=name,
        index=scene.index,
        home=folder,
        names=tuple(map(sys.intern, writer.write(name, bundle))),
        cells=scene.field.shape,
        extent=scene.field.extent,
        level_counts=scene.field.level_counts(),
        warnings=warnings(scene),
    )


def seconds_per_world(recipe: Recipe, sidecars: Sidecars) -> float:
    """About how long a map takes; decides how the maps are divided among workers, never the result."""
    n_x, n_y = recipe.grid.shape
    return 2e-3 + n_x * n_y * 4e-6 + sidecars.seconds(n_x * n_y)


@dataclass(frozen=True, kw_only=True, slots=True)
class WorldTask:
    """Makes worlds of a recipe by their indices: all that a worker needs to know."""

    recipe: Recipe
    folder: Path
    replace: bool
    sidecars: Sidecars
    sync: bool

    @property
    def seconds(self) -> float:
        """About how long a map takes."""
        return seconds_per_world(self.recipe, self.sidecars)

    def __call__(self, indices: Iterable[int]) -> tuple[GeneratedMap, ...]:
        """The maps of some indices, on disk."""
        scenes = (compose(self.recipe, index) for index in indices)
        with folder_writer(self.folder, force=self.replace, sync=self.sync) as writer:
            return tuple(write_world(scene, self.folder, self.sidecars, writer) for scene in scenes)


def _without(indices: Sequence[int], existing: Sequence[int]) -> Sequence[int]:
    if not existing:
        return indices
    known = frozenset(existing)
    return [index for index in indices if index not in known]
