"""The grid of blocks in a cloud: its heading, the width of a block, and where its lines are, by the edges of blocks.

A point cloud from above, as square pixels with the median height of their points.

Moves a grid until every cell has as few different heights as it can: what a block's top is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.stepfield import Array, Ints
from rsegen.scanning.ground import sample

_POINTS_PER_PIXEL = 6
_FEWEST_POINTS = 3
"""In a pixel of a dense cloud: single points in the air are outliers."""

_FINEST = 0.002
_MOST_PIXELS = 4_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class Raster:
    """heights: (n_x, n_y) [m], nan where hardly a point is; pixel: its side [m]; corner: x and y of the first one."""

    heights: Array
    corner: Array
    pixel: float

    def centres(self, found: Ints) -> Array:
        """The middles of pixels (n, 2) [m], of which the indices are given."""
        return np.asarray(self.corner + (found + 0.5) * self.pixel)


def pixel_size(points: Array, coarsest: float) -> float:
    """The side of a pixel that has some six points [m], or the coarsest that is allowed."""
    extent = np.ptp(points[:, :2], axis=0).max()
    pixel = max(_FINEST, float(extent) / float(np.sqrt(_MOST_PIXELS)))
    while pixel < coarsest:
        _, counts = np.unique(_keys(points, pixel)[0], return_counts=True)
        if np.median(np.repeat(counts, counts)) >= _POINTS_PER_PIXEL:
            return pixel
        pixel *= 1.3
    return pixel


def rasterized(points: Array, pixel: float) -> Raster:
    """The raster of points (n, 3): x, y and height [m]."""
    keys, corner, shape = _keys(points, pixel)
    order = np.lexsort((points[:, 2], keys))
    keys, heights = keys[order], points[order, 2]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(np.append(starts, len(keys)))
    found = np.full(shape[0] * shape[1], np.nan)
    median = (heights[starts + (counts - 1) // 2] + heights[starts + counts // 2]) / 2
    dense = np.median(np.repeat(counts, counts)) >= _POINTS_PER_PIXEL
    found[keys[starts]] = np.where(counts >= (_FEWEST_POINTS if dense else 1), median, np.nan)
    return Raster(heights=found.reshape(shape), corner=corner, pixel=pixel)


def _keys(points: Array, pixel: float) -> tuple[Ints, Array, tuple[int, int]]:
    corner = points[:, :2].min(axis=0)
    i, j = np.floor((points[:, :2] - corner) / pixel).astype(np.int64).T
    shape = int(i.max()) + 1, int(j.max()) + 1
    return i * shape[1] + j, corner, shape


def flat_heights(raster: Raster, most: float) -> Array:
    """The heights (n,) of pixels whose neighbours along x and y differ by at most so much: those of tops [m]."""
    heights = raster.heights
    inner = heights[1:-1, 1:-1]
    with np.errstate(invalid="ignore"):
        flat = np.abs(heights[2:, 1:-1] - heights[:-2, 1:-1]) < most
        flat &= np.abs(heights[1:-1, 2:] - heights[1:-1, :-2]) < most
    return np.asarray(inner[flat & np.isfinite(inner)])


def edge_pixels(raster: Raster, least: float, axis: int) -> Array:
    """The middles (n, 2) of pixels whose neighbours along an axis differ in height by at least so much [m]."""
    heights = raster.heights if axis == 0 else raster.heights.T
    with np.errstate(invalid="ignore"):
        found = np.argwhere(np.abs(heights[2:] - heights[:-2]) > least)
    found[:, 0] += 1  # the pixel between the two
    return raster.centres(found if axis == 0 else found[:, ::-1])


_FEWEST_EDGES = 40
_OFF = 0.06
"""Share by which blocks of a given width may be wider or narrower in the cloud."""

_SPLIT = 0.75
"""A wider grid is taken if it explains so much of what the best one explains."""


@dataclass(frozen=True, kw_only=True, slots=True)
class CloudGrid:
    """heading: by how much the grid's x is turned from the cloud's [radians]; width: of a block [m];
    origin: where a crossing of lines is along the grid's own x and y [m].
    """

    heading: float
    width: float
    origin: Array

    @property
    def rotation(self) -> Array:
        """(2, 2), takes x and y of the cloud to those of the grid."""
        c, s = cos(self.heading), sin(self.heading)
        return np.array([[c, s], [-s, c]])


def find_grid(points: Array, unit: float, noise: float, pixel: float, width: float | None = None) -> CloudGrid:
    """The grid of points (n, 3): x, y and height above the ground [m].

    unit: height of a unit [m]; noise: standard deviation of heights [m]; pixel: side of a pixel of the raster [m];
    width: of a block [m], if it is known. A ScanError if there is no grid, or one of other blocks.
    """
    few = sample(points)
    least = max(0.4 * unit, min(2.5 * noise, 0.8 * unit))
    raster = rasterized(few, pixel)
    edges = np.concatenate([edge_pixels(raster, least, axis) for axis in (0, 1)])
    if len(edges) < _FEWEST_EDGES:
        raise ScanError("no grid of blocks: there are hardly any steps in the cloud")
    heading = _heading(edges, pixel)
    raster = _turned_raster(few, heading, pixel)
    lines = [edge_pixels(raster, least, axis)[:, [axis, 1 - axis]] for axis in (0, 1)]
    if min(len(line) for line in lines) < _FEWEST_EDGES / 4:
        raise ScanError("no grid of blocks: the steps in the cloud all run in one direction")
    found = _width([line[:, 0] for line in lines], pixel, width)
    return _fitted(lines, heading, found)


def _heading(edges: Array, pixel: float) -> float:
    """The direction, within a quarter turn, along which the edges of blocks lie on the fewest lines [radians]."""
    few = sample(edges, 8_000)
    few = few - np.median(few, axis=0)
    coarse = np.radians(np.arange(0, 90, 0.5))
    best = float(coarse[int(np.argmax([_concentration(few, angle, 2 * pixel) for angle in coarse]))])
    fine = best + np.radians(np.arange(-0.6, 0.61, 0.1))
    best = float(fine[int(np.argmax([_concentration(few, angle, pixel) for angle in fine]))])
    return (best + pi / 4) % (pi / 2) - pi / 4


def _concentration(edges: Array, angle: float, slice_: float) -> float:
    """The sum of squares of how many edges there are per slice, across and along a direction."""
    c, s = cos(angle), sin(angle)
    total = 0.0
    for along in (edges @ (c, s), edges @ (-s, c)):
        slices = np.floor((along - along.min()) / slice_).astype(np.int64)
        total += float((np.bincount(slices) ** 2.0).sum())
    return total


def _turned_raster(points: Array, heading: float, pixel: float) -> Raster:
    c, s = cos(heading), sin(heading)
    turned = points.copy()
    turned[:, :2] = points[:, :2] @ np.array([[c, -s], [s, c]])
    return rasterized(turned, pixel)


def _width(lines: list[Array], pixel: float, given: float | None) -> float:
    """The distance of neighbouring lines [m], from the places of edges across them."""
    widest = max(float(np.ptp(np.quantile(line, [0.02, 0.98]))) for line in lines if len(line))
    if given is not None:
        own = given * np.linspace(1 - _OFF, 1 + _OFF, 241)
        return float(own[int(_power(lines, own).argmax())])
    widths = 1 / np.linspace(1 / widest, 1 / (4 * pixel), max(64, min(6000, int(6 * widest / pixel))))
    power = _power(lines, widths)
    first = int(np.argmax(power >= _SPLIT * power.max()))  # the widest
    end = first + int(np.argmax(np.append(power[first:] < _SPLIT * power.max(), True)))
    return float(widths[first + int(power[first:end].argmax())])


def _power(lines: list[Array], widths: Array) -> Array:
    """For each width: how well edges lie a whole number of widths apart, from 0 to 1."""
    total = np.zeros(len(widths))
    for line in lines:
        if len(line):
            few = sample(line[:, None], 3_000)[:, 0]
            turns = np.exp(2j * np.pi * (few - few.mean())[None] / widths[:, None])
            total += len(line) * np.abs(turns.mean(axis=1)) ** 2
    return total / sum(len(line) for line in lines)


def _fitted(lines: list[Array], heading: float, width: float) -> CloudGrid:
    """The grid through the edges by least squares: both origins, the width and the heading together.

    An edge at s across and t along its line is on line i: s = origin + i width + slope t; slope is the heading's rest.
    """
    origin = np.array([_phase(line[:, 0], width) for line in lines])
    slope = 0.0
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
        if not 0.7 * width < solved[2] < 1.4 * width:
            raise ScanError("no grid of blocks: the steps in the cloud are not on evenly spaced lines")
        origin, width, slope = solved[:2], float(solved[2]), float(solved[3])
    turn = -float(np.arctan(slope))
    return CloudGrid(heading=heading + turn, width=width * cos(turn), origin=origin * cos(turn))


def _phase(across: Array, width: float) -> float:
    """Where the line nearest to 0 is."""
    if not len(across):
        return 0.0
    middle = float(across.mean())
    turn = np.exp(2j * np.pi * (across - middle) / width).mean()
    return middle + float(np.angle(turn)) / (2 * pi) * width


_MOST_POINTS = 60_000
_NEAR_LEVEL = 0.3
"""Of a unit: points farther from any level are of sides, and tell nothing here."""

_HIGHEST = 30
_HALVINGS = 7
_MOST_LEFT = 0.6
"""Of the points that are not at their cell's level in a grid half a block away, so many may be left at most."""


