"""The grid of blocks in an upright cloud: its heading, the width of a block and its origin, from the edges of blocks.

1. Raster: the cloud from above as pixels of some six points each, with the median of their heights. Neighbouring pixels
   whose heights differ by half a unit are edges; flat pixels are tops.
2. Heading: across the right heading edges recur at every width of a block. Edges at s across a heading have the power
   |sum exp(2 pi i s / w)|^2 at a period w; where few periods have much of it, the sum of its squares is largest.
3. Widths: the periods at which this power has peaks. Halves of the true width have as much of it, and parts of a large
   field, in which edges are more or fewer, nearly as much: no threshold tells which peak is that of the blocks.
4. Least squares: every edge belongs to the nearest line; both origins, the width and the heading follow together.
5. Choice: the grid that describes the points in the fewest words (minimum description length; Rissanen 1978): a
   level for each cell that is raised, and one for each point that is at another level than its cell.

       blocks   | 2 | 0 | 1 | 2 |     3 raised cells, no point is off
       half     |2|2|0|0|1|1|2|2|     6 raised cells, no point is off
       twice    |   2   |   1   |     2 raised cells, but every second point is off

6. Refinement: edges of noisy clouds are off by a pixel or more, tops are not. Hill climbing moves the grid until
   as many points as possible are at the most frequent level of their cell.

Cost: linear in the points, of which at most 200,000 are used; the choice counts 6,000 points some 150 times for each of
six widths, the refinement 60,000 points some 170 times. It fails without steps in both directions, if most edges are
those of something else, and with fewer than three points in a typical cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.scanning.ground import level_frame, plan_width, sample

_POINTS_PER_PIXEL = 6
"""Points in the pixel of a typical point. With 3 outliers move the median: 5 of nine fields are found,
instead of all."""

_SPARSE = 2
"""Points in the pixel of a cloud that has six points in coarse pixels only: these are as large as half a block, so that
of 36 clouds of 6,000 to 15,000 points none was found; with 1 most pixels have no neighbours."""

_DENSE = 0.6
"""Share of the coarsest pixel up to which a cloud counts as dense: a fifth of a block instead of a third."""

_FEWEST_POINTS = 3
"""Points in a pixel of a dense cloud, at the least: single points in the air are outliers. With 5 of them 7 of nine
fields are found, instead of all."""

_FINEST = 0.002
"""Smallest side of a pixel in metres: a fiftieth of a block of 10 cm, finer than any cloud shows an edge."""

_NARROWEST = 2
"""Pixels across a block, at the least: with fewer, edges of neighbouring lines are in the same pixels."""

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
    """Return the side of a pixel that has some six points [m], or else two, or the coarsest that is allowed."""
    extent = np.ptp(points[:, :2], axis=0).max()
    for enough, most in ((_POINTS_PER_PIXEL, _DENSE * coarsest), (_SPARSE, coarsest)):
        pixel = max(_FINEST, float(extent) / float(np.sqrt(_MOST_PIXELS)))
        while pixel < most:
            keys = _keys(points, pixel)[0]
            if np.median(np.bincount(keys)[keys]) >= enough:
                return pixel
            pixel *= 1.3  # in small steps, so that it is at most a third coarser than needed
    return pixel


def rasterized(points: Array, pixel: float) -> Raster:
    """Return the raster of points (n, 3): x, y and height [m]."""
    keys, corner, shape = _keys(points, pixel)
    order, starts, counts = _by_pixel(points, keys)
    keys, heights = keys[order], points[order, 2]
    raster = np.full(shape[0] * shape[1], np.nan)
    median = (heights[starts + (counts - 1) // 2] + heights[starts + counts // 2]) / 2
    raster[keys[starts]] = np.where(counts >= (_FEWEST_POINTS if _is_dense(counts) else 1), median, np.nan)
    return Raster(heights=raster.reshape(shape), corner=corner, pixel=pixel)


def _by_pixel(points: Array, keys: Ints) -> tuple[Ints, Ints, Ints]:
    """Return the order of points by the keys of their pixels and then by height, and where each pixel begins in it.

    So the points of a pixel follow one another, and their median is in the middle; last, how many each has.
    """
    order = np.lexsort((points[:, 2], keys))
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    return order, starts, np.diff(np.append(starts, len(keys)))


def _is_dense(counts: Ints) -> bool:
    """Return whether the pixel of a typical point has enough points."""
    return bool(np.median(np.repeat(counts, counts)) >= _POINTS_PER_PIXEL)


def _keys(points: Array, pixel: float) -> tuple[Ints, Array, tuple[int, int]]:
    """Return the flat index of each point's pixel, the corner of the first pixel and the shape of the raster."""
    corner = np.array([points[:, axis].min() for axis in (0, 1)])
    i, j = (np.floor((points[:, axis] - corner[axis]) / pixel).astype(np.int64) for axis in (0, 1))
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


