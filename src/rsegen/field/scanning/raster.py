"""A point cloud from above, as square pixels with the median height of their points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.stepfield import Array, Ints

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