def refined(grid: CloudGrid, points: Array, unit: float) -> CloudGrid:
    """The grid whose cells are of one level each as nearly as can be, near the one that is given.

    points: (n, 3), x, y and height above the ground [m]; unit: height of a unit [m]. The sum of the points at each
    cell's most frequent level is raised, by steps that are halved. A ScanError if the cells of a grid half a block
    away are nearly as much of one level each: then the edges of the cloud are not those of blocks.
    """
    levels, places = _tops(points, unit)
    if len(levels) < 100:
        raise ScanError("hardly a point is on top of a block; give a scan from above, or another unit_cm")
    middle = np.rint((np.median(places[levels > 0], axis=0) @ grid.rotation.T - grid.origin) / grid.width)
    pivot = (grid.origin + middle * grid.width) @ grid.rotation

    def alike(change: Array) -> int:
        return _one_level(places, levels, _moved(grid, pivot, change))

    best = _climbed(alike)
    away = np.array([*best[:2], *(best[2:] + 0.5)])
    if len(levels) - alike(best) > _MOST_LEFT * (len(levels) - alike(away)):
        raise ScanError(
            "no grid of blocks fits the cloud; give block_width_cm and unit_cm, a closer scan, "
            "or cut everything but the field and some floor out of it"
        )
    return _moved(grid, pivot, best)


