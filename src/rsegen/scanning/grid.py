"""The grid of blocks in an upright cloud: its heading, from edges; the width of a block and its origin, from tops.

1. Raster: the cloud from above as pixels of some six points each. Pixels with points half a unit apart in height are
   edges; flat pixels are tops.
2. Heading: edges of blocks lie on few lines, so the histogram of edges across the right heading has few, high bins:
   the sum of their squares is largest.
3. Width: on the true grid all points of a cell are at one level, and half a block away most cells have several. So for
   every width the points that are off the most frequent level of their cell are counted at 16 places of the grid; the
   width at which the best place has the smallest share of those of the worst is that of the blocks:

       blocks  | 2 | 0 | 1 | 2 |       half the width is as pure at its best place, but at its worst one only every
       best    |---|---|---|---|       second cell has two levels; twice the width is never pure. Edges need not be
       worst     |---|---|---|         sharp for this, nor pixels finer than a block: a few points per block do.

4. Refinement: hill climbing in heading, width and place moves the grid until as many points as possible are at the most
   frequent level of their cell.

Cost: linear in the points, of which at most 200,000 are used; the width counts 20,000 points some 16 times for each of
100 to 300 widths, the refinement 60,000 points some 170 times. It fails without steps in both directions, and if most
edges are those of something else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.scanning.ground import sample

_POINTS_PER_PIXEL = 6
"""Points in the pixel of a typical point. With 3 outliers move the median, with 10 pixels are too coarse: 5 and 4 of
nine fields are found, instead of 7."""

_FEWEST_POINTS = 3
"""Points in a pixel of a dense cloud, at the least: single points in the air are outliers. With 2 and 5 of them, 5 and
6 of nine fields are found, instead of 7."""

_FINEST = 0.002
"""Smallest side of a pixel in metres: a fiftieth of a block of 10 cm, finer than any cloud shows an edge."""

_MOST_PIXELS = 4_000_000
"""Pixels of a raster, at the most: 32 MB of heights."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Raster:
    """Median heights of the points in square pixels.

    heights: (n_x, n_y) [m], nan where too few points are; corner: x and y of the first pixel; pixel: its side [m].
    """

    heights: Array
    corner: Array
    pixel: float

    def centres(self, indices: Ints) -> Array:
        """Return the centres of the pixels of some indices (n, 2) [m]."""
        return np.asarray(self.corner + (indices + 0.5) * self.pixel)


def pixel_size(points: Array, coarsest: float) -> float:
    """Return the side of a pixel that has some six points [m], or the coarsest that is allowed."""
    extent = np.ptp(points[:, :2], axis=0).max()
    pixel = max(_FINEST, float(extent) / float(np.sqrt(_MOST_PIXELS)))
    while pixel < coarsest:
        _, counts = np.unique(_keys(points, pixel)[0], return_counts=True)
        if np.median(np.repeat(counts, counts)) >= _POINTS_PER_PIXEL:
            return pixel
        pixel *= 1.3  # in small steps, so that it is at most a third coarser than needed
    return pixel