def edge_pixels(raster: Raster, least: float, axis: int) -> Array:
    """Return the centres (n, 2) of pixels whose neighbours along an axis differ in height by more than `least` [m]."""
    heights = raster.heights if axis == 0 else raster.heights.T
    with np.errstate(invalid="ignore"):
        edges = np.argwhere(np.abs(heights[2:] - heights[:-2]) > least)
    edges[:, 0] += 1  # the pixel between the two
    return raster.centres(edges if axis == 0 else edges[:, ::-1])


_FEWEST_EDGES = 40
"""Edge pixels, at the least, and a quarter of them in each direction: a single block of 10 pixels per side has 40."""

_OFF = 0.06
"""Share by which blocks of a given width may be wider or narrower in the cloud, by gaps between them and by scale."""

_FEWEST_BLOCKS = 3
"""Blocks along a side of a field, at the least: wider periods are those of the whole field."""

_NARROWER = 0.02
"""Share by which widths are also tried narrower: blocks hide edges behind them, so that the edges of oblique views lie
1 to 4 % too far apart, and hill climbing may stop there."""

_MOST_WIDTHS = 6
"""Widths that are tried, those of the most power: of 113 clouds 110 had that of their blocks among these, 95 as the
first."""


_MOST_WRONG, _SOME_WRONG = 3, 0.025
"""Times the fewest points that are off in any grid, and share of all points, that may be off in the one that is taken:
wider blocks, of which one point in thirteen is off, describe a large field of wide obstacles in fewer words, although
there is a grid of which none is. Halves of blocks have hardly fewer than the blocks themselves."""


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
    raster = rasterized(few, pixel)
    edges = np.concatenate([edge_pixels(raster, least, axis) for axis in (0, 1)])
    if len(edges) < _FEWEST_EDGES:
        raise ScanError("no grid of blocks: the cloud has almost no steps")
    heading = _heading(edges, pixel)
    raster = _turned_raster(few, heading, pixel)
    lines = [edge_pixels(raster, least, axis)[:, [axis, 1 - axis]] for axis in (0, 1)]
    if min(len(line) for line in lines) < _FEWEST_EDGES / 4:
        raise ScanError("no grid of blocks: the steps in the cloud all run in one direction")
    widths = _widths([line[:, 0] for line in lines], pixel, width)
    grids = [grid for width in widths if (grid := _fitted(lines, heading, float(width)))]
    if not grids:
        raise ScanError("no grid of blocks: the steps in the cloud are not on evenly spaced lines")
    tops = _Tops.of(points, unit, _DESCRIBED)
    tried = [_climbed(grid, tops, _COARSE_HALVINGS, narrower) for grid in grids for narrower in (0.0, _NARROWER)]
    most = _MOST_WRONG * min(map(tops.off, tried)) + _SOME_WRONG * len(tops.levels)
    return min((grid for grid in tried if tops.off(grid) <= most), key=tops.words)


def _heading(edges: Array, pixel: float) -> float:
    """Return the direction, within a quarter turn, across which edges recur most regularly [radians].

    Half a degree over 2 m is 17 mm, about two pixels, so the first search cannot step over the peak; a tenth of a
    degree is 3 mm, less than a pixel, and the least squares fit finds the rest.
    """
    few = sample(edges, 8_000)
    # The centres of pixels lie on lines themselves, those of the raster; spread over their pixels they do not.
    few = few - np.median(few, axis=0) + pixel * (np.random.default_rng(0).random(few.shape) - 0.5)
    coarse = np.radians(np.arange(0, 90, 0.5))
    best = float(coarse[int(np.argmax([_regularity(few, angle, pixel) for angle in coarse]))])
    fine = best + np.radians(np.arange(-0.6, 0.61, 0.1))
    best = float(fine[int(np.argmax([_regularity(few, angle, pixel) for angle in fine]))])
    return (best + pi / 4) % (pi / 2) - pi / 4


