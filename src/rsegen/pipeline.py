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
from pathlib import Path
from typing import Protocol, TypeVar

from rsegen.account import warnings
from rsegen.errors import ParameterError
from rsegen.export import export
from rsegen.extras import Extras
from rsegen.formats import Format
from rsegen.params import Whole
from rsegen.recipe import Recipe
from rsegen.resume import complete, is_map_of
from rsegen.room import maps_at_once, refuse_too_large, refuse_too_many
from rsegen.scene import Scene, compose
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
    sheet: bool = False,
    formats: Sequence[Format] = (),
    workers: int = 1,
    progress: Callable[[GeneratedMap], None] | None = None,
) -> Generated:
    """Write every map of a recipe as `folder/NAME_000k`; `progress` is told of each that is done, in their order.

    `force` replaces maps that are there already; `resume` leaves them, if each is the one that would be made, and makes
    the others; `preview` adds a picture to each, `sheet` a build sheet, `formats` files for other programs. With
    `workers` beyond 1, other processes take a part where that is quicker; a script then needs
    `if __name__ == "__main__":`. Raises, before anything is written, an OutputError where a map's folder is taken,
    TooLarge where there is no room for the maps, a ParameterError where they are too large for build sheets.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    if force and resume:
        raise ParameterError("resume", "keeps the maps that are there, and force replaces them; give one of the two")
    extras = Extras(preview=preview, sheet=sheet, formats=tuple(formats))
    extras.refuse(recipe)
    refuse_too_large(recipe, extras.bytes_a_cell)
    refuse_not_a_folder(folder)
    already = complete(recipe, folder, extras.stand) if resume else frozenset()
    refuse_too_many(recipe.maps - len(already), folder)
    if resume:
        clear_away(folder, partial(is_map_of, recipe))
    else:
        refuse_taken((os.path.join(folder, recipe.map_name(index)) for index in recipe.indices), force=force)
    order = _Order(recipe=recipe, folder=folder, replace=force or resume, extras=extras)
    indices = (index for index in recipe.indices if index not in already)
    done = []
    with closing(carried_out(order, indices, recipe.maps - len(already), workers)) as maps:
        for one in maps:
            done.append(one)
            if progress:
                progress(one)
    return Generated(recipe=recipe, folder=folder, maps=tuple(done), already=tuple(sorted(already)))


def made(scene: Scene, folder: Path, extras: Extras, *, replace: bool) -> GeneratedMap:
    """One map, put on disk."""
    bundle = {**export(scene), **extras.files(scene)}
    return GeneratedMap(
        name=scene.name,
        index=scene.index,
        home=folder,
        names=tuple(map(sys.intern, write(bundle, folder / scene.name, force=replace))),
        cells=scene.field.shape,
        extent=scene.field.extent,
        level_counts=scene.field.level_counts(),
        warnings=warnings(scene),
    )


def seconds(recipe: Recipe, extras: Extras) -> float:
    """About how long a map takes; it decides how the work is shared out, not what comes of it."""
    n_x, n_y = recipe.grid.shape
    return 2e-3 + n_x * n_y * 4e-6 + extras.seconds(n_x * n_y)


Made_co = TypeVar("Made_co", covariant=True)


class Work(Protocol[Made_co]):
    """What is done for each of many maps in a folder, here or by workers."""

    @property
    def folder(self) -> Path:
        """Where the maps go."""

    @property
    def seconds(self) -> float:
        """About how long one takes."""

    @property
    def at_once(self) -> int:
        """How many fit into memory together."""

    def is_named(self, name: str) -> bool:
        """Whether one of them is called so."""

    def __call__(self, indices: Iterable[int], /) -> tuple[Made_co, ...]:
        """What comes of some of them."""


Made = TypeVar("Made")


def carried_out(work: Work[Made], indices: Iterable[int], left: int, workers: int) -> Generator[Made, None, None]:
    """What comes of `left` indices, in their order, made here or, where that is quicker, by workers."""
    workers = min(workers, left, work.at_once)
    if workers <= 1 or left * work.seconds < WORTHWHILE:
        for index in indices:
            yield from work([index])
        return
    batch = math.ceil(min(BATCH / work.seconds, left / workers / 4))
    with told(work.folder), parent_of(work.folder / "map"):
        try:
            yield from shared_out(work, indices, batch=batch, workers=workers)
        except BaseException:
            clear_away(work.folder, work.is_named)  # what a worker left that was killed
            raise


@dataclass(frozen=True, kw_only=True, slots=True)
class _Order:
    """Which maps to make, where and how: all that a worker is told."""

    recipe: Recipe
    folder: Path
    replace: bool
    extras: Extras

    @property
    def seconds(self) -> float:
        return seconds(self.recipe, self.extras)

    @property
    def at_once(self) -> int:
        return maps_at_once(self.recipe, self.extras.bytes_a_cell)

    def is_named(self, name: str) -> bool:
        return is_map_of(self.recipe, name)

    def __call__(self, indices: Iterable[int]) -> tuple[GeneratedMap, ...]:
        return tuple(
            made(compose(self.recipe, index), self.folder, self.extras, replace=self.replace) for index in indices
        )
