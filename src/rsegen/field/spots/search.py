"""The search for even places: at every half cell and several headings, all places of a heading at once.

A place is good if the supports stand level within the robot's limit, and no other part is on a block. The best ones are
level, then even under the whole robot, then with ground ahead or behind on which it can drive away.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, hypot

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.spots.footprint import TOUCHING, Footprint
from rsegen.field.spots.overlap import reach
from rsegen.field.spots.stencils import Stencil, stencils
from rsegen.field.spots.windows import Maxima
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.streams import generator

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
