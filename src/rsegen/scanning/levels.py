"""The height of a unit in a cloud, and the level of every cell with its confidence.

Unit: tops at heights h agree on a unit u as far as the mean of cos(2 pi h / u) goes, which is 1 if all heights are
whole multiples of u and about 0 for others. A half or a third of the unit agrees as well, so the largest that does
counts.

Cells: the height of a cell is the mean of the points near their median, in the inner 60 % of the cell, where no point
of a side is; if these points rise from one side of it to the other, they are of no top. A plane (the ground was off by
a little) and the unit are then fitted through all tops. The confidence of a level is the probability that a normal
error, of the mean of its points and of what all heights have in common, is less than half a unit; by Bayes it is less
if the height is one that few blocks have, and other things have as often.

Board: tops on a board have heights `board + level unit`, floor has 0, so a line through the medians of the levels has
an intercept; the cloud is then read again from the top of the board.

Cost: linear in the points, and sorting them by cell. It fails if tops of one level only are seen, for which every
height is a unit, and if fewer than half of a cell's points are of its top.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import erf, pi, sqrt

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.params.sorts import Cell
from rsegen.scanning.grid import CloudGrid

_CORE = 0.3
"""Points up to this share of a width from a cell's middle count; those of sides are at 0.5. With 0.48 some levels
of nine fields are wrong, with less there are fewer points."""

_WIDE_CORE = 0.42
"""Core for clouds of fewer than ten points in a typical one: twice as many points, nearer to the sides."""

_NOISE = 1.3
"""Deviations of the noise that points of a level top may have: of 25 points, one in a hundred cells has more."""

_FEWEST_POINTS = 5
"""Points of a height, at the least: the median of five stands two outliers."""

_RISE, _SURELY = 0.5, 5.0
"""Units by which the points of a cell rise over its width if they are of no top, and times that this rise explains
their variance better than chance (F of 2 and n - 3): of level tops of 20 points one in a hundred has more. Smoothed
depths hang between the edge of a block and what is behind it, over all cells that it hides: by several units each."""

_FEWEST_SHARE = 0.04
"""Share of the points of a typical cell, at the least: of fewer, most may be of sides or of noise."""

_END = 0.001
"""Share of the points that may be beyond the ends of a cloud, as outliers are: of 12 cells a hundredth of one."""

_MOST_CELLS = 4_000_000
"""Cells of a reading, at the most: 64 MB; a larger grid has been found in something else than blocks."""

_OTHER = 0.01
"""Share of the cells that have something else on top than their block, before they are seen: one of 100. A tenth of
it, or ten times as much, moves the height from which such a cell is not sure by a sixth."""

_SAWN = 0.02
"""Share of a unit by which posts differ at the least: 2 mm of 10 cm, as saws cut."""

_MOST_SHIFT = 0.35
"""Share of a unit: a cell whose height is farther from a level does not decide how the plane lies. At half a unit it
may belong to either level."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reading:
    """Heights that a cloud has in the cells of a rectangle of its grid; all arrays (n_x, n_y).

    heights: of the tops above the ground [m], nan where too few points are; counts: points that agree on it;
    slopes: standard deviation of these points beyond that of noise [m], 0 for a level top; strays: share of all points
    that are more than half a unit off it; spread: standard deviation of one point [m]; first: the grid's indices of
    cell (0, 0); ends: (2, 2), the lowest and highest x and y of the points, in cells from it, None of a part.
    """

    heights: Array
    counts: Ints
    slopes: Array
    strays: Array
    spread: float
    first: Cell
    ends: Array | None = None

    @property
    def seen(self) -> Mask:
        """Cells that have a height."""
        return np.isfinite(self.heights)

    def levels(self, unit: float) -> Ints:
        """Return the nearest level of every cell, -1 where it was not seen."""
        return np.where(self.seen, np.maximum(np.rint(np.nan_to_num(self.heights) / unit), 0), -1).astype(np.int64)

    def confidence(self, unit: float) -> Array:
        """Return the probability that each level is right, 0 where a cell was not seen.

        The error of a height is normal. Its variance is that of the mean of its points, of independent noise; plus
        the mean square by which all heights are off their levels; plus the square of half the height over which sloping
        points spread, as the top may be at either end of it, however many there are. Few cells have something else on
        top, at any height: a height that is unusual for a block, as far as the others are off, is more likely one of
        these (Bayes).
        """
        off = (self.heights - self.levels(unit) * unit)[self.seen]
        if not off.size:
            return np.zeros(self.heights.shape)
        shared = float(np.sqrt(np.mean(np.minimum(np.abs(off), unit / 2) ** 2)))
        slopes = sqrt(3) * self.slopes  # half the range of heights that are spread evenly
        error = np.sqrt(self.spread**2 / np.maximum(self.counts, 1) + shared**2 + slopes**2)[self.seen]
        error = np.maximum(error, 1e-6 * unit)  # of a cloud without errors
        below = np.array([erf(x) for x in (unit / 2 - off) / error / sqrt(2)])
        above = np.array([erf(x) for x in (unit / 2 + off) / error / sqrt(2)])
        typical = max(1.4826 * float(np.median(np.abs(off))), _SAWN * unit)  # a few other things do not change it
        expected = np.sqrt(self.spread**2 / np.maximum(self.counts, 1) + typical**2 + self.slopes**2)[self.seen]
        of_block = (1 - _OTHER) * np.exp(-((off / expected) ** 2) / 2) / (expected * sqrt(2 * pi))
        confidence = np.zeros(self.heights.shape)
        confidence[self.seen] = np.clip((below + above) / 2, 0, 1) * of_block / (of_block + _OTHER / unit)
        return confidence

    def part(self, corner: Cell, shape: Cell) -> Reading:
        """Return a rectangle of its cells; cells outside were not seen."""
        heights = np.full(shape, np.nan)
        counts, slopes, strays = np.zeros(shape, dtype=np.int64), np.zeros(shape), np.zeros(shape)
        own = tuple(
            slice(max(at, 0), max(min(at + cells, most), 0))
            for at, cells, most in zip(corner, shape, self.heights.shape, strict=True)
        )
        there = tuple(slice(cells.start - at, cells.stop - at) for cells, at in zip(own, corner, strict=True))
        heights[there], counts[there] = self.heights[own], self.counts[own]
        slopes[there], strays[there] = self.slopes[own], self.strays[own]
        first = self.first[0] + corner[0], self.first[1] + corner[1]
        return replace(self, heights=heights, counts=counts, slopes=slopes, strays=strays, first=first, ends=None)

    def quarter_turned(self, turns: int) -> Reading:
        """Return the reading turned counterclockwise by quarter turns about its middle; `first` is kept."""
        counts = np.rot90(self.counts, turns)
        heights, slopes, strays = (np.rot90(each, turns) for each in (self.heights, self.slopes, self.strays))
        return replace(self, heights=heights, counts=counts, slopes=slopes, strays=strays, ends=None)


