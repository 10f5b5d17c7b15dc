"""The search for even places: at every half cell and several headings, all places of a heading at once.

A place is good if the supports stand level within the robot's limit, and no other part is on a block. The best ones are
level, then even under the whole robot, then with ground ahead or behind on which it can drive away.

Which cells a turned rectangle overlaps, by the separating axis test.

The highest block under a shape of cells, for all of its places at once.

The cells under a robot, for every heading and every place of its origin within a cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import ceil, cos, hypot, inf, pi, sin
from typing import TypeAlias

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.footprints.footprint import TOUCHING, Footprint, Rectangle
from rsegen.params.streams import generator

_TOUCH = 1e-9
"""Metres of overlap up to which a rectangle and a cell only touch."""


def reach(rectangle: Rectangle, width: float) -> int:
    """The number of cells of this width in each direction that the rectangle can overlap, however it is turned."""
    far = hypot(max(-rectangle.low_x, rectangle.high_x), max(-rectangle.low_y, rectangle.high_y))
    return ceil(far / width) + 1


def overlapped(rectangle: Rectangle, yaw: float, at: tuple[float, float], cells: int, width: float) -> Mask:
    """Whether each of (2 cells + 1)^2 cells around the cell (0..width)^2 overlaps a rectangle, turned by yaw, at `at`.

    Two convex shapes are apart exactly if their projections on the normal of one of their sides are.
    """
    middle = (np.arange(-cells, cells + 1) + 0.5) * width
    c, s = cos(yaw), sin(yaw)
    x, y = rectangle.middle
    away_x, away_y = middle[:, None] - (at[0] + c * x - s * y), middle[None, :] - (at[1] + s * x + c * y)
    half, (half_x, half_y) = width / 2, (rectangle.length / 2, rectangle.width / 2)
    tilted = half * (abs(c) + abs(s))
    return np.asarray(
        (np.abs(away_x) < half + half_x * abs(c) + half_y * abs(s) - _TOUCH)
        & (np.abs(away_y) < half + half_x * abs(s) + half_y * abs(c) - _TOUCH)
        & (np.abs(c * away_x + s * away_y) < half_x + tilted - _TOUCH)
        & (np.abs(c * away_y - s * away_x) < half_y + tilted - _TOUCH)
    )


def apart(rectangle: Rectangle, gap: float, one: tuple[float, float, float], x: Array, y: Array, yaw: Array) -> Mask:
    """Whether the rectangle at each x, y, yaw is at least `gap` away from the one at pose `one`, along some axis."""
    half = np.array([rectangle.length / 2, rectangle.width / 2])
    first = _centres(rectangle, *(np.array([value]) for value in one))
    away = _centres(rectangle, x, y, yaw) - first
    separated = np.zeros(len(x), dtype=bool)
    for axis in (np.full(len(x), one[2]), np.full(len(x), one[2] + np.pi / 2), yaw, yaw + np.pi / 2):
        normal = np.stack([np.cos(axis), np.sin(axis)], axis=-1)
        distance = np.abs((away * normal).sum(axis=-1))
        spans = (_span(half, other - axis) for other in (np.full(len(x), one[2]), yaw))
        separated |= distance >= sum(spans) + gap
    return separated


def _centres(rectangle: Rectangle, x: Array, y: Array, yaw: Array) -> Array:
    """The centres of the rectangle at poses, shape (n, 2)."""
    along, across = rectangle.middle
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([x + c * along - s * across, y + s * along + c * across], axis=-1)


def _span(half: Array, turned: Array) -> Array:
    """Half of the projection of a rectangle, turned by an angle against the axis."""
    return np.asarray(half[0] * np.abs(np.cos(turned)) + half[1] * np.abs(np.sin(turned)))


Run: TypeAlias = tuple[int, int, int]
"""Cells of a shape that are next to each other along y: index along x, first index along y, number."""


def runs(shape: Mask) -> Sequence[Run]:
    """The runs of cells that a shape consists of."""
    padded = np.pad(shape.astype(np.int8), ((0, 0), (1, 1)))
    change = np.diff(padded, axis=1)
    starts, ends = np.argwhere(change == 1), np.argwhere(change == -1)
    return [(int(i), int(low), int(high - low)) for (i, low), (_, high) in zip(starts, ends, strict=True)]


@dataclass(frozen=True, kw_only=True, slots=True)
class Maxima:
    """The maxima of an array over 1, 2, 4, ... cells along y, of which the maximum over any run is made."""

    tables: tuple[Array, ...]

    @classmethod
    def of(cls, values: Array, longest: int) -> Maxima:
        """Those of values, for runs of up to this many cells."""
        tables, covered = [values], 1
        while 2 * covered <= min(longest, values.shape[1]):
            tables.append(np.maximum(tables[-1][:, :-covered], tables[-1][:, covered:]))
            covered *= 2
        return cls(tables=tuple(tables))

    def over(self, found: Mask, shape: tuple[int, ...]) -> Array:
        """The maximum over cells, placed at each of the first `shape` cells of the array; -inf over none."""
        highest = np.full(shape, -np.inf)
        for i, low, cells in runs(found):
            level = cells.bit_length() - 1
            table = self.tables[level]
            for j in {low, low + cells - 2**level}:
                np.maximum(highest, table[i : i + shape[0], j : j + shape[1]], out=highest)
        return highest


HEADINGS = 16
"""Headings that are tried at every place, evenly spread."""

MARGIN = 0.004
"""Metres around every part of a robot in which the ground has to be as even and as free as under it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Stencil:
    """The cells under a robot at one heading and one place `at` within its cell, as masks of (2 cells + 1)^2 cells.

    at: x and y as shares of the width of a cell; bottoms: the height of the lowest part above each cell, inf if there
    is none; outline: the rectangle around the robot; ways: the next such rectangle ahead, and behind
    """

    yaw: float
    at: tuple[float, float]
    bottoms: Array
    outline: Mask
    ways: tuple[Mask, Mask]

    @property
    def parts(self) -> Mask:
        """The cells under any part."""
        return np.isfinite(self.bottoms)

    @property
    def supports(self) -> Mask:
        """The cells under the supports."""
        return self.bottoms <= TOUCHING


