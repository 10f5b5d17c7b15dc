"""Search for even places: at every half cell and 16 headings, all places of a heading at once.

A place is good if the supports stand level within the robot's limit, and no other part is on a block. The best ones are
level, then even under the whole robot, then with ground ahead or behind on which it can drive away.

1. Stencils: for each heading, and each of four places of the origin within a cell, the cells under the supports, under
   the whole robot and ahead of it. A turned rectangle overlaps a cell or not, exactly, by the separating axis test
   (Gottschalk, Lin and Manocha 1996, in the plane).
2. Filter: the height difference under the supports of all places at once. The maximum over a shape is the
   one over its runs of cells, and over a run the larger of two from tables of maxima over 2^k cells (sparse tables,
   Bender and Farach-Colton 2000).
3. Of the places that pass, drawn at random and in parts, everything else is measured, until enough are good.

       |- 4 -|
       . # # # # # .      a run of 5 cells is covered by two of 4
           |- 4 -|

Cost: 64 stencils, each some ten numpy operations on a tile of 512 x 512 cells; a map of 10 x 10 blocks takes some
hundredths of a second. Places between half cells and headings between 22.5 degrees are not tried; a margin of 4 mm
makes up for it. A robot much larger than a block makes large stencils, and is refused from 400 cells on.
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
"""Metres of overlap up to which a rectangle and a cell only touch: rounding errors of sums of metres are 1e-15."""


def reach(rectangle: Rectangle, width: float) -> int:
    """Return the number of cells of this width in each direction that a rectangle can overlap, however it is turned."""
    far = hypot(max(-rectangle.low_x, rectangle.high_x), max(-rectangle.low_y, rectangle.high_y))
    return ceil(far / width) + 1


def overlapped(rectangle: Rectangle, yaw: float, at: tuple[float, float], cells: int, width: float) -> Mask:
    """Return which of (2 cells + 1)^2 cells around the cell (0..width)^2 overlap a rectangle, turned by yaw, at `at`.

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


def apart(rectangle: Rectangle, gap: float, pose: tuple[float, float, float], x: Array, y: Array, yaw: Array) -> Mask:
    """Return whether the rectangle at each x, y, yaw is at least `gap` away from the one at a pose, along some axis."""
    half = np.array([rectangle.length / 2, rectangle.width / 2])
    first = _centres(rectangle, *(np.array([value]) for value in pose))
    away = _centres(rectangle, x, y, yaw) - first
    separated = np.zeros(len(x), dtype=bool)
    for axis in (np.full(len(x), pose[2]), np.full(len(x), pose[2] + np.pi / 2), yaw, yaw + np.pi / 2):
        normal = np.stack([np.cos(axis), np.sin(axis)], axis=-1)
        distance = np.abs((away * normal).sum(axis=-1))
        spans = (_span(half, other - axis) for other in (np.full(len(x), pose[2]), yaw))
        separated |= distance >= sum(spans) + gap
    return separated


def _centres(rectangle: Rectangle, x: Array, y: Array, yaw: Array) -> Array:
    """Return the centres of the rectangle at poses, shape (n, 2)."""
    along, across = rectangle.middle
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([x + c * along - s * across, y + s * along + c * across], axis=-1)


def _span(half: Array, turned: Array) -> Array:
    """Return half of the projection of a rectangle that is turned by an angle against the axis."""
    return np.asarray(half[0] * np.abs(np.cos(turned)) + half[1] * np.abs(np.sin(turned)))


CellRun: TypeAlias = tuple[int, int, int]
"""Cells of a shape that are next to each other along y: index along x, first index along y, number."""


def runs(shape: Mask) -> Sequence[CellRun]:
    """Return the runs of cells that a shape consists of."""
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
        """Return the maxima of values, for runs of up to `longest` cells."""
        tables, covered = [values], 1
        while 2 * covered <= min(longest, values.shape[1]):
            tables.append(np.maximum(tables[-1][:, :-covered], tables[-1][:, covered:]))
            covered *= 2
        return cls(tables=tuple(tables))

    def over(self, stencil: Mask, shape: tuple[int, ...]) -> Array:
        """Return the maximum over a stencil, placed at each of the first `shape` cells of the array; -inf over none."""
        highest = np.full(shape, -np.inf)
        for i, low, cells in runs(stencil):
            level = cells.bit_length() - 1
            table = self.tables[level]
            for j in {low, low + cells - 2**level}:
                np.maximum(highest, table[i : i + shape[0], j : j + shape[1]], out=highest)
        return highest


