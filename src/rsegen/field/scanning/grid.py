"""The grid of blocks in a cloud: its heading, the width of a block, and where its lines are, by the edges of blocks."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from rsegen.errors import ScanError
from rsegen.field.scanning.ground import sample
from rsegen.field.scanning.raster import Raster, edge_pixels, rasterized
from rsegen.field.stepfield import Array

_FEWEST_EDGES = 40
_OFF = 0.06
"""Share by which blocks of a given width may be wider or narrower in the cloud."""

_SPLIT = 0.75
"""A wider grid is taken if it explains so much of what the best one explains."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Grid:
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


def find_grid(points: Array, unit: float, noise: float, pixel: float, width: float | None = None) -> Grid:
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


def _fitted(lines: list[Array], heading: float, width: float) -> Grid:
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
    return Grid(heading=heading + turn, width=width * cos(turn), origin=origin * cos(turn))


def _phase(across: Array, width: float) -> float:
    """Where the line nearest to 0 is."""
    if not len(across):
        return 0.0
    middle = float(across.mean())
    turn = np.exp(2j * np.pi * (across - middle) / width).mean()
    return middle + float(np.angle(turn)) / (2 * pi) * width