def stencils(footprint: Footprint, cells: int, width: float) -> Sequence[Stencil]:
    """Those of a footprint for all headings, at the centre, an edge and a corner of a cell of this width in metres."""
    yaws = [number * 2 * pi / HEADINGS for number in range(HEADINGS)]
    return [_stencil(footprint, yaw, (x, y), cells, width) for yaw, x, y in product(yaws, (0.0, 0.5), (0.0, 0.5))]


def _stencil(footprint: Footprint, yaw: float, at: tuple[float, float], cells: int, width: float) -> Stencil:
    def under(rectangle: Rectangle) -> Mask:
        return overlapped(rectangle, yaw, (at[0] * width, at[1] * width), cells, width)

    bottoms = np.full((2 * cells + 1,) * 2, inf)
    for rectangle, bottom in footprint.undersides:
        np.minimum(bottoms, bottom, out=bottoms, where=under(rectangle.grown(MARGIN)))
    outline, length = footprint.outline, footprint.outline.length
    ahead, behind = (under(outline.ahead(sign * length)) for sign in (1, -1))
    return Stencil(yaw=yaw, at=at, bottoms=bottoms, outline=under(outline) | np.isfinite(bottoms), ways=(ahead, behind))


SPARE = 0.002
"""Metres that stay free under the body of a robot, or more if its supports are not quite level."""

GOOD = 8.0
"""Good places have the ranks 0 (best) to 7; that of another one is 8 plus its unevenness in metres."""

_LEVEL = 1 / 3
"""Of the limit: differences up to it count as level, in choosing among good places."""

_TILE = 512
"""Cells per side of the parts of a large map that are searched one after another, which needs less memory."""

_AT_ONCE = 300_000
"""Cells under robots that are looked at together."""

_ENOUGH = 32
"""Places of the best rank at one heading, or good ones in the second part, after which no more are looked for."""

_FALLBACK = 500
"""Places at one heading that are looked at if the supports are level at none."""

_OUTSIDE = 1e9
"""Metres: the height that stands for what is not on the map, or is no ground for a support."""

_EXACT = 1e-9