HEADINGS = 16
"""Headings that are tried at every place, evenly spread: 22.5 degrees apart. The time is in proportion to them."""

MARGIN = 0.004
"""Metres around every part of a robot in which the ground has to be as even and as free as under it. With less, a robot
that settles beside its pose stands on the next block; with more, narrow blocks have fewer places."""


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
    """Return the stencils of a footprint for all headings, at the centre, edges and a corner of cells of a width
    [m].
    """
    yaws = [index * 2 * pi / HEADINGS for index in range(HEADINGS)]
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
"""Metres that stay free under the body of a robot, or more if its supports are not quite level: a TurtleBot3's wheel
sinks 1 mm into the floor in Gazebo Classic (decision 8)."""

GOOD = 8.0
"""Good places have the ranks 0 (best) to 7; that of another one is 8 plus its unevenness in metres."""

_LEVEL = 1 / 3
"""Share of the limit up to which differences count as level, in choosing among good places; a smaller share leaves
fewer places to draw from."""

_TILE = 512
"""Cells per side of the parts of a large map that are searched one after another: 2 MB per table of maxima."""

_AT_ONCE = 300_000
"""Cells under robots that are measured together, of all places of a part: 2.4 MB per array."""

_ENOUGH = 32
"""Places of the best rank at one heading (in later parts: good places) after which no more are searched. With 64
stencils that is a choice among up to 2,000 places per tile."""

_FALLBACK = 500
"""Places at one heading that are measured if the supports are level at none; the evenest supports first."""

_OUTSIDE = 1e9
"""Metres: the height that stands for what is not on the map, or is no ground for a support."""

_EXACT = 1e-9
"""Metres up to which a limit may be exceeded by rounding errors."""

_MOST_CELLS = 400
"""Cells from the origin of a robot to the end of the ground that it drives away on, at the most; such a robot is 250
blocks long. The stencils of all headings need half a gigabyte, which grows with the square, and a minute, which grows
faster."""


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
        """Return the candidates of several parts as one."""
        return cls(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__})


def candidates(field: StepField, footprint: Footprint, rng: np.random.Generator) -> Iterator[Candidates]:
    """Yield the places of a footprint on a field, tile by tile in a random order.

    The whole robot is on the map, and no support on a frame. Of many places a part is taken at random.
    """
    if _is_larger(footprint, field):
        return
    ground, corners = _Ground.of(field, footprint), _corners(field)
    for index in np.argsort(rng.random(len(corners)), kind="stable"):
        if parts := list(ground.tile(corners[index], rng)):
            yield Candidates.joined(parts)


def fits(field: StepField, footprint: Footprint) -> bool:
    """Return whether a robot fits on the blocks of a field at any heading, however uneven they are."""
    if _is_larger(footprint, field):
        return False
    ground, rng = _Ground.of(field, footprint), generator(0, 0, "fits")
    return any(True for corner in _corners(field) for _ in ground.tile(corner, rng))


def _is_larger(footprint: Footprint, field: StepField) -> bool:
    """Return whether a robot is larger than a field at any heading, by sides and area; its stencils would need
    memory.
    """
    shorter, longer = sorted((footprint.outline.length, footprint.outline.width))
    x, y = field.extent
    return shorter > min(x, y) + _EXACT or longer > hypot(x, y) + _EXACT or shorter * longer > x * y + _EXACT


def _corners(field: StepField) -> Sequence[tuple[int, int]]:
    """Return the first cell of every tile."""
    return [(i, j) for i in range(0, field.shape[0], _TILE) for j in range(0, field.shape[1], _TILE)]