def read_cells(points: Array, tops: Mask, grid: CloudGrid, unit: float, noise: float) -> Reading:
    """Return the heights of all cells of a grid that the points (n, 3) are in; unit and noise in metres.

    tops: which points are on flat tops; the others are no evidence for a height, but against one.
    """
    # The grid ends where 99.6 % of the points do, as a few outliers may be far away.
    across = (grid.rotation @ points[:, :2].T - grid.origin[:, None]) / grid.width
    cells = np.floor(across).astype(np.int64)
    low, high = (np.floor(np.quantile(across, q, axis=1)).astype(np.int64) for q in (0.002, 0.998))
    shape = int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1
    if shape[0] * shape[1] > _MOST_CELLS:
        raise ScanError(f"{shape[0]:,} x {shape[1]:,} cells in the cloud; cut everything else out of it")
    inside = ((cells >= low[:, None]) & (cells <= high[:, None])).all(axis=0)
    middle = np.abs(across - cells - 0.5).max(axis=0)
    core = inside & (middle < _CORE)
    keys = (cells[0] - low[0]) * shape[1] + cells[1] - low[1]
    if core.sum() < 2 * _FEWEST_POINTS * np.count_nonzero(np.bincount(keys[inside])):
        core = inside & (middle < _WIDE_CORE)
    # Points of a top are within 0.4 units of its median, or, if the noise is large, 2.5 standard deviations (99 %).
    keys, z, within = keys[core], points[core, 2], max(0.4 * unit, 2.5 * noise)
    heights, counts, slopes, spread = _agreed(keys, z, tops[core], shape[0] * shape[1], within)
    near = tops[core] & (np.abs(z - heights[keys]) < within)
    places = (across - cells)[:, core][:, near]
    heights[_rising(keys[near], places, z[near] / unit, heights.size)] = np.nan
    off = np.abs(z - heights[keys]) > unit / 2  # of cells that were not seen none is
    strays = np.bincount(keys, off, heights.size) / np.maximum(np.bincount(keys, minlength=heights.size), 1)
    return Reading(
        heights=heights.reshape(shape),
        counts=counts.reshape(shape),
        slopes=slopes.reshape(shape),
        strays=strays.reshape(shape),
        spread=spread,
        first=(int(low[0]), int(low[1])),
        ends=np.quantile(across, [_END, 1 - _END], axis=1) - low,
    )