_MOST_CELLS = 400
"""From the origin of a robot to the end of the ground that it drives away on, a robot being 250 blocks long: the
stencils of all headings need half a gigabyte, which grows with the square, and a minute, which grows faster."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Candidates:
    """Places for one footprint, all of shape (n,): poses, metres and radians, and how even they are, metres.

    support: height difference under the supports; whole: under the whole robot; hung: by how much the highest block
    under another part is too high; uneven: the sum of what is too much; rank: see GOOD
    """

    x: Array
    y: Array
    z: Array
    yaw: Array
    support: Array
    whole: Array
    hung: Array
    uneven: Array
    rank: Array

    @classmethod
    def joined(cls, parts: Sequence[Candidates]) -> Candidates:
        """All of several."""
        return cls(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__})


def candidates(field: StepField, footprint: Footprint, rng: np.random.Generator) -> Iterator[Candidates]:
    """The places of a footprint on a field, tile by tile in a random order.

    The whole robot is on the map, and no support on a frame. Of many places a part is taken at random.
    """
    if _is_larger(footprint, field):
        return
    ground, corners = _Ground.of(field, footprint), _corners(field)
    for number in np.argsort(rng.random(len(corners)), kind="stable"):
        if found := list(ground.tile(corners[number], rng)):
            yield Candidates.joined(found)


def fits(field: StepField, footprint: Footprint) -> bool:
    """Whether a robot fits on the blocks of a field at any heading, however uneven they are."""
    if _is_larger(footprint, field):
        return False
    ground, rng = _Ground.of(field, footprint), generator(0, 0, "fits")
    return any(True for corner in _corners(field) for _ in ground.tile(corner, rng))


def _is_larger(footprint: Footprint, field: StepField) -> bool:
    """Whether a robot does not fit on a field at any heading, as sides and area tell; it would need much memory."""
    shorter, longer = sorted((footprint.outline.length, footprint.outline.width))
    x, y = field.extent
    return shorter > min(x, y) + _EXACT or longer > hypot(x, y) + _EXACT or shorter * longer > x * y + _EXACT


def _corners(field: StepField) -> Sequence[tuple[int, int]]:
    """The first cell of every tile."""
    return [(i, j) for i in range(0, field.shape[0], _TILE) for j in range(0, field.shape[1], _TILE)]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Ground:
    """A field, wider by `cells` on every side, with the stencils of a footprint.

    heights: metres, _OUTSIDE beyond the map; blocks: the same, and _OUTSIDE on frames
    """

    field: StepField
    footprint: Footprint
    cells: int
    stencils: Sequence[Stencil]
    heights: Array
    blocks: Array

    @classmethod
    def of(cls, field: StepField, footprint: Footprint) -> _Ground:
        """That of a field and a footprint."""
        outline, width = footprint.outline, field.block_width
        cells = max(reach(outline.ahead(sign * outline.length), width) for sign in (1, -1))
        if cells > _MOST_CELLS:
            problem = f"too large for blocks of {100 * width:g} cm; give a smaller robot or wider blocks"
            raise ParameterError("robot", problem)
        heights = np.pad(field.heights, cells, constant_values=_OUTSIDE)
        blocks = np.where(np.pad(field.frame, cells, constant_values=True), _OUTSIDE, heights)
        found = stencils(footprint, cells, width)
        return cls(field=field, footprint=footprint, cells=cells, stencils=found, heights=heights, blocks=blocks)

    def tile(self, corner: tuple[int, int], rng: np.random.Generator) -> Iterator[Candidates]:
        """The candidates whose origin is in a tile, heading by heading."""
        shape = tuple(min(_TILE, cells - low) for cells, low in zip(self.field.shape, corner, strict=True))
        part = tuple(slice(low, low + cells + 2 * self.cells) for low, cells in zip(corner, shape, strict=True))
        highest, lowest = (Maxima.of(table[part], 2 * self.cells + 1) for table in (self.blocks, -self.heights))
        for stencil in self.stencils:
            top = highest.over(stencil.supports, shape)
            support = np.where(top < _OUTSIDE / 2, top + lowest.over(stencil.supports, shape), _OUTSIDE)
            for number, places in enumerate(self._chosen(support, rng, ceil(_AT_ONCE / stencil.outline.sum()))):
                i, j = np.unravel_index(places, shape)
                found = self._measured(stencil, i + corner[0], j + corner[1])
                if len(found.x):
                    yield found
                if (found.rank < (GOOD if number else 1)).sum() >= _ENOUGH:
                    break

    def _chosen(self, support: Array, rng: np.random.Generator, at_once: int) -> Iterator[Ints]:
        """The flat indices of the places with level supports, mixed and in parts; if there are none, of the best."""
        level = np.flatnonzero(support <= self.footprint.limit + _EXACT)
        if len(level):
            mixed = level[np.argsort(rng.random(len(level)), kind="stable")]
            yield from (mixed[start : start + at_once] for start in range(0, len(mixed), at_once))
        elif len(possible := np.flatnonzero(support < _OUTSIDE / 2)):
            yield possible[np.argsort(support.flat[possible], kind="stable")[:_FALLBACK]]

    def _measured(self, stencil: Stencil, i: Ints, j: Ints) -> Candidates:
        """The candidates with their origins in cells i, j of the field; those that stick out over its rim left out."""
        tops = self._under(stencil.parts, i, j)
        inside = tops.max(axis=1, initial=0) < _OUTSIDE / 2
        i, j, tops = i[inside], j[inside], tops[inside]
        bottoms, limit = stencil.bottoms[stencil.parts], self.footprint.limit
        support = np.ptp(tops[:, bottoms <= TOUCHING], axis=1)
        hung = _hung(tops, bottoms, support, limit)
        outline = self._under(stencil.outline, i, j)
        whole = outline.max(axis=1, initial=-_OUTSIDE) - outline.min(axis=1, initial=_OUTSIDE)
        too_much = np.maximum(whole - self.footprint.most, 0)
        uneven = np.maximum(support - limit, 0) + hung + too_much
        steps = 4.0 * (support > _LEVEL * limit) + 2.0 * (whole > _LEVEL * limit)
        rank = np.where(uneven <= _EXACT, steps, GOOD + support + hung + too_much)
        (good,) = np.nonzero(uneven <= _EXACT)
        rank[good] += ~self._has_a_way_out(stencil, i[good], j[good])
        x, y = (
            edges[at] + share * self.field.block_width
            for edges, at, share in zip(self.field.edges(), (i, j), stencil.at, strict=True)
        )
        yaw, z = np.full(len(x), stencil.yaw), (tops - bottoms).max(axis=1, initial=0)
        values = {"support": support, "whole": whole, "hung": hung, "uneven": uneven, "rank": rank}
        return Candidates(x=x, y=y, z=z, yaw=yaw, **values)

    def _has_a_way_out(self, stencil: Stencil, i: Ints, j: Ints) -> Mask:
        """Whether the ground ahead, or that behind, is nowhere a step higher or lower that the robot cannot drive."""
        feet = self._under(stencil.supports, i, j)
        highest, lowest = feet.max(axis=1, initial=-_OUTSIDE), feet.min(axis=1, initial=_OUTSIDE)
        free = np.zeros(len(i), dtype=bool)
        for way in stencil.ways:
            ground, climb = self._under(way, i, j), self.footprint.climb + _EXACT
            free |= (ground.max(axis=1) - lowest <= climb) & (highest - ground.min(axis=1) <= climb)
        return free

    def _under(self, cells: Mask, i: Ints, j: Ints) -> Array:
        """The heights of the cells of a mask around each cell i, j of the field, shape (n, cells of the mask)."""
        away_i, away_j = np.nonzero(cells)
        return np.asarray(self.heights[i[:, None] + away_i, j[:, None] + away_j])


def _hung(tops: Array, bottoms: Array, support: Array, limit: float) -> Array:
    """By how much the highest block under a part that is no support is too high; the body keeps clear of blocks."""
    spare = np.where(bottoms > limit, np.maximum(support, SPARE)[:, None], 0.0)
    highest = tops[:, bottoms <= TOUCHING].max(axis=1, initial=-_OUTSIDE)
    above = (tops - bottoms + spare)[:, bottoms > TOUCHING].max(axis=1, initial=-_OUTSIDE)
    return np.asarray(np.maximum(above - highest, 0.0))
