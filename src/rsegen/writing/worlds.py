"""The worlds of a recipe, planned and made for `generate`, which the command line, the page and scripts call.

    Recipe --plan_worlds--> RunPlan --run_in: compose, export, write, for each map--> Generated

A map's folder has its world, and next to it optional files, its sidecars: a picture, a build sheet, files for other
programs. The times of a map only decide how maps are divided among workers, never the result.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath

from rsegen.errors import refuse_other
from rsegen.gazebo import Bundle, export
from rsegen.gazebo.map_summary import warnings
from rsegen.recipe.recipe import Recipe
from rsegen.scene.scene import Scene, compose
from rsegen.writing.execute import Execution
from rsegen.writing.journal import compare, read_journal
from rsegen.writing.plan import OnExisting, Output, RunPlan, existing_maps
from rsegen.writing.resources import Step, check_needs
from rsegen.writing.sidecars import Sidecar, are_complete, files_of
from rsegen.writing.store import refuse_busy, refuse_taken, refuse_unit, sorted_names


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedMap:
    """A map on disk.

    Attributes
    ----------
    name : str
        Its name, which its folder in `home` has too.
    index : int
        Its index in the recipe.
    home : Path
        The folder that all maps are in.
    names : tuple of str
        Names of the files in the map's own folder.
    cells : tuple of int
        Cells along x and y, frames counted.
    extent : tuple of float
        Its sides along x and y, metres.
    level_counts : dict of int to int
        Number of blocks of each level.
    warnings : tuple of str
        A sentence on each thing that may not be meant.
    scene : Scene or None
        The scene of a run of one map, which may have taken long to make; else None, as thousands would not fit into
        memory.
    """

    name: str
    index: int
    home: Path
    names: tuple[str, ...]
    cells: tuple[int, int]
    extent: tuple[float, float]
    level_counts: dict[int, int]
    warnings: tuple[str, ...]
    scene: Scene | None = field(default=None, compare=False, repr=False)

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
    """The maps of a recipe on disk.

    Attributes
    ----------
    recipe : Recipe
        Their recipe.
    folder : Path
        The folder that they are in.
    maps : tuple of GeneratedMap
        Those that were made.
    already : tuple of int
        The indices of those that existed already.
    """

    recipe: Recipe
    folder: Path
    maps: tuple[GeneratedMap, ...]
    already: tuple[int, ...] = ()


def plan_worlds(
    recipe: Recipe,
    folder: Path,
    sidecars: Sequence[Sidecar],
    on_existing: OnExisting,
    execution: Execution | None = None,
    *,
    beside: Iterable[str] = (),
) -> RunPlan[int, GeneratedMap]:
    """Check that the worlds of a recipe can be made, and plan it; nothing is written. Raises as `generate` does.

    The plan's items are the indices of maps.

    beside: the names of files that `generate` puts into the folder, next to the maps
    """
    refuse_other("recipe", recipe, Recipe)
    execution = execution or Execution()
    refuse_busy(folder)
    keeps = on_existing is OnExisting.KEEP
    existing = existing_maps(recipe, folder, partial(are_complete, sidecars)) if keeps else []
    at_once = worlds_at_once(recipe, recipe.maps - len(existing), folder, sidecars)
    refuse_names(folder, map(recipe.map_name, recipe.indices), beside, on_existing)
    known = frozenset(existing)
    return RunPlan(
        folder=folder,
        product=partial(_world, recipe, folder, sidecars, keeps_files=keeps),
        seconds=seconds_per_world(recipe, sidecars),
        to_make=[index for index in recipe.indices if index not in known] if known else recipe.indices,
        existing=existing,
        replaces=on_existing is not OnExisting.REFUSE,
        execution=replace(execution, workers=min(execution.workers, at_once)),
    )


def worlds_at_once(recipe: Recipe, maps: int, folder: Path, sidecars: Sequence[Sidecar], step: Step = "build") -> int:
    """Return how many maps of a recipe fit into memory at once, with all that is made of a map up to this step.

    Raises what a sidecar refuses, and TooLarge if memory or disk are too small for the maps.
    """
    for sidecar in sidecars:
        sidecar.refuse(recipe)
    return check_needs([recipe], maps, folder, step, [thing for sidecar in sidecars for thing in sidecar.in_memory])


def refuse_names(folder: Path, maps: Iterable[str], files: Iterable[str], on_existing: OnExisting) -> None:
    """Raise an OutputError if the name of a map, or of a file next to the maps, is taken and is not to be replaced.

    Maps that a run keeps are judged by `existing_maps`; the files are made again.
    """
    replaces = on_existing is not OnExisting.REFUSE
    if on_existing is not OnExisting.KEEP:
        refuse_taken((os.path.join(folder, name) for name in maps), force=replaces)
    names = tuple(files)
    journal = read_journal(folder) if names else None  # which will list them
    for name in names:
        refuse_unit(folder, name, journal, force=replaces)


def world_output(
    scene: Scene, folder: Path, sidecars: Sequence[Sidecar], *, keeps_files: bool = False, keeps_scene: bool = False
) -> Output[GeneratedMap]:
    """Return the files of the world of one map and of its sidecars, with the map's description.

    keeps_files: also files of an incomplete map in `folder` that none of these makes anew, such as a picture that an
    earlier run added
    """
    bundle = dict(export(scene))
    for sidecar in sidecars:
        bundle |= files_of(sidecar, scene)
    if keeps_files:
        bundle |= _earlier_files(folder / scene.name, bundle, sidecars)
    made = GeneratedMap(
        name=scene.name,
        index=scene.index,
        home=folder,
        names=tuple(map(sys.intern, sorted_names(bundle))),  # thousands of maps have files of the same names
        cells=scene.field.shape,
        extent=scene.field.extent,
        level_counts=scene.field.level_counts(),
        warnings=warnings(scene),
        scene=scene if keeps_scene else None,
    )
    return Output(made=made, files=bundle, folder=scene.name)


def _earlier_files(home: Path, made: Collection[PurePosixPath], sidecars: Iterable[Sidecar]) -> Bundle:
    """Return the files that an incomplete map in the folder `home` keeps, and the sidecars' lists of all files.

    A folder in it, such as that of a format, is kept if none of its files is missing. The plan has refused changed
    files, and the swap refuses files that are changed meanwhile.
    """
    if (journal := read_journal(home)) is None:
        return {}
    gone = {PurePosixPath(name).parts[0] for name in compare(home, journal).missing}
    gone |= {path.parts[0] for path in made}
    earlier = [path for path in map(PurePosixPath, journal.files) if path.parts[0] not in gone]
    # `map` reads each file when it is staged, not here: a map may have gigabytes of them.
    files: dict[PurePosixPath, Iterable[bytes]] = {path: map(Path.read_bytes, [home / path]) for path in earlier}
    for sidecar in sidecars:
        files |= sidecar.lists(str(home))
    return files


def seconds_per_world(recipe: Recipe, sidecars: Sequence[Sidecar]) -> float:
    """Return about how long a map takes; decides how the maps are divided among workers, never the result."""
    n_x, n_y = recipe.grid.shape
    # Estimates, as in `Sidecar.seconds`: 2 ms for the files and 4 us per cell.
    return 2e-3 + n_x * n_y * 4e-6 + sum(sidecar.seconds(n_x * n_y) for sidecar in sidecars)


def _world(
    recipe: Recipe, folder: Path, sidecars: Sequence[Sidecar], index: int, *, keeps_files: bool
) -> Output[GeneratedMap]:
    """Return the files of the world of map `index`, and its scene if it is the only one."""
    scene = compose(recipe, index)
    return world_output(scene, folder, sidecars, keeps_files=keeps_files, keeps_scene=recipe.maps == 1)