def _agreed(keys: Ints, heights: Array, tops: Mask, cells: int, within: float) -> tuple[Array, Ints, Array, float]:
    """Return per cell the mean of the heights near their median, their number and their deviation beyond the noise; and
    the deviation of one height by noise.
    """
    everything = np.bincount(keys, minlength=cells)
    keys, heights = keys[tops], heights[tops]
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
    typical = counts[totals > _FEWEST_POINTS]
    fewest = max(_FEWEST_POINTS, _FEWEST_SHARE * float(np.median(typical))) if len(typical) else _FEWEST_POINTS
    # If fewer than half of all points agree, the cell has two heights, or slopes: its top may be on none of them.
    seen = (counts >= fewest) & (counts >= everything / 2)
    means = np.where(seen, sums / np.maximum(counts, 1), np.nan)
    off = (heights - means[keys])[near & seen[keys]]
    spread = 1.4826 * float(np.median(np.abs(off))) if off.size else 0.0  # robust standard deviation, as in ground.py
    # A few points of a side may be close together by chance: squares over n - 3 are the variance of Student's t.
    squares = np.bincount(keys[near], weights=(heights - means[keys])[near] ** 2, minlength=cells)
    variance = squares / np.maximum(counts - 3, 1)
    slopes = np.sqrt(np.maximum(np.nan_to_num(variance) - _NOISE**2 * spread**2, 0))
    return means, counts, slopes, spread


def _rising(keys: Ints, places: Array, heights: Array, cells: int) -> Mask:
    """Return which cells have points on a slope, and no level top, (cells,).

    keys: the cell of each point, (n,); places: of the points, (2, n), in widths; heights: (n,) in units
    """

    def of_cells(values: Array) -> Array:
        return np.asarray(np.bincount(keys, weights=values, minlength=cells), np.float64)

    # A plane per cell by least squares: two equations in the moments of its points about their mean.
    counts = np.maximum(np.bincount(keys, minlength=cells), 1)
    x, y, z = (values - (of_cells(values) / counts)[keys] for values in (*places, heights))
    xx, xy, yy, xz, yz, zz = (of_cells(a * b) for a, b in ((x, x), (x, y), (y, y), (x, z), (y, z), (z, z)))
    area = np.maximum(xx * yy - xy**2, 1e-12)  # 0 if the points are in a line
    along_x, along_y = (yy * xz - xy * yz) / area, (xx * yz - xy * xz) / area
    explained = along_x * xz + along_y * yz
    by_chance = np.maximum(zz - explained, 0) / np.maximum(counts - 3, 1)
    return np.asarray((np.hypot(along_x, along_y) > _RISE) & (explained / 2 > _SURELY * by_chance) & (counts > 3))


def levelled(reading: Reading, unit: float) -> tuple[Reading, float]:
    """Return the reading with the ground fitted anew through all tops, and the unit that fits them best [m].

    Heights are `level unit + a + b x + c y`, by least squares over all cells that were seen.
    """
    for _ in range(3):  # a better plane may change the levels of a few cells; three times is enough for a small tilt
        levels = reading.levels(unit)
        off = reading.heights - levels * unit
        used = reading.seen & (np.abs(np.nan_to_num(off, nan=np.inf)) < _MOST_SHIFT * unit)
        if used.sum() < 8:  # twice the four numbers that are fitted
            return reading, unit
        i, j = np.nonzero(used)
        columns = [np.ones(len(i)), i - i.mean(), j - j.mean()]
        if len(np.unique(levels[used])) > 1:
            columns.append(levels[used].astype(float))
        # A mean of n points has the weight sqrt(n); beyond 50 the common error of all heights is the larger part.
        weights = np.sqrt(np.minimum(reading.counts[used], 50))
        solved = np.linalg.lstsq(np.stack(columns, axis=1) * weights[:, None], off[used] * weights, rcond=None)[0]
        x, y = np.indices(off.shape)
        plane = solved[0] + solved[1] * (x - i.mean()) + solved[2] * (y - j.mean())
        unit += float(solved[3]) if len(solved) > 3 else 0.0
        reading = replace(reading, heights=reading.heights - plane)
    return reading, unit


_BOARD = 0.08
"""Share of a unit above the floor from which blocks stand on a board: 8 mm under blocks of 10 cm. Uneven floor of a
centimetre lifts them by up to 5 mm on average."""

_FEWEST_OF_LEVEL = 3
"""Tops of a level whose median counts: of three, one may be something else."""


def board_below(heights: Array, levels: Ints, unit: float) -> float:
    """Return the thickness of the board that blocks stand on [m], 0 if they stand on the floor.

    heights, levels: (n,), of the tops that were seen, frames and floor left out. Tops at `board + level unit` have an
    intercept that floor does not have. A board of half a unit makes all levels odd numbers of halves. What breaks it: a
    board as thick as a whole number of units, which is a level more; or fewer than three levels.
    """
    known, counts = _frequent(levels)
    if len(known) < 3:
        return 0.0
    apart = int(np.gcd.reduce(np.diff(known)))
    if known[0] % apart and not (levels == 0).any():
        return float(known[0] % apart) * unit
    tops = [float(np.median(heights[levels == level])) for level in known]
    # Beyond ten tops what all of a level have in common is the larger part.
    rise, board = np.polyfit(known, tops, 1, w=np.sqrt(np.minimum(counts, 10)))
    return float(board) if board > _BOARD * rise else 0.0


