"""From a recipe to worlds on disk: what command line, window and scripts call.

Recipe --build--> StepField --compose--> Scene --export--> Bundle --write--> files
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath

from rsegen.account import warnings
from rsegen.drawing import picture
from rsegen.errors import ParameterError
from rsegen.export import export
from rsegen.params import Whole
from rsegen.recipe import Recipe
from rsegen.resume import complete, is_map_of
from rsegen.room import maps_at_once, refuse_too_large, refuse_too_many
from rsegen.scene import Scene, compose
from rsegen.sheet import Saw, refuse_unbuildable
from rsegen.sheet import sheet as sheet_of
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
    workers: int = 1,
    progress: Callable[[GeneratedMap], None] | None = None,
) -> Generated:
    """Write every map of a recipe as `folder/NAME_000k`; `progress` is told of each that is done, in their order.

    `force` replaces maps that are there already; `resume` leaves them, if each is the one that would be made, and makes
    the others; `preview` adds a picture to each, `sheet` a build sheet. With `workers` beyond 1, other processes take a
    part where that is quicker; a script then needs `if __name__ == "__main__":`. Raises, before anything is written, an
    OutputError where a map's folder is taken, TooLarge where there is no room for the maps, a ParameterError where they
    are too large for build sheets.
    """
    folder, workers = Path(folder), WORKERS.check("workers", workers)
    if force and resume:
        raise ParameterError("resume", "keeps the maps that are there, and force replaces them; give one of the two")
    refuse_too_large(recipe)
    refuse_not_a_folder(folder)
    if sheet:
        refuse_unbuildable(recipe, Saw())
    added = additions(preview=preview, sheet=sheet)
    already = complete(recipe, folder, added) if resume else frozenset()
    refuse_too_many(recipe.maps - len(already), folder)
    if resume:
        clear_away(folder, partial(is_map_of, recipe))
    else:
        refuse_taken((os.path.join(folder, recipe.map_name(index)) for index in recipe.indices), force=force)
    order = _Order(recipe=recipe, folder=folder, replace=force or (resume and bool(added)), added=added)
    made = []
    with closing(_made(order, already, workers)) as maps:
        for one in maps:
            made.append(one)
            if progress:
                progress(one)
    return Generated(recipe=recipe, folder=folder, maps=tuple(made), already=tuple(sorted(already)))


def additions(*, preview: bool, sheet: bool) -> tuple[str, ...]:
    """The names of the files that are asked for beside the worlds, the same in every map's folder."""
    return ("preview.png",) * preview + ("sheet.csv", "sheet.pdf") * sheet


_ADDITIONS: Mapping[str, Callable[[Scene], bytes]] = {
    "preview.png": picture,
    "sheet.csv": partial(sheet_of, format="csv"),
    "sheet.pdf": partial(sheet_of, format="pdf"),
}


@dataclass(frozen=True, kw_only=True, slots=True)
class _Order:
    """Which maps to make, where and how: all that a worker is told."""

    recipe: Recipe
    folder: Path
    replace: bool
    added: tuple[str, ...]

    @property
    def seconds(self) -> float:
        """About how long a map takes; it decides how the work is shared out, not what comes of it."""
        n_x, n_y = self.recipe.grid.shape
        return 2e-3 + n_x * n_y * 4e-6 + 0.5 * len(self.added)

    def __call__(self, indices: Iterable[int]) -> tuple[GeneratedMap, ...]:
        return tuple(map(self.made, indices))

    def made(self, index: int) -> GeneratedMap:
        """One map, on disk."""
        scene = compose(self.recipe, index)
        bundle = dict(export(scene)) | {PurePosixPath(name): [_ADDITIONS[name](scene)] for name in self.added}
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
    workers = min(workers, left, maps_at_once(order.recipe))
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
