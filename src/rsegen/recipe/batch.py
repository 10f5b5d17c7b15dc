"""The blocks of many maps in one array, with the same levels as built one by one.

numpy's cost per call exceeds that of the cells of a small map, so thousands of maps are made by the same calls:

    cells that draw a number each      from the numbers of all maps in one array
    ends that are drawn                for all maps as arrays, if the kind's `ends` is elementwise; else map by map
    kinds that draw nothing else       one patch for all maps with the same ends, all patches by one profile
    layouts that draw, as stones       the numbers of all maps with rectangles of one shape
    pallets, `max_step` of an obstacle swaps of all maps with rectangles of one shape (obstacles/rearranged.py)
    difficulty, a largest step         all maps at once (difficulty.py, constraints/meeting.py)
    paths of steps within limits       all maps at once, by sweeps (field/sweeps.py)
    all else                           map by map, as by `build`: kinds of others that draw in their `patch`; maps with
                                       an inventory, or that a robot has to cross

The cost that remains for each map and obstacle is a hash, and for each cell of a map one operation of each step.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from rsegen.errors import ParameterError, inside, refuse_other, shown
from rsegen.field.stepfield import Ints, Levels, Mask
from rsegen.obstacles import Grid, Obstacle, Patch
from rsegen.obstacles.base import EVERYWHERE, Filling, Region, is_elementwise
from rsegen.params.arrays import asarray, take_along_rows
from rsegen.params.sorts import Cell
from rsegen.params.streams import SEEDS, Streams
from rsegen.recipe.building import blocks, field_of, fixed_ends, flat_ground, impose, refuse_other_levels
from rsegen.recipe.map_design import MapDesign

_CELLS_AT_ONCE = 2**17
"""Cells that are made together: an array of numbers for them takes 1 MB, which fits into the cache of a core."""

_MORE_REARRANGED = 4
"""Times as many cells are made together if blocks are swapped, as few maps are left in most of the sweeps."""

_CELLS_SCALED_AT_ONCE = 2**16
"""Cells that are scaled to their difficulty together, in several arrays of numbers at a time."""

_FEW_CELLS = 2**12
"""Cells of a map above which patches are made one by one, each in its window: numpy's cost per call is less by then."""


def build_many(recipe: MapDesign, indices: Iterable[int]) -> Levels:
    """Return the levels of the blocks of many maps of a recipe, in a fraction of the time of `build` in a loop.

    Parameters
    ----------
    recipe : Recipe
        The recipe, or the design of its maps.
    indices : iterable of int
        Indices of the maps, 0 or more.

    Returns
    -------
    ndarray of int16, shape (maps, n_x, n_y)
        Levels in units, frames left out: row k is `build(recipe, indices[k]).blocks`.

    Raises
    ------
    ParameterError
        If an index is no whole number from 0 on.
    TooLarge
        If the array does not fit into memory.
    """
    refuse_other("recipe", recipe, MapDesign)
    checked = checked_indices(indices)
    levels = flat_ground(recipe.grid, len(checked))
    fill(levels, recipe, checked, _CELLS_AT_ONCE, _CELLS_SCALED_AT_ONCE)
    return levels


def checked_indices(indices: Iterable[int]) -> Sequence[int]:
    """Return map indices as a sequence; ParameterError if any is no whole number or out of range."""
    try:
        checked = indices if isinstance(indices, range) else [operator.index(index) for index in indices]
    except TypeError:
        raise ParameterError("indices", f"{shown(indices)} is not a list of map indices, such as range(1000)") from None
    # The ends of a range are its least and largest: it may be too long to be gone through.
    ends = (checked[0], checked[-1]) if isinstance(checked, range) and checked else checked
    for index in (min(ends), max(ends)) if checked else ():
        if not 0 <= index < SEEDS:
            raise ParameterError("indices", f"{index} is outside 0..{SEEDS - 1}")
    return checked