def _climbed(alike: Callable[[Array], int]) -> Array:
    """The change of a grid for which most points are alike: of heading, width, and place along x and y."""
    steps = np.array([0.01, 0.01, 0.08, 0.08])  # of a radian, of the width, of a width along x and y
    best, most = np.zeros(4), alike(np.zeros(4))
    for _ in range(_HALVINGS):
        for change in np.concatenate([np.diag(steps), -np.diag(steps)] * 3):
            found = alike(best + change)
            if found > most:
                best, most = best + change, found
        steps = steps / 2
    return best


def _tops(points: Array, unit: float) -> tuple[Ints, Array]:
    """The level and the place (x, y) of points near a level, in the part of the cloud that is above the ground."""
    raised = points[(points[:, 2] > unit / 2) & (points[:, 2] < (_HIGHEST + 0.5) * unit)]
    low, high = np.quantile(raised[:, :2], 0.02, axis=0), np.quantile(raised[:, :2], 0.98, axis=0)
    reach = 0.15 * (high - low)
    inside = ((points[:, :2] > low - reach) & (points[:, :2] < high + reach)).all(axis=1)
    few = sample(points[inside], _MOST_POINTS)
    levels = np.rint(few[:, 2] / unit)
    near = (np.abs(few[:, 2] - levels * unit) < _NEAR_LEVEL * unit) & (levels >= 0) & (levels <= _HIGHEST)
    return levels[near].astype(np.int64), few[near, :2]


def _moved(grid: CloudGrid, pivot: Array, change: Array) -> CloudGrid:
    """A grid turned and stretched about a point (x, y) of the cloud, and moved."""
    turned = replace(grid, heading=grid.heading + change[0], width=grid.width * (1 + change[1]))
    return replace(turned, origin=turned.rotation @ pivot + change[2:] * grid.width)


def _one_level(places: Array, levels: Ints, grid: CloudGrid) -> int:
    """The number of points at the most frequent level of their cell."""
    cells = np.floor((places @ grid.rotation.T - grid.origin) / grid.width).astype(np.int64)
    cells -= cells.min(axis=0)
    keys = (cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]) * (_HIGHEST + 1) + levels
    counts = np.bincount(keys)
    counts = np.append(counts, np.zeros(-len(counts) % (_HIGHEST + 1), dtype=counts.dtype))
    return int(counts.reshape(-1, _HIGHEST + 1).max(axis=1).sum())
