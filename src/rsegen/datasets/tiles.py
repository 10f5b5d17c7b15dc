"""A terrain of many maps, harder from row to row, for curriculum learning.

rows (+x): from the easiest map to the hardest       columns (+y): maps of about the same difficulty, or a recipe each

Maps are chosen by a metric: those nearest to evenly spaced values, each used once, or those at evenly spaced ranks.
Cost: a sort per row; a metric that is not in the table of the data set is measured map by map, which costs most. What
breaks it: a metric with few different values, of which neighbouring rows then have the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.datasets.difficulty_tiles import amid, kind_of_column
from rsegen.errors import ParameterError, UnknownName, shown
from rsegen.field.crossing import CrossingModel
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.measuring.batch import COLUMNS
from rsegen.measuring.catalogue import By, metric_by
from rsegen.params.sorts import Choice, Integer

if TYPE_CHECKING:
    from rsegen.datasets.reading import Dataset


SPACING = Choice(("value", "rank"))
"""Spacing of the rows: even in the metric itself, or in its rank among all maps."""


class Tiles(NamedTuple):
    """A terrain, as IsaacLab, mjlab and legged_gym lay theirs out: difficulty rises along x, from row to row.

    Attributes
    ----------
    levels : ndarray, shape (rows, columns, n_x, n_y)
        Block levels, frames left out.
    heights : ndarray, shape (rows, columns, cells_x, cells_y)
        Heights in metres, frames counted.
    origins : ndarray, shape (rows, columns, 3)
        The middle of each tile, metres, all together centred on x = y = 0; z is the height of the highest cell that
        meets there, so that a robot does not start inside a block.
    places : ndarray of int, shape (rows, columns)
        Which map of the data set it is.
    difficulty : ndarray of float32, shape (rows, columns)
        Its metric.
    size : tuple of float
        Metres of one tile along x and y, frames counted.
    """

    levels: Ints
    heights: Array
    origins: Array
    places: NDArray[np.intp]
    difficulty: NDArray[np.float32]
    size: tuple[float, float]


def tiles(  # noqa: PLR0913  # as Dataset.tiles
    dataset: Dataset,
    rows: int,
    columns: int,
    by: By,
    robot: CrossingModel | None,
    *,
    spacing: str,
    recipes: Sequence[str] | None,
) -> Tiles:
    """Return maps from the least to the greatest of a metric, evenly spaced; maps without a value are left out."""
    # For each recipe the maps of its columns, then what they are as a terrain.
    spacing = SPACING.check("spacing", spacing)
    rows, columns = (Integer(1).check(name, value) for name, value in (("rows", rows), ("columns", columns)))
    kinds = _kinds(dataset, recipes, columns)
    wanted = np.isin(dataset.recipe_numbers, kinds)
    figures, named = _figures(dataset, by, robot, wanted)
    places = np.empty((rows, columns), dtype=np.intp)
    for kind in np.unique(kinds):
        own = np.flatnonzero((dataset.recipe_numbers == kind) & ~np.isnan(figures))
        own = own[np.argsort(figures[own], kind="stable")]  # from the least to the greatest
        count = int((kinds == kind).sum())
        if rows * count > len(own):
            of = "" if len(dataset.recipes) == 1 else f" of {dataset.recipes[kind].name}"
            raise ParameterError("rows", f"{rows} x {count} tiles{of} need as many maps, and {len(own)} have a {named}")
        if spacing == "rank":
            ranks = np.linspace(0, len(own) - 1, rows * count).round().astype(np.intp)
            places[:, kinds == kind] = own[ranks].reshape(rows, count)
        else:
            places[:, kinds == kind] = _by_value(figures, own, rows, count)
    levels = dataset[places.ravel()]
    heights = np.array([dataset.layout.field(blocks).heights for blocks in levels])
    size = dataset.layout.flat_field.extent
    x, y = ((np.arange(n) - (n - 1) / 2) * side for n, side in zip((rows, columns), size, strict=True))
    middles = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    return Tiles(
        levels=levels.reshape(rows, columns, *levels.shape[1:]),
        heights=heights.reshape(rows, columns, *heights.shape[1:]),
        origins=np.concatenate([middles, amid(heights).reshape(rows, columns, 1)], axis=-1),
        places=places,
        difficulty=figures[places],
        size=size,
    )


def _kinds(dataset: Dataset, names: Sequence[str] | None, columns: int) -> NDArray[np.intp]:
    """Return the number of the recipe of each column."""
    known = {recipe.name: kind for kind, recipe in enumerate(dataset.recipes)}
    wanted = list(known) if names is None else names
    if isinstance(wanted, str) or not isinstance(wanted, Sequence):
        raise ParameterError("recipes", f"{shown(names)} is not a list of names of recipes")
    for index, name in enumerate(wanted):
        if not isinstance(name, str) or name not in known:
            raise UnknownName.among(f"recipes[{index}]", "recipe", name, known)
    if not 0 < len(wanted) <= columns:
        raise ParameterError("recipes", f"{len(wanted)} for {columns} columns; use at most one per column")
    return np.array([known[wanted[kind_of_column(column, columns, len(wanted))]] for column in range(columns)])


def _by_value(figures: NDArray[np.float32], ranked: NDArray[np.intp], rows: int, columns: int) -> NDArray[np.intp]:
    """Return row by row the unused maps nearest to evenly spaced values, from the least to the greatest."""
    values, free = figures[ranked], np.ones(len(ranked), dtype=bool)
    places = np.empty((rows, columns), dtype=np.intp)
    for row, target in enumerate(np.linspace(values[0], values[-1], rows)):
        left = np.flatnonzero(free)
        nearest = np.sort(left[np.argsort(np.abs(values[left] - target), kind="stable")[:columns]])
        free[nearest], places[row] = False, ranked[nearest]
    return places


def _figures(dataset: Dataset, by: By, robot: CrossingModel | None, wanted: Mask) -> tuple[NDArray[np.float32], str]:
    """Return a metric of every map, NaN for none, and its name: from the table, or measured on each that is wanted."""
    metric = metric_by(by, robot)
    if isinstance(by, str) and by in COLUMNS and robot is None:
        return dataset.metrics[by], by
    figures = np.full(len(dataset), np.nan, dtype=np.float32)
    figures[wanted] = [metric(dataset.field(int(place))) for place in np.flatnonzero(wanted)]
    return figures, metric.name
