"""From a recipe to worlds on disk: what command line, window and scripts call.

Recipe --build--> StepField --compose--> Scene --export--> Bundle --write--> files
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath

from rsegen.account import warnings
from rsegen.errors import OutputError, ParameterError
from rsegen.export import export
from rsegen.formats import Format, added, bytes_a_cell, exported, options, refuse_unready
from rsegen.params import Whole
from rsegen.recipe import Recipe
from rsegen.resume import Wanted, complete, is_map_of
from rsegen.room import maps_at_once, refuse_too_large, refuse_too_many
from rsegen.scene import compose
from rsegen.workers import shared_out
from rsegen.writer import clear_away, parent_of, refuse_not_a_folder, refuse_taken, told, write

WORTHWHILE = 1.0
"""Seconds of work from which on workers gain more than they cost."""

BATCH = 0.2
"""Seconds of work that a worker is given at once: much more than the giving takes, little enough to see it move."""

WORKERS = Whole(1, help="processes that make maps at the same time")


@dataclass(frozen=True, kw_only=True, slots=True)
class GeneratedMap:
    """One map on disk: where, how large (cells with frames, metres), its blocks of each level, what to know of it.

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
        """All that was written."""
        return tuple(self.folder / name for name in self.names)

    @property
    def world(self) -> Path:
        """The file that a simulator opens."""
        return self.folder / f"{self.name}.world"


@dataclass(frozen=True, kw_only=True, slots=True)
class Generated:
    """The maps of a recipe on disk: those that were made, and the indices of those that were there already."""

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
    formats: Sequence[Format] = (),
    workers: int = 1,
    progress: Callable[[GeneratedMap], None] | None = None,
) -> Generated:
    """Write every map of a recipe as `folder/NAME_000k`; `progress` is told of each that is done, in their order.

    `force` replaces maps that are there already; `resume` leaves them, if each is the one that would be made, and makes
    the others; `preview` adds a picture to each, `formats` the files of each of them. With `workers` beyond 1, other
    processes take a part where that is quicker; a script then needs `if __name__ == "__main__":`. Raises an OutputError
    before anything is written where a map's folder is taken, TooLarge where there is no room for the maps.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    refuse_unready(formats)
    if force and resume:
        raise ParameterError("resume", "keeps the maps that are there, and force replaces them; give one of the two")
    refuse_too_large(recipe, bytes_a_cell(formats))
    refuse_not_a_folder(folder)
    wanted = Wanted(preview=preview, formats=options(formats))
    already = complete(recipe, folder, wanted) if resume else frozenset()
    refuse_too_many(recipe.maps - len(already), folder)
    if resume:
        clear_away(folder, partial(is_map_of, recipe))
    else:
        refuse_taken((os.path.join(folder, recipe.map_name(index)) for index in recipe.indices), force=force)
    order = _Order(recipe=recipe, folder=folder, replace=force or resume, preview=preview, formats=tuple(formats))
    made = []
    with closing(_made(order, already, workers)) as maps:
        for one in maps:
            made.append(one)
            if progress:
                progress(one)
    return Generated(recipe=recipe, folder=folder, maps=tuple(made), already=tuple(sorted(already)))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Order:
    """Which maps to make, where and how: all that a worker is told."""

    recipe: Recipe
    folder: Path
    replace: bool
    preview: bool
    formats: tuple[Format, ...]

    @property
    def seconds(self) -> float:
        """About how long a map takes; it decides how the work is shared out, not what comes of it."""
        n_x, n_y = self.recipe.grid.shape
        return 2e-3 + n_x * n_y * 4e-6 + 0.5 * self.preview + (5e-3 + n_x * n_y * 3e-5) * len(self.formats)

    def __call__(self, indices: Iterable[int]) -> tuple[GeneratedMap, ...]:
        return tuple(map(self.made, indices))

    def made(self, index: int) -> GeneratedMap:
        """One map, on disk."""
        scene = compose(self.recipe, index)
        bundle = {**export(scene), **added(scene, self.formats)}
        if self.preview:
            from rsegen.drawing import picture

            bundle[PurePosixPath("preview.png")] = [picture(scene)]
        return GeneratedMap(
            name=scene.name,
            index=index,
            home=self.folder,
            names=tuple(map(sys.intern, write(bundle, self.folder / scene.name, force=self.replace))),
            cells=scene.field.shape,
            extent=scene.field.extent,
            level_counts=scene.field.level_counts(),
            warnings=warnings(scene),
        )


def _made(order: _Order, already: frozenset[int], workers: int) -> Generator[GeneratedMap, None, None]:
    """The maps that are not there already, made here or, where that is quicker, by workers."""
    indices = (index for index in order.recipe.indices if index not in already)
    left = order.recipe.maps - len(already)
    workers = min(workers, left, maps_at_once(order.recipe, bytes_a_cell(order.formats)))
    if workers == 1 or left * order.seconds < WORTHWHILE:
        yield from map(order.made, indices)
        return
    batch = math.ceil(min(BATCH / order.seconds, left / workers / 4))
    with told(order.folder), parent_of(order.folder / "map"):
        try:
            yield from shared_out(order, indices, batch=batch, workers=workers)
        except BaseException:
            clear_away(order.folder, partial(is_map_of, order.recipe))  # what a worker left that was killed
            raise


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