def _regularity(edges: Array, angle: float, pixel: float) -> float:
    """Return the sum of squares of the power of edges at all widths that blocks may have, across and along a direction.

    Without the squares it would be the number of pairs of edges that are in one slice (Parseval), in which the noise of
    all periods hides that of the blocks.
    """
    c, s = cos(angle), sin(angle)
    power: Array | float = 0.0
    radius = float(np.quantile(np.hypot(*edges.T), 0.98))  # of the middle of the field
    # Slices of half a pixel, and at least as many more without edges, in which the ends of the field cannot meet.
    count = 1 << int(np.ceil(np.log2(8 * radius / pixel)))
    for along in (edges @ (c, s), edges @ (-s, c)):
        slices = np.floor((along + radius) / pixel * 2).astype(np.int64)
        inside = slices[(slices >= 0) & (slices < count)]
        power = power + np.abs(np.fft.rfft(np.bincount(inside, minlength=count))) ** 2
    frequencies = np.fft.rfftfreq(count, pixel / 2)
    own = (frequencies >= _FEWEST_BLOCKS / (2 * radius)) & (frequencies <= 1 / (_NARROWEST * pixel))
    return float((np.asarray(power)[own] ** 2).sum())


def _turned_raster(points: Array, heading: float, pixel: float) -> Raster:
    """Return the raster of a cloud that is turned by a heading, in which edges run along the axes."""
    c, s = cos(heading), sin(heading)
    turned = points.copy()
    turned[:, :2] = points[:, :2] @ np.array([[c, -s], [s, c]])
    return rasterized(turned, pixel)


def _widths(lines: list[Array], pixel: float, given: float | None) -> Array:
    """Return widths of blocks [m] that the places of edges across their lines suggest, the most powerful first."""
    if given is not None:
        own = given * np.linspace(1 - _OFF, 1 + _OFF, 241)  # in steps of half a thousandth
        return own[[int(_power(lines, own).argmax())]]
    extent = max(float(np.ptp(np.quantile(line, [0.02, 0.98]))) for line in lines if len(line))
    # Evenly spaced in 1 / width, in which peaks are equally broad: six samples per peak.
    count = max(64, min(6000, int(6 * extent / pixel)))
    widths = 1 / np.linspace(_FEWEST_BLOCKS / extent, 1 / (_NARROWEST * pixel), count)
    power = _power(lines, widths)
    peaks = np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])) + 1
    return np.asarray(widths[peaks[np.argsort(-power[peaks], kind="stable")[:_MOST_WIDTHS]]])