def fill(levels: Any, recipe: MapDesign, indices: Sequence[int], cells: int, scaled_cells: int) -> None:
    """Make these maps in place of flat ground (maps, n_x, n_y), an array or a tensor.

    cells, scaled_cells: how many are made, and how many are scaled to their difficulty, together.
    """
    if len(indices) == 1 or (recipe.is_constrained and not _are_met_together(recipe)):
        for own, index in zip(levels, indices, strict=True):
            own[:] = asarray(blocks(recipe, index), own)
        return
    obstacles = [(row, _InManyMaps(recipe, obstacle)) for row, obstacle in recipe.enabled_obstacles]
    of_a_map = recipe.grid.n_x * recipe.grid.n_y
    cells *= _MORE_REARRANGED if any(obstacle.draws_alike for _, obstacle in recipe.enabled_obstacles) else 1
    # As `building.build` does for one map, in the same order: obstacles, difficulty, ground, constraints.
    for part, own in _parts(levels, indices, cells // of_a_map):
        for row, obstacle in obstacles:
            with inside(f"obstacles[{row}]"):
                obstacle.impose_on(part, own)
        if recipe.difficulty != 1:
            from rsegen.recipe.difficulty import scaled_to_difficulties

            for few, indices_of_few in _parts(part, own, scaled_cells // of_a_map):
                few[:] = scaled_to_difficulties(few, recipe, indices_of_few)
        part[:] += recipe.ground_level
        if recipe.is_constrained:
            from rsegen.recipe.constraints.meeting import blocks_constrained

            part[:] = blocks_constrained(part, recipe, field_of(recipe, flat_ground(recipe.grid)))


def _are_met_together(recipe: MapDesign) -> bool:
    from rsegen.recipe.constraints.meeting import are_met_together

    return are_met_together(recipe)


def _parts(levels: Any, indices: Sequence[int], maps: int) -> Iterator[tuple[Any, Sequence[int]]]:
    """Yield the levels of a number of maps at a time, with their indices."""
    for low in range(0, len(indices), max(maps, 1)):
        part = slice(low, low + max(maps, 1))
        yield levels[part], indices[part]


class _InManyMaps:
    """An obstacle that is imposed on many maps at once."""

    def __init__(self, recipe: MapDesign, obstacle: Obstacle) -> None:
        self._recipe, self._grid, self._obstacle = recipe, recipe.grid, obstacle
        self._ends = fixed_ends(recipe.grid, obstacle)
        self._patch: Patch | None = None  # if it is the same in all maps
        if self._ends is not None and obstacle.draws_nothing:
            self._patch = obstacle.patch(recipe.grid, *self._ends, np.random.Generator(np.random.PCG64(0)))

    def impose_on(self, levels: Any, indices: Sequence[int]) -> None:
        """Impose the obstacle on these maps, (maps, n_x, n_y), in place."""
        # From the cheapest way that the kind allows to the dearest, map by map; all draw the same numbers.
        if self._patch is not None:
            self._impose(levels, self._patch)
            return
        obstacle = self._obstacle
        streams = Streams.of(self._recipe.seed, indices, obstacle.key or "")
        is_small = self._grid.n_x * self._grid.n_y <= _FEW_CELLS
        region = obstacle if obstacle.draws_by_cell and isinstance(obstacle, Region) else None
        if region and self._ends is not None:
            self._impose(levels, _drawn_by_cell(self._grid, region, self._ends, streams, levels))
        elif region and is_small and _is_drawn_anywhere(region):
            self._impose(levels, self._drawn_anywhere(region, streams, levels))
        elif obstacle.draws_nothing and is_small:
            self._impose(levels, self._patches(streams))
        elif (is_small or self._ends) and isinstance(obstacle, Filling) and _is_drawn_alike(obstacle):
            (x1, y1), (x2, y2) = self._ends_of(streams)
            ends = np.stack([np.stack([x1, y1], axis=-1), np.stack([x2, y2], axis=-1)], axis=1)
            self._impose(levels, obstacle.patches_drawn(self._grid, ends, streams))
        else:
            for own, rng in zip(levels, streams.generators(), strict=True):
                first, last = obstacle.ends(self._grid, *obstacle.wanted_ends(self._grid), rng)
                self._impose(own, obstacle.patch(self._grid, first, last, rng))

    def _impose(self, levels: Any, patch: Patch) -> None:
        refuse_other_levels(self._obstacle, patch, self._grid)
        patch = patch._replace(levels=asarray(patch.levels, levels), footprint=asarray(patch.footprint, levels))
        impose(levels, patch, self._obstacle.blend, self._recipe.level_range)

    def _patches(self, streams: Streams) -> Patch:
        """Return the patch of every map, of which each that several maps have is made once."""
        n_x, n_y = self._grid.shape
        (x1, y1), (x2, y2) = ends = self._ends_of(streams)
        pair_of_map = ((x1 * n_y + y1) * n_x + x2) * n_y + y2  # both ends as one number
        _, first_of, place = np.unique(pair_of_map, return_index=True, return_inverse=True)
        pairs = np.stack([np.stack([at[first_of] for at in end], axis=-1) for end in ends], axis=1)
        patch = self._obstacle.patches(self._grid, pairs)
        return patch._replace(levels=patch.levels[place], footprint=patch.footprint[place])

    def _drawn_anywhere(self, obstacle: Region, streams: Streams, like: Any) -> Patch:
        """Return the patch of every map of an obstacle that draws a number for each cell between drawn ends."""
        # The numbers of the cells are those that follow the ends.
        ends = zip(*self._ends_of(streams), self._grid.shape, strict=True)
        (x, in_x, _), (y, in_y, n_y) = (_between(*pair) for pair in ends)
        place = np.where(in_x[:, :, None] & in_y[:, None], x[:, :, None] * n_y[:, None] + y[:, None], 0)
        uniform = streams.on_device_of(like).arrays((int(place.max()) + 1,))
        drawn = take_along_rows(uniform, asarray(place.reshape(len(place), -1), like)).reshape(place.shape)
        return Patch(EVERYWHERE, obstacle.drawn(drawn), in_x[:, :, None] & in_y[:, None])

    def _ends_of(self, streams: Streams) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
        """Return both coordinates of both ends, each (maps,); elementwise ones are drawn from the streams in place."""
        obstacle, grid = self._obstacle, self._grid
        first, last = obstacle.wanted_ends(grid)
        if is_elementwise(obstacle.ends):
            drawn: Any = obstacle.ends(grid, first, last, streams)  # type: ignore[arg-type]  # elementwise
            (x1, y1), (x2, y2) = (tuple(np.broadcast_to(at, len(streams)) for at in end) for end in drawn)
        else:
            drawn = np.array([obstacle.ends(grid, first, last, rng) for rng in streams.generators()])
            (x1, y1), (x2, y2) = np.moveaxis(drawn, 0, -1)
        return (x1, y1), (x2, y2)


def _is_drawn_alike(obstacle: Filling) -> bool:
    """Return whether obstacles of many maps are made together, by the numbers that follow their ends' numbers."""
    return obstacle.draws_alike and is_elementwise(obstacle.ends)


def _is_drawn_anywhere(obstacle: Region) -> bool:
    """Return whether the cells of an obstacle may be drawn between other ends in every map."""
    return is_elementwise(obstacle.ends) and is_elementwise(obstacle.drawn) and obstacle.draws_per_cell == 1


def _between(first: Ints, last: Ints, cells: int) -> tuple[Ints, Mask, Ints]:
    """Return the place of each cell of an axis between two ends, whether it lies there, and the number of such cells.

    (maps, cells), and (maps, 1) for the number.
    """
    low, high = np.minimum(first, last)[:, None], np.maximum(first, last)[:, None]
    at = np.arange(cells)
    return at - low, (at >= low) & (at <= high), high - low + 1


def _drawn_by_cell(grid: Grid, obstacle: Region, ends: tuple[Cell, Cell], streams: Streams, like: Any) -> Patch:
    """Return the patch of every map of an obstacle that draws a number for each cell between fixed ends."""
    window = obstacle.window(grid, *ends)
    shape = tuple(part.stop - part.start for part in window)
    on_device = (
        streams.on_device_of(like) if is_elementwise(obstacle.drawn) else streams
    )  # a tensor only where one is expected
    uniform = on_device.arrays((obstacle.draws_per_cell, *shape))[:, -1]
    return Patch(window, obstacle.levels_in_maps(uniform), np.ones(shape, dtype=bool))
