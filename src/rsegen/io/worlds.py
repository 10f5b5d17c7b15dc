"""From a recipe to worlds on disk: what command line, window and scripts call.

Recipe --build--> StepField --compose--> Scene --export--> Bundle --write--> files
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rsegen.errors import ParameterError
from rsegen.exporters.formats import Format
from rsegen.exporters.gazebo import export
from rsegen.exporters.map_summary import warnings
from rsegen.exporters.scene import Scene, compose
from rsegen.io.existing import complete, is_map_of
from rsegen.io.resources import maps_in_memory, refuse_too_large, refuse_too_many
from rsegen.io.sidecars import Sidecars
from rsegen.io.work import WORKERS, run_in_order
from rsegen.io.writer import refuse_not_a_folder, refuse_taken, remove_leftovers, write
from rsegen.recipe.recipe import Recipe


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
        raise ParameterError("resume", "--resume and --force exclude each other")
    extras = Sidecars(preview=preview, sheet=sheet, formats=tuple(formats))
    extras.refuse(recipe)
    refuse_too_large(recipe, extras.bytes_a_cell)
    refuse_not_a_folder(folder)
    already = complete(recipe, folder, extras.stand) if resume else frozenset()
    refuse_too_many(recipe.maps - len(already), folder)
    if resume:
        remove_leftovers(folder, partial(is_map_of, recipe))
    else:
        refuse_taken((os.path.join(folder, recipe.map_name(index)) for index in recipe.indices), force=force)
    order = _Order(recipe=recipe, folder=folder, replace=force or resume, extras=extras)
    left = [index for index in recipe.indices if index not in already]
    maps = run_in_order(order, left, workers, progress)
    return Generated(recipe=recipe, folder=folder, maps=maps, already=tuple(sorted(already)))


def made(scene: Scene, folder: Path, extras: Sidecars, *, replace: bool) -> GeneratedMap:
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


def seconds(recipe: Recipe, extras: Sidecars) -> float:
    """About how long a map takes; it decides how the work is shared out, not what comes of it."""
    n_x, n_y = recipe.grid.shape
    return 2e-3 + n_x * n_y * 4e-6 + extras.seconds(n_x * n_y)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Order:
    """Which maps to make, where and how: all that a worker is told."""

    recipe: Recipe
    folder: Path
    replace: bool
    extras: Sidecars

    @property
    def seconds(self) -> float:
        return seconds(self.recipe, self.extras)

    @property
    def at_once(self) -> int:
        return maps_in_memory(self.recipe, self.extras.bytes_a_cell)

    def map_name(self, index: int) -> str:
        return self.recipe.map_name(index)

    def __call__(self, indices: Iterable[int]) -> tuple[GeneratedMap, ...]:
        return tuple(
            made(compose(self.recipe, index), self.folder, self.extras, replace=self.replace) for index in indices
        )