def _power(lines: list[Array], widths: Array) -> Array:
    """Return how well edges lie a whole number of widths apart, from 0 to 1, for each width."""
    total = np.zeros(len(widths))
    for line in lines:
        if len(line):
            few = sample(line[:, None], 3_000)[:, 0]
            phases = 2j * np.pi * (few - few.mean())
            for part in np.array_split(np.arange(len(widths)), len(widths) // _AT_ONCE + 1):
                turns = np.exp(phases[None] / widths[part, None])
                total[part] += len(line) * np.abs(turns.mean(axis=1)) ** 2
    return total / sum(len(line) for line in lines)


_AT_ONCE = 100
"""Widths whose turns are in memory together: 5 MB, which a cache holds."""


def _fitted(lines: list[Array], heading: float, width: float) -> CloudGrid | None:
    """Return the grid through the edges by least squares: both origins, the width and the heading together.

    None if the edges are not on evenly spaced lines of about this width.

    An edge at s across and t along its line is on line i: s = origin + i width + slope t; slope is the heading's rest.
    """
    origin = np.array([_phase(line[:, 0], width) for line in lines])
    slope = 0.0
    # Edges farther from their line than a share of the width belong to other things; the share shrinks as the fit
    # becomes better, and the last one is repeated until the choice of edges settles.
    for within in (0.3, 0.25, 0.2, 0.2):
        rows, values = [], []
        for axis, line in enumerate(lines):
            turn = slope if axis == 0 else -slope
            across = line[:, 0] - origin[axis] - turn * line[:, 1]
            index = np.rint(across / width)
            near = np.abs(across - index * width) < within * width
            columns = np.zeros((int(near.sum()), 4))
            columns[:, axis] = 1
            columns[:, 2] = index[near]
            columns[:, 3] = line[near, 1] * (1 if axis == 0 else -1)
            rows.append(columns)
            values.append(line[near, 0])
        solved = np.linalg.lstsq(np.concatenate(rows), np.concatenate(values), rcond=None)[0]
        if not 0.7 * width < solved[2] < 1.4 * width:  # it ran away to another multiple of the width
            return None
        origin, width, slope = solved[:2], float(solved[2]), float(solved[3])
    turn = -float(np.arctan(slope))
    return CloudGrid(heading=heading + turn, width=width * cos(turn), origin=origin * cos(turn))


def _phase(across: Array, width: float) -> float:
    """Return the place of a line near the middle of some edges: the mean phase of the edges, as a length."""
    if not len(across):
        return 0.0
    middle = float(across.mean())
    turn = np.exp(2j * np.pi * (across - middle) / width).mean()
    return middle + float(np.angle(turn)) / (2 * pi) * width


_MOST_POINTS = 60_000
"""Points of the refinement: 600 per cell of 10 x 10, of which it needs a few dozen; its time is in proportion."""

_DESCRIBED = 6_000
"""Points by which grids are chosen: 20 or 30 per block. With many more the points at edges, which have an error in
common, count for more than the cells, and halves of blocks are taken."""

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

_COARSE_HALVINGS = 3
"""Halvings of the steps for the choice: the last are 2 % of a width."""

_MOST_LEFT = 0.6
"""Share of the points off the levels in a grid that is half a block off which the best grid may have: if it has
hardly fewer, the edges are not those of blocks. With half the share 8 of 9 true grids are refused."""


def refined(grid: CloudGrid, points: Array, unit: float) -> CloudGrid:
    """Return the grid near a given one whose cells have as few different levels as possible.

    points: (n, 3), x, y and height above the ground [m]; unit: height of a unit [m]. Hill climbing raises the number of
    points at the most frequent level of their cell. Raises a ScanError if a grid half a block away does nearly as well:
    then the edges of the cloud are not those of blocks.
    """
    tops = _Tops.of(points, unit, _MOST_POINTS)
    best = _climbed(grid, tops, _HALVINGS)
    if tops.off(best) > _MOST_LEFT * tops.off(replace(best, origin=best.origin + best.width / 2)):
        raise ScanError(
            "no grid of blocks fits the cloud; set block_width_cm and unit_cm, use a closer scan, "
            "or cut everything but the field and some floor out of it"
        )
    return best


def _climbed(grid: CloudGrid, tops: _Tops, halvings: int, narrower: float = 0.0) -> CloudGrid:
    """Return the grid near a given one that puts most points at the most frequent level of their cell.

    narrower: share of the width by which the climb starts at narrower blocks.
    """
    # The crossing nearest to the middle of the field stays in place while the grid is turned and stretched.
    middle = np.rint((np.median(tops.places[:, tops.levels > 0], axis=1) @ grid.rotation.T - grid.origin) / grid.width)
    pivot = (grid.origin + middle * grid.width) @ grid.rotation
    steps = np.array([0.01, 0.01, 0.08, 0.08])  # of a radian, of the width, of a width along x and y
    best = np.array([0, -narrower, 0, 0])
    least = tops.off(_moved(grid, pivot, best))
    for _ in range(halvings):
        for change in np.concatenate([np.diag(steps), -np.diag(steps)] * 3):  # each direction three times
            off = tops.off(_moved(grid, pivot, best + change))
            if off < least:
                best, least = best + change, off
        steps = steps / 2
    return _moved(grid, pivot, best)


def on_tops(points: Array, unit: float, noise: float, pixel: float) -> Mask:
    """Return which points are in flat pixels, if pixels are fine enough to tell.

    Phones smooth depths, so an edge becomes a slope of points that are on neither side: no evidence for any level.
    """
    if pixel > _SHARP * unit:
        return np.ones(len(points), dtype=bool)
    order, starts, counts = _by_pixel(points, _keys(points, pixel)[0])
    if not _is_dense(counts):  # too few points in a pixel to tell
        return np.ones(len(points), dtype=bool)
    heights = points[order, 2]
    low, high = heights[starts + counts // 5], heights[starts + counts - 1 - counts // 5]
    flat = (counts >= _FEWEST_POINTS) & (high - low < max(_FLAT * noise, 0.08 * unit))
    flat_point = np.zeros(len(points), dtype=bool)
    flat_point[order] = np.repeat(flat, counts)
    return flat_point


_PIXELS, _THICK = 150, 0.003
"""Pixels across a cloud in which sides are looked for: 1 cm of 1.5 m, in which a side has many points; with twice as
many some blocks are not seen. And metres within which points are as high as each other, if the noise is less."""


def without_sides(points: Array, up: Sequence[float] | None = None, eye: Array | None = None) -> Array:
    """Return the points of a cloud (n, 3) that are as high as the highest, or lowest, one in their pixel of the plan.

    Clouds that were taken from all around, or spread over a surface, have more points of sides than of tops, and sides
    are at no level. Along a side, as much is kept of what it rises from as of what it rises to, so that blocks are not
    wider. What breaks it: pixels so fine that a side has few points in one. up, eye: as for `level_frame`, whose
    ScanError it raises.
    """
    ground = level_frame(points, up, eye)
    upright = ground.apply(points)
    order, starts, counts = _by_pixel(upright, _keys(upright, plan_width(upright) / _PIXELS)[0])
    heights = upright[order, 2]
    lowest, highest = (np.repeat(heights[ends], counts) for ends in (starts, starts + counts - 1))
    is_end = np.minimum(highest - heights, heights - lowest) <= max(3 * ground.noise, _THICK)
    return np.asarray(points[np.sort(order[is_end])])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Tops:
    """Points near a level, in and around the part of a cloud that is raised: levels (n,) and places (2, n) [m]."""

    levels: Ints
    places: Array

    @classmethod
    def of(cls, points: Array, unit: float, most: int) -> _Tops:
        """Return at most `most` points of a cloud (n, 3) in whose heights a unit is known [m]."""
        raised = points[(points[:, 2] > unit / 2) & (points[:, 2] < (_HIGHEST + 0.5) * unit)]
        low, high = np.quantile(raised[:, :2], 0.02, axis=0), np.quantile(raised[:, :2], 0.98, axis=0)
        border = 0.15 * (high - low)  # some floor around the field: two or three of 10 cells
        inside = ((points[:, :2] > low - border) & (points[:, :2] < high + border)).all(axis=1)
        few = sample(points[inside], most)
        levels = np.rint(few[:, 2] / unit)
        near = (np.abs(few[:, 2] - levels * unit) < _NEAR_LEVEL * unit) & (levels >= 0) & (levels <= _HIGHEST)
        if near.sum() < 100:  # fewer than one per cell of 10 x 10
            raise ScanError("almost no points lie on top of blocks; use a scan from above, or set another unit_cm")
        return cls(levels=levels[near].astype(np.int64), places=np.ascontiguousarray(few[near, :2].T))

    def off(self, grid: CloudGrid) -> int:
        """Return the number of points at another level than the most frequent one of their cell."""
        return len(self.levels) - int(self._counts(grid).max(axis=0).sum())

    def words(self, grid: CloudGrid) -> int:
        """Return the number of levels that describe all points: one per raised cell, and one per point that is off."""
        counts = self._counts(grid)
        return len(self.levels) - int(counts.max(axis=0).sum()) + int((counts.argmax(axis=0) > 0).sum())

    def _counts(self, grid: CloudGrid) -> Ints:
        """Return the number of points by level and cell, by one histogram of both."""
        places = grid.rotation @ self.places  # x and y in rows of their own, which takes a twentieth of the time
        x, y = np.floor((places - grid.origin[:, None]) / grid.width).astype(np.int64)
        x, y = x - x.min(), y - y.min()
        row = int(y.max()) + 1
        cells, levels = (int(x.max()) + 1) * row, int(self.levels.max()) + 1
        keys = self.levels * cells + x * row + y
        return np.bincount(keys, minlength=levels * cells).reshape(levels, cells)


def _moved(grid: CloudGrid, pivot: Array, change: Array) -> CloudGrid:
    """Return a grid that is turned and stretched about a point (x, y) of the cloud, and moved."""
    turned = replace(grid, heading=grid.heading + change[0], width=grid.width * (1 + change[1]))
    return replace(turned, origin=turned.rotation @ pivot + change[2:] * grid.width)