def units_per_level(levels: Ints) -> int:
    """Return how many of the units that were found make one: 2 if all levels (n,) are even, as tops of few other things
    lie between those of blocks.
    """
    known, _ = _frequent(levels)
    return int(np.gcd.reduce(known)) if len(known) else 1


def _frequent(levels: Ints) -> tuple[Ints, Ints]:
    """Return the levels above 0 that enough of some tops have, and how many."""
    counts = np.bincount(levels[levels > 0])
    known = np.flatnonzero(counts >= max(_FEWEST_OF_LEVEL, 0.02 * len(levels)))  # fewer are misread
    return known, counts[known]


_MOST_LEVELS = 12
"""Levels that a field may have if its unit is not known: units down to a twelfth of the highest top are tried. Small
units agree with anything that is noisy."""

_NEARLY_BEST = 0.85
"""Share of the best agreement that a larger unit needs to be taken: half the unit agrees as well as the unit itself,
and a little better by chance."""

_CLEAR = 0.25
"""Agreement of heights on a unit, at the least: from 0 for heights at random to 1. Noise of a quarter of a unit, which
mixes the levels, leaves exp(-(2 pi / 4)^2 / 2) = 0.29."""

_WRONG = 0.4
"""Share of the best agreement below which a given unit is not that of the cloud."""


def find_unit(heights: Array, noise: float, given: float | None = None) -> float:
    """Return the height of a unit in a cloud [m]: the largest of which heights above the ground are whole multiples.

    heights: of points or pixels above the ground [m]; given: what the unit should be, which is then found within a few
    per cent. Raises a ScanError if the cloud has no such unit, or another one than the one that is given.
    """
    # Units are tried from twice the noise, 3 mm or a twelfth of the highest top (its 98 % quantile) up to that top; of
    # the last run of units that agree nearly as well as the best one, its own best is the largest unit.
    values, weights = _raised(heights, noise, given)
    highest = float(values[np.cumsum(weights) >= 0.98 * weights.sum()][0])
    candidates = np.geomspace(max(2 * noise, highest / _MOST_LEVELS, 0.003), highest * 1.06, 1500)
    agreement = _agreement(values, weights, candidates)
    best = float(agreement.max())
    if given is None and best < _CLEAR:
        raise ScanError("the heights above the ground are no whole multiples of a unit; set unit_cm if they are")
    enough = _NEARLY_BEST * best if best > 0 else best  # below 0 none agrees
    last = int(np.flatnonzero(agreement >= enough)[-1])
    run = int(np.argmax(np.append(agreement[last::-1] < enough, True)))  # of candidates nearly as good
    first = last - run + 1
    unit = float(candidates[first + int(agreement[first : last + 1].argmax())])
    if given is None:
        return unit
    own = given * np.linspace(0.95, 1.05, 41)  # blocks may be 5 % higher or lower than they should
    agrees = _agreement(values, weights, own)
    if best >= _CLEAR and agrees.max() < _WRONG * best:
        raise ScanError(
            f"blocks rise by {unit * 100:.3g} cm in the cloud, not {given * 100:g} cm; set another unit_cm or values"
        )
    return float(own[int(agrees.argmax())]) if agrees.max() >= _CLEAR else given


def _raised(heights: Array, noise: float, given: float | None) -> tuple[Array, Array]:
    """Return heights above the ground and their weights: roots of a histogram's counts, so that no plateau outweighs
    all.
    """
    above = heights[heights > (given / 2 if given else max(2 * noise, 0.005))]
    if len(above) < 20:  # single outliers
        raise ScanError("nothing is above the ground plane; is there a field in the cloud, and is it not upside down?")
    top = float(np.quantile(above, 0.995))
    counts, edges = np.histogram(above, bins=400, range=(0, top * 1.02))
    kept = counts > 1  # single ones of a sparse cloud are outliers
    if not kept.any():
        raise ScanError("too few points are above the ground plane to see blocks; use a denser cloud")
    return ((edges[:-1] + edges[1:]) / 2)[kept], np.sqrt(counts[kept])


def _agreement(values: Array, weights: Array, units: Array) -> Array:
    """Return the mean of cos(2 pi h / unit) for each unit: 1 if all heights are whole multiples of it."""
    waves = np.cos(2 * np.pi * values[None] / units[:, None])
    return np.asarray(waves @ weights / weights.sum())