def rasterized(points: Array, pixel: float) -> Raster:
    """Return the raster of points (n, 3): x, y and height [m]."""
    # Sorted by pixel and then by height, the points of a pixel follow one another, and their median is in the middle.
    keys, corner, shape = _keys(points, pixel)
    order = np.lexsort((points[:, 2], keys))
    keys, heights = keys[order], points[order, 2]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(np.append(starts, len(keys)))
    raster = np.full(shape[0] * shape[1], np.nan)
    median = (heights[starts + (counts - 1) // 2] + heights[starts + counts // 2]) / 2
    dense = np.median(np.repeat(counts, counts)) >= _POINTS_PER_PIXEL
    raster[keys[starts]] = np.where(counts >= (_FEWEST_POINTS if dense else 1), median, np.nan)
    return Raster(heights=raster.reshape(shape), corner=corner, pixel=pixel)


def _keys(points: Array, pixel: float) -> tuple[Ints, Array, tuple[int, int]]:
    """Return the flat index of each point's pixel, the corner of the first pixel and the shape of the raster."""
    corner = points[:, :2].min(axis=0)
    i, j = np.floor((points[:, :2] - corner) / pixel).astype(np.int64).T
    shape = int(i.max()) + 1, int(j.max()) + 1
    return i * shape[1] + j, corner, shape


def flat_heights(raster: Raster, most: float) -> Array:
    """Return the heights (n,) of the pixels on tops, whose neighbours along x and y differ by less than `most` [m]."""
    heights = raster.heights
    inner = heights[1:-1, 1:-1]
    with np.errstate(invalid="ignore"):
        flat = np.abs(heights[2:, 1:-1] - heights[:-2, 1:-1]) < most
        flat &= np.abs(heights[1:-1, 2:] - heights[1:-1, :-2]) < most
    return np.asarray(inner[flat & np.isfinite(inner)])


_RASTERS = (0, 23, 54)
"""Headings of the rasters in which edges are looked for [degrees], by no common angle apart.

Pixels lie on lines themselves. Along any heading only a third of the edges is of pixels in its lines, but all are of
blocks."""


def _edges_along(points: Array, pixel: float, least: float, heading: float) -> Array:
    """Return places (n, 2) of edges: of each pixel whose points differ in height by more than `least` [m], the middle
    between its high and its low points; pixels lie along a heading [radians].
    """
    c, s = cos(heading), sin(heading)
    turn = np.array([[c, s], [-s, c]])
    points = np.column_stack([points[:, :2] @ turn.T, points[:, 2]])
    keys, _, _ = _keys(points, pixel)
    order = np.lexsort((points[:, 2], keys))
    keys, sorted_ = keys[order], points[order]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(np.append(starts, len(keys)))
    # Two points on either side: single ones are outliers.
    low, high = sorted_[starts + np.minimum(1, counts - 1), 2], sorted_[starts + np.maximum(counts - 2, 0), 2]
    edge = (counts >= 4) & (high - low > least)
    pixels = np.repeat(np.arange(len(starts)), counts)
    is_high = sorted_[:, 2] > ((low + high) / 2)[pixels]
    middles = np.zeros((len(starts), 2))
    for side in (is_high, ~is_high):
        number = np.maximum(np.bincount(pixels[side], minlength=len(starts)), 1)
        for axis in (0, 1):
            middles[:, axis] += np.bincount(pixels[side], sorted_[side, axis], len(starts)) / number / 2
    return np.asarray(middles[edge] @ turn)


_FEWEST_EDGES = 40
"""Edges of all rasters, at the least: a single block of 10 pixels per side has 40 in each."""

_OFF = 0.06
"""Share by which blocks of a given width may be wider or narrower in the cloud, by gaps between them and by scale."""

_COUNTED = 20_000
"""Points from which the width is found: 20 per cell of 30 x 30."""

_PLACES = 4
"""Places of a grid along x and along y at which it is tried; the best is then an eighth of a block off at most."""

_STEP = 0.25
"""Blocks by which a grid of one width differs from that of the next over the whole field; it is stretched about the
middle, so that the ends of a true grid are off by a sixteenth of a block at most."""

_WORSE = 1.4
"""Times the share of the best width that a given one may have; its place and heading are not refined yet."""

_FLATTEST = 4.0
"""Units per width of a block, at the most; NIST's posts are one or two units wide."""


@dataclass(frozen=True, kw_only=True, slots=True)
class CloudGrid:
    """The lines between blocks in an upright cloud.

    heading: angle from the cloud's x to the grid's [radians]; width: of a block [m]; origin: a crossing of lines, along
    the grid's own x and y [m].
    """

    heading: float
    width: float
    origin: Array

    @property
    def rotation(self) -> Array:
        """Rotation (2, 2) from x and y of the cloud to those of the grid."""
        c, s = cos(self.heading), sin(self.heading)
        return np.array([[c, s], [-s, c]])


def find_grid(points: Array, unit: float, noise: float, pixel: float, width: float | None = None) -> CloudGrid:
    """Return the grid of points (n, 3): x, y and height above the ground [m].

    unit: height of a unit [m]; noise: standard deviation of heights [m]; pixel: side of a pixel of the raster [m];
    width: of a block [m], if it is known. Raises a ScanError if there is no grid, or one of other blocks.
    """
    few = sample(points)
    # An edge is a step of nearly half a unit, or more than the noise makes, but never as much as a whole unit.
    least = max(0.4 * unit, min(2.5 * noise, 0.8 * unit))
    edges = np.concatenate([_edges_along(few, pixel, least, radians(degrees)) for degrees in _RASTERS])
    if len(edges) < _FEWEST_EDGES:
        raise ScanError("no grid of blocks: there are hardly any steps in the cloud")
    return _gridded(few[on_tops(few, unit, noise, pixel)], _heading(edges, pixel), unit, pixel, width)


def _heading(edges: Array, pixel: float) -> float:
    """Return the direction, within a quarter turn, along which edges lie on the fewest lines [radians].

    Edges are known to about half a pixel, and a slice is as wide as that; but not narrower than a step of the search
    moves the ends of the field, so that it cannot step over the peak. The refinement finds the rest.
    """
    few = sample(edges, 8_000)
    few = few - np.median(few, axis=0)
    extent = float(np.ptp(np.quantile(few, [0.02, 0.98], axis=0), axis=0).max())
    best, angles = 0.0, np.radians(np.arange(0, 90, 0.25))
    for step in (0.25, 0.05):
        slice_ = max(pixel / 2, extent * np.radians(step))
        best = float(angles[int(np.argmax([_concentration(few, angle, slice_) for angle in angles]))])
        angles = best + np.radians(np.arange(-0.3, 0.31, 0.05))
    return (best + pi / 4) % (pi / 2) - pi / 4


def _concentration(edges: Array, angle: float, slice_: float) -> float:
    """Return the sum of squares of the numbers of edges per slice, across and along a direction."""
    c, s = cos(angle), sin(angle)
    total = 0.0
    for along in (edges @ (c, s), edges @ (-s, c)):
        slices = np.floor((along - along.min()) / slice_).astype(np.int64)
        total += float((np.bincount(slices) ** 2.0).sum())
    return total


def _gridded(points: Array, heading: float, unit: float, pixel: float, given: float | None) -> CloudGrid:
    """Return the grid of a heading at whose best place the fewest points are off their cell's level, compared with its
    worst place.
    """
    levels, places = _tops(points, unit)
    few = sample(np.column_stack([places, levels]), _COUNTED)
    levels, places = few[:, 2].astype(np.int64), few[:, :2]
    start = CloudGrid(heading=heading, width=1.0, origin=np.zeros(2))
    # Grids are stretched about the middle of what is raised, so that a width that is a little off is off by little.
    raised = (places @ start.rotation.T)[levels > 0]
    if not len(raised):
        raise ScanError("hardly a point is on top of a block; give a scan from above, or another unit_cm")
    low, high = np.quantile(raised, 0.02, axis=0), np.quantile(raised, 0.98, axis=0)
    middle, extent = (low + high) / 2, float((high - low).max())
    # Evenly spaced in 1 / width, in which equal steps move the ends of the field equally.
    widths = 1 / np.arange(2 / extent, 1 / max(pixel, unit / _FLATTEST), _STEP / extent)
    if not len(widths):
        raise ScanError("no grid of blocks: the steps in the cloud are not on evenly spaced lines")
    about = middle @ start.rotation

    def tried(heading: float, width: float) -> tuple[Array, list[CloudGrid]]:
        """Return the number of points off their cell's level at 16 places of a grid, and these grids."""
        grid = replace(start, heading=heading, width=width)
        shifts = np.stack(np.divmod(np.arange(_PLACES**2), _PLACES), axis=1) / _PLACES
        placed = [replace(grid, origin=grid.rotation @ about + width * shift) for shift in shifts]
        return np.array([len(levels) - _one_level(places, levels, grid) for grid in placed]), placed

    def share(width: float) -> float:
        counts, _ = tried(heading, width)
        return float(counts.min() / max(counts.max(), 1))

    width = min(map(float, widths), key=share)
    if given is not None:
        own = min((given * near for near in np.linspace(1 - _OFF, 1 + _OFF, 13).tolist()), key=share)
        if share(own) > _WORSE * share(width):
            raise ScanError(
                f"no grid of blocks {given * 100:g} cm wide in the cloud, but of about {width * 100:.3g} cm; "
                "give another block_width_cm"
            )
        width = own
    # Between the widths that were tried, and within the error of the heading, the ends of a long field are half a block
    # off, from where the refinement would find a grid of half the field only.
    nearby = [
        tried(heading + radians(turn), 1 / (1 / width + share * _STEP / extent))
        for turn in (-0.4, -0.2, 0, 0.2, 0.4)
        for share in (-0.6, -0.4, -0.2, 0, 0.2, 0.4, 0.6)
    ]
    others, grids = min(nearby, key=lambda of: int(of[0].min()))
    return grids[int(others.argmin())]


_MOST_POINTS = 60_000
"""Points of the refinement: 600 per cell of 10 x 10, of which it needs a few dozen; its time is in proportion."""

_NEAR_LEVEL = 0.3
"""Share of a unit: points farther from any level are of sides, and tell nothing here."""

_SHARP = 0.25
"""Share of a unit: pixels up to this side show which points lie on flat tops. Most of the coarser ones have edges."""

_FLAT = 2.5
"""Standard deviations of the noise between the 20 % and the 80 % quantile of a flat pixel's points; 1.7 are expected,
however many points there are, as their range is not."""

_HIGHEST = 30
"""Highest level that counts: 3 m of blocks of 10 cm; higher points are of other things."""

_HALVINGS = 7
"""Halvings of the steps of the climb: the last are 0.08 / 2^6, about a thousandth of a width."""

_MOST_LEFT = 0.6
"""Share of the points off their cell's level in a grid half a block away that may be left in the best grid.

In a cloud of blocks most points of the shifted grid are off, and few of the true one; if there is hardly a difference,
the edges are not those of blocks. With half the share 4 of 7 true grids are refused, as noise puts points off too.
"""


_MOST_LEFT_ALONG = 0.9
"""The same for a grid half a block away along one axis: of ridges, nothing changes along
them, and it would be 1."""


def refined(grid: CloudGrid, points: Array, unit: float) -> CloudGrid:
    """Return the grid near a given one whose cells have as few different levels as possible.

    points: (n, 3), x, y and height above the ground [m]; unit: height of a unit [m]. Hill climbing raises the number of
    points at the most frequent level of their cell. Raises a ScanError if a grid half a block away does nearly as well:
    then the edges of the cloud are not those of blocks.
    """
    levels, places = _tops(points, unit)
    if len(levels) < 100:  # fewer than one per cell of 10 x 10
        raise ScanError("hardly a point is on top of a block; give a scan from above, or another unit_cm")
    # The crossing nearest to the middle of the field stays in place while the grid is turned and stretched.
    middle = np.rint((np.median(places[levels > 0], axis=0) @ grid.rotation.T - grid.origin) / grid.width)
    pivot = (grid.origin + middle * grid.width) @ grid.rotation

    def alike(change: Array) -> int:
        return _one_level(places, levels, _moved(grid, pivot, change))

    best = _climbed(alike)
    left, aside, beyond, away = (
        len(levels) - alike(best + np.array([0, 0, *moved])) for moved in ((0, 0), (0.5, 0), (0, 0.5), (0.5, 0.5))
    )
    if left > _MOST_LEFT_ALONG * min(aside, beyond):
        raise ScanError("no grid of blocks: the steps in the cloud all run in one direction, or are not of blocks")
    if left > _MOST_LEFT * away:
        raise ScanError(
            "no grid of blocks fits the cloud; give block_width_cm and unit_cm, a closer scan, "
            "or cut everything but the field and some floor out of it"
        )
    return _moved(grid, pivot, best)


def _climbed(alike: Callable[[Array], int]) -> Array:
    """Return the correction (heading, width, x, y) that puts most points at the most frequent level of their cell."""
    steps = np.array([0.01, 0.01, 0.08, 0.08])  # of a radian, of the width, of a width along x and y
    best, most = np.zeros(4), alike(np.zeros(4))
    for _ in range(_HALVINGS):
        for change in np.concatenate([np.diag(steps), -np.diag(steps)] * 3):  # each direction three times
            count = alike(best + change)
            if count > most:
                best, most = best + change, count
        steps = steps / 2
    return best


def on_tops(points: Array, unit: float, noise: float, pixel: float) -> Mask:
    """Return which points are in flat pixels, if pixels are fine enough to tell.

    Phones smooth depths, so an edge becomes a slope of points that are on neither side: no evidence for any level.
    """
    if pixel > _SHARP * unit:
        return np.ones(len(points), dtype=bool)
    keys, _, _ = _keys(points, pixel)
    order = np.lexsort((points[:, 2], keys))
    keys, heights = keys[order], points[order, 2]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(np.append(starts, len(keys)))
    low, high = heights[starts + counts // 5], heights[starts + counts - 1 - counts // 5]
    flat = (counts >= _FEWEST_POINTS) & (high - low < max(_FLAT * noise, 0.08 * unit))
    flat_point = np.zeros(len(points), dtype=bool)
    flat_point[order] = np.repeat(flat, counts)
    return flat_point


def _tops(points: Array, unit: float) -> tuple[Ints, Array]:
    """Return level and place (x, y) of points near a level, in and around the part of the cloud that is raised."""
    raised = points[(points[:, 2] > unit / 2) & (points[:, 2] < (_HIGHEST + 0.5) * unit)]
    low, high = np.quantile(raised[:, :2], 0.02, axis=0), np.quantile(raised[:, :2], 0.98, axis=0)
    reach = 0.15 * (high - low)  # some floor around the field: two or three of 10 cells
    inside = ((points[:, :2] > low - reach) & (points[:, :2] < high + reach)).all(axis=1)
    few = sample(points[inside], _MOST_POINTS)
    levels = np.rint(few[:, 2] / unit)
    near = (np.abs(few[:, 2] - levels * unit) < _NEAR_LEVEL * unit) & (levels >= 0) & (levels <= _HIGHEST)
    return levels[near].astype(np.int64), few[near, :2]


def _moved(grid: CloudGrid, pivot: Array, change: Array) -> CloudGrid:
    """Return a grid that is turned and stretched about a point (x, y) of the cloud, and moved."""
    turned = replace(grid, heading=grid.heading + change[0], width=grid.width * (1 + change[1]))
    return replace(turned, origin=turned.rotation @ pivot + change[2:] * grid.width)


def _one_level(places: Array, levels: Ints, grid: CloudGrid) -> int:
    """Return the number of points at the most frequent level of their cell, by one histogram of (cell, level)."""
    cells = np.floor((places @ grid.rotation.T - grid.origin) / grid.width).astype(np.int64)
    cells -= cells.min(axis=0)
    keys = (cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]) * (_HIGHEST + 1) + levels
    counts = np.bincount(keys)
    counts = np.append(counts, np.zeros(-len(counts) % (_HIGHEST + 1), dtype=counts.dtype))
    return int(counts.reshape(-1, _HIGHEST + 1).max(axis=1).sum())
