"""Reads the height of every cell of a grid from a cloud, and how sure it is.

The height of one unit, from the heights at which a cloud has its tops.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import erf, sqrt

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.params.sorts import Cell
from rsegen.scanning.grid import CloudGrid

_CORE = 0.3
"""Points up to this share of a width from a cell's middle count: those of its sides are at 0.5."""

_FEWEST_POINTS = 5
_FEWEST_SHARE = 0.04
"""Of the points of a usual cell: of fewer, those that belong to its sides may be most."""

_MOST_CELLS = 4_000_000
_MOST_SHIFT = 0.35
"""Of a unit: a cell whose height is farther from a level does not decide how the plane lies."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reading:
    """What a cloud tells of each cell of a rectangle of its grid; all arrays (n_x, n_y).

    heights: of the tops above the ground [m], nan where too few points are; counts: points that agree on it;
    spread: standard deviation of one point [m]; first: the grid's indices of cell (0, 0).
    """

    heights: Array
    counts: Ints
    spread: float
    first: Cell

    @property
    def seen(self) -> Mask:
        """Which cells have a height."""
        return np.isfinite(self.heights)

    def levels(self, unit: float) -> Ints:
        """The nearest level of every cell, -1 where it was not seen."""
        return np.where(self.seen, np.maximum(np.rint(np.nan_to_num(self.heights) / unit), 0), -1).astype(np.int64)

    def confidence(self, unit: float) -> Array:
        """The probability that each level is right, 0 where a cell was not seen.

        The error of a height is normal: that of the mean of its points, and what all heights are off their levels.
        """
        off = (self.heights - self.levels(unit) * unit)[self.seen]
        shared = float(np.sqrt(np.mean(np.minimum(np.abs(off), unit / 2) ** 2))) if off.size else unit
        error = np.sqrt(self.spread**2 / np.maximum(self.counts, 1) + shared**2)[self.seen]
        error = np.maximum(error, 1e-6 * unit)  # of a cloud without errors
        below = np.array([erf(x) for x in (unit / 2 - off) / error / sqrt(2)])
        above = np.array([erf(x) for x in (unit / 2 + off) / error / sqrt(2)])
        found = np.zeros(self.heights.shape)
        found[self.seen] = np.clip((below + above) / 2, 0, 1)
        return found

    def part(self, corner: Cell, shape: Cell) -> Reading:
        """A rectangle of its cells; those outside were not seen."""
        heights = np.full(shape, np.nan)
        counts = np.zeros(shape, dtype=np.int64)
        own = tuple(
            slice(max(at, 0), max(min(at + cells, most), 0))
            for at, cells, most in zip(corner, shape, self.heights.shape, strict=True)
        )
        there = tuple(slice(cells.start - at, cells.stop - at) for cells, at in zip(own, corner, strict=True))
        heights[there], counts[there] = self.heights[own], self.counts[own]
        return replace(
            self, heights=heights, counts=counts, first=(self.first[0] + corner[0], self.first[1] + corner[1])
        )

    def quarter_turned(self, turns: int) -> Reading:
        """The same turned counterclockwise by quarter turns about its middle; `first` is kept."""
        return replace(self, heights=np.rot90(self.heights, turns), counts=np.rot90(self.counts, turns))


def read_cells(points: Array, grid: CloudGrid, unit: float, noise: float) -> Reading:
    """The heights of all cells of a grid that the points (n, 3) are in; unit and noise in metres."""
    across = (points[:, :2] @ grid.rotation.T - grid.origin) / grid.width
    cells = np.floor(across).astype(np.int64)
    low, high = (np.floor(np.quantile(across, q, axis=0)).astype(np.int64) for q in (0.002, 0.998))
    shape = int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1
    if shape[0] * shape[1] > _MOST_CELLS:
        raise ScanError(f"{shape[0]:,} x {shape[1]:,} cells in the cloud; cut everything else out of it")
    core = (np.abs(across - cells - 0.5) < _CORE).all(axis=1) & (cells >= low).all(axis=1) & (cells <= high).all(axis=1)
    keys = (cells[core, 0] - low[0]) * shape[1] + cells[core, 1] - low[1]
    heights, counts, spread = _agreed(keys, points[core, 2], shape[0] * shape[1], max(0.4 * unit, 2.5 * noise))
    return Reading(
        heights=heights.reshape(shape),
        counts=counts.reshape(shape),
        spread=spread,
        first=(int(low[0]), int(low[1])),
    )


def _agreed(keys: Ints, heights: Array, cells: int, within: float) -> tuple[Array, Ints, float]:
    """Per cell the mean of the heights near their median and how many these are, and one height's deviation."""
    order = np.lexsort((heights, keys))
    keys, heights = keys[order], heights[order]
    totals = np.bincount(keys, minlength=cells)
    starts = np.cumsum(totals) - totals
    median = np.full(cells, np.nan)
    some = totals > 0
    median[some] = (heights[(starts + (totals - 1) // 2)[some]] + heights[(starts + totals // 2)[some]]) / 2
    near = np.abs(heights - median[keys]) < within
    counts = np.bincount(keys[near], minlength=cells)
    sums = np.bincount(keys[near], weights=heights[near], minlength=cells)
    usual = counts[totals > _FEWEST_POINTS]
    fewest = max(_FEWEST_POINTS, _FEWEST_SHARE * float(np.median(usual))) if len(usual) else _FEWEST_POINTS
    seen = (counts >= fewest) & (counts >= totals / 2)
    means = np.where(seen, sums / np.maximum(counts, 1), np.nan)
    off = (heights - means[keys])[near & seen[keys]]
    spread = 1.4826 * float(np.median(np.abs(off))) if off.size else 0.0
    return means, counts, spread


def levelled(reading: Reading, unit: float) -> tuple[Reading, float]:
    """The reading with the ground fitted anew through all tops, and the unit that fits them best [m].

    Heights are `level unit + a + b x + c y`, by least squares over all cells that were seen.
    """
    for _ in range(3):
        levels = reading.levels(unit)
        off = reading.heights - levels * unit
        used = reading.seen & (np.abs(np.nan_to_num(off, nan=np.inf)) < _MOST_SHIFT * unit)
        if used.sum() < 8:
            return reading, unit
        i, j = np.nonzero(used)
        columns = [np.ones(len(i)), i - i.mean(), j - j.mean()]
        if len(np.unique(levels[used])) > 1:
            columns.append(levels[used].astype(float))
        weights = np.sqrt(np.minimum(reading.counts[used], 50))
        solved = np.linalg.lstsq(np.stack(columns, axis=1) * weights[:, None], off[used] * weights, rcond=None)[0]
        x, y = np.indices(off.shape)
        plane = solved[0] + solved[1] * (x - i.mean()) + solved[2] * (y - j.mean())
        unit += float(solved[3]) if len(solved) > 3 else 0.0
        reading = replace(reading, heights=reading.heights - plane)
    return reading, unit


_MOST_LEVELS = 12
_NEARLY_BEST = 0.85
_CLEAR = 0.25
"""How well heights have to agree on a unit, from 0 for heights at random to 1."""

_WRONG = 0.4


def find_unit(heights: Array, noise: float, given: float | None = None) -> float:
    """The height of a unit in a cloud [m]: the largest of which the heights above the ground are whole multiples.

    heights: of points or pixels above the ground [m]; given: what the unit should be, which is then found within a few
    per cent. A ScanError if the cloud has no such unit, or another one than the one that is given.
    """
    values, weights = _raised(heights, noise, given)
    highest = float(values[np.cumsum(weights) >= 0.98 * weights.sum()][0])
    candidates = np.geomspace(max(2 * noise, highest / _MOST_LEVELS, 0.003), highest * 1.06, 1500)
    agreement = _agreement(values, weights, candidates)
    best = float(agreement.max())
    last = int(np.flatnonzero(agreement >= _NEARLY_BEST * best)[-1])
    run = int(np.argmax(np.append(agreement[last::-1] < _NEARLY_BEST * best, True)))  # of candidates nearly as good
    first = last - run + 1
    found = float(candidates[first + int(agreement[first : last + 1].argmax())])
    if given is None:
        if best < _CLEAR:
            raise ScanError("the heights above the ground are no whole multiples of a unit; give unit_cm if they are")
        return found
    own = given * np.linspace(0.95, 1.05, 41)
    agrees = _agreement(values, weights, own)
    if best >= _CLEAR and agrees.max() < _WRONG * best:
        raise ScanError(
            f"blocks rise by {found * 100:.3g} cm in the cloud, not {given * 100:g} cm; give another unit_cm or values"
        )
    return float(own[int(agrees.argmax())]) if agrees.max() >= _CLEAR else given


def _raised(heights: Array, noise: float, given: float | None) -> tuple[Array, Array]:
    """Heights above the ground and their weights: of a histogram, so that one large plateau does not outweigh all."""
    above = heights[heights > (given / 2 if given else max(2 * noise, 0.005))]
    if len(above) < 20:
        raise ScanError("nothing is above the ground plane; is there a field in the cloud, and is it not upside down?")
    top = float(np.quantile(above, 0.995))
    counts, edges = np.histogram(above, bins=400, range=(0, top * 1.02))
    kept = counts > 0
    return ((edges[:-1] + edges[1:]) / 2)[kept], np.sqrt(counts[kept])


def _agreement(values: Array, weights: Array, units: Array) -> Array:
    """For each unit: the mean of cos(2 pi h / unit), 1 if all heights are whole multiples of it."""
    waves = np.cos(2 * np.pi * values[None] / units[:, None])
    return np.asarray(waves @ weights / weights.sum())