@dataclass(frozen=True, kw_only=True, slots=True)
class _Ground:
    """A field, wider by `cells` on every side, with the stencils of a footprint.

    heights: metres, _OUTSIDE beyond the map; blocks: heights with _OUTSIDE on frames too, where no support may stand.
    """

    field: StepField
    footprint: Footprint
    cells: int
    stencils: Sequence[Stencil]
    heights: Array
    blocks: Array

    @classmethod
    def of(cls, field: StepField, footprint: Footprint) -> _Ground:
        """Return the ground of a field with the stencils of a footprint; ParameterError if the robot is too large."""
        outline, width = footprint.outline, field.block_width
        cells = max(reach(outline.ahead(sign * outline.length), width) for sign in (1, -1))
        if cells > _MOST_CELLS:
            problem = f"too large for blocks of {100 * width:g} cm; give a smaller robot or wider blocks"
            raise ParameterError("robot", problem)
        heights = np.pad(field.heights, cells, constant_values=_OUTSIDE)
        blocks = np.where(np.pad(field.frame, cells, constant_values=True), _OUTSIDE, heights)
        shapes = stencils(footprint, cells, width)
        return cls(field=field, footprint=footprint, cells=cells, stencils=shapes, heights=heights, blocks=blocks)

    def tile(self, corner: tuple[int, int], rng: np.random.Generator) -> Iterator[Candidates]:
        """Yield the candidates whose origin is in a tile, heading by heading."""
        shape = tuple(min(_TILE, cells - low) for cells, low in zip(self.field.shape, corner, strict=True))
        part = tuple(slice(low, low + cells + 2 * self.cells) for low, cells in zip(corner, shape, strict=True))
        highest, lowest = (Maxima.of(table[part], 2 * self.cells + 1) for table in (self.blocks, -self.heights))
        # Lowest heights as maxima of negated ones, so highest + (-lowest) is the difference under the supports.
        for stencil in self.stencils:
            top = highest.over(stencil.supports, shape)
            support = np.where(top < _OUTSIDE / 2, top + lowest.over(stencil.supports, shape), _OUTSIDE)
            for part_index, places in enumerate(self._chosen(support, rng, ceil(_AT_ONCE / stencil.outline.sum()))):
                i, j = np.unravel_index(places, shape)
                measured = self._measured(stencil, i + corner[0], j + corner[1])
                if len(measured.x):
                    yield measured
                if (measured.rank < (GOOD if part_index else 1)).sum() >= _ENOUGH:
                    break

    def _chosen(self, support: Array, rng: np.random.Generator, at_once: int) -> Iterator[Ints]:
        """Yield flat indices of the places with level supports, shuffled and in parts; if there are none, of the
        best.
        """
        level = np.flatnonzero(support <= self.footprint.limit + _EXACT)
        if len(level):
            mixed = level[np.argsort(rng.random(len(level)), kind="stable")]
            yield from (mixed[start : start + at_once] for start in range(0, len(mixed), at_once))
        elif len(possible := np.flatnonzero(support < _OUTSIDE / 2)):
            yield possible[np.argsort(support.flat[possible], kind="stable")[:_FALLBACK]]

    def _measured(self, stencil: Stencil, i: Ints, j: Ints) -> Candidates:
        """Return the candidates with origins in cells i, j of the field, without those that stick out over its rim."""
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
        # Ranks 0 to 7 by three yes-or-no questions, the first of which weighs most: level supports, an even ground
        # under
        # the robot, a way out. Places that are not good have 8 and more.
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
        """Return whether the ground ahead, or behind, is nowhere higher or lower than a step that the robot can
        drive.
        """
        feet = self._under(stencil.supports, i, j)
        highest, lowest = feet.max(axis=1, initial=-_OUTSIDE), feet.min(axis=1, initial=_OUTSIDE)
        free = np.zeros(len(i), dtype=bool)
        for way in stencil.ways:
            ground, climb = self._under(way, i, j), self.footprint.climb + _EXACT
            free |= (ground.max(axis=1) - lowest <= climb) & (highest - ground.min(axis=1) <= climb)
        return free

    def _under(self, cells: Mask, i: Ints, j: Ints) -> Array:
        """Return the heights of the cells of a mask around each cell i, j of the field, shape (n, cells of the
        mask).
        """
        away_i, away_j = np.nonzero(cells)
        return np.asarray(self.heights[i[:, None] + away_i, j[:, None] + away_j])


def _hung(tops: Array, bottoms: Array, support: Array, limit: float) -> Array:
    """Return how far the highest block under the body intrudes into its clearance, metres; (n,)."""
    spare = np.where(bottoms > limit, np.maximum(support, SPARE)[:, None], 0.0)
    highest = tops[:, bottoms <= TOUCHING].max(axis=1, initial=-_OUTSIDE)
    above = (tops - bottoms + spare)[:, bottoms > TOUCHING].max(axis=1, initial=-_OUTSIDE)
    return np.asarray(np.maximum(above - highest, 0.0))
