"""A map in the middle of a rectangle of level ground, as sub-terrains of trainers are: from (0, 0) to its size.

z = 0 is the level ground, so pits are below it. A closed mesh and boxes reach a unit below the deepest one.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from rsegen.datasets.difficulty_tiles import amid, check_tile, eased, tile_levels
from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.geometry.box_merging import Column, columns
from rsegen.geometry.mesh_kinds import mesh
from rsegen.learning.arrays import extremes
from rsegen.learning.ground import unframed
from rsegen.params.sorts import Float, Integer
from rsegen.params.streams import SEEDS
from rsegen.recipe.recipe import Recipe

SAMPLES = Integer(1, 20)
"""Heights along each side of a block of a height field."""

SPAWN_RADIUS = Float(0, 100)
"""Metres around the middle of a tile above whose highest block its origin is."""

_SAME = 1e-6
"""Metres below which lengths count as equal: a size of 8 m is not exactly 80 times 0.1 m."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tile:
    """A tile of level ground with a map in it: a field that is raised by a level, so that level 0 has a surface too.

    raised: that field, about its own middle, which lies a unit lower; ground: level of the ground, z = 0, in the map;
    size: metres along x and y; origin: (3,), the middle of its map, metres, z of the highest cell that meets there.
    """

    raised: StepField
    ground: int
    size: tuple[float, float]
    origin: Array

    def mesh(self, kind: str = "merged") -> tuple[Array, Ints]:
        """Vertices (n, 3) in metres and triangles (m, 3) of its surface; `watertight`: closed."""
        surface = mesh(self.raised, kind)
        return surface.vertices + self._corner, surface.triangles

    def columns(self) -> Iterator[Column]:
        """Few boxes of one level each that fill it, metres; their material is the level."""
        return lowered_columns(self.raised, self._corner)

    def samples(self, per_block: int) -> Array:
        """Heights, metres, at the corners of small squares, as `corner_heights` of its field.

        An edge has the height of the higher block, so the outermost samples are on the sides of the tile.
        """
        return np.asarray(corner_heights(self.raised.heights, per_block) + self._corner[2])

    def origin_above(self, radius: float) -> Array:
        """Return the origin, as high as the highest block that is up to `radius` metres from it along x and y."""
        highest = highest_near(self.raised, self.origin[:2], radius) + self._corner[2]
        return np.array([*self.origin[:2], max(highest, self.origin[2])])

    def level_squares(self, side: float, most: float) -> Array:
        """Return the middles of squares of blocks, at least `side` metres wide, whose heights differ by at most `most`.

        (squares, 3), metres, z of their highest block; none of them is in a hole.
        """
        width, unit = self.raised.block_width, self.raised.unit
        wide = max(ceil(side / width - _SAME), 1)
        if wide > min(self.raised.shape):
            return np.empty((0, 3))
        low, high = extremes(self.raised.levels.astype(np.int32), (wide, wide))
        i, j = np.nonzero(((high - low) * unit <= most + _SAME) & (low > self.ground))  # `low` is raised by a level
        return np.column_stack([(i + wide / 2) * width, (j + wide / 2) * width, high[i, j] * unit + self._corner[2]])

    @property
    def _corner(self) -> Array:
        """Origin of the raised field in the frame of the tile, metres."""
        return np.array([self.size[0] / 2, self.size[1] / 2, -(self.ground + 1) * self.raised.unit])


def tile(recipe: Recipe, difficulty: float, index: int, size: Sequence[float]) -> Tile:
    """Map `index` of a recipe at a share of its difficulty, amid level ground of a size in metres.

    ParameterError if the map is larger, or if its blocks do not divide the size.
    """
    check_tile(recipe)
    width, unit = recipe.block_width_cm / 100, recipe.unit_cm / 100
    n_x, n_y = (_cells(along, axis, width) for axis, along in zip("xy", size, strict=True))
    m_x, m_y = recipe.cells
    if m_x > n_x or m_y > n_y:
        problem = f"a map of {m_x} x {m_y} cells is larger than a tile of {n_x} x {n_y}"
        raise ParameterError("size", f"{problem}; use {m_x * width:g} x {m_y * width:g} m or more, or smaller maps")
    low_x, low_y = (n_x - m_x) // 2, (n_y - m_y) // 2
    # Everything is a unit higher than it is, so that level 0 is a block too and has a surface.
    levels = np.full((n_x, n_y), recipe.ground_level + 1, dtype=np.int16)
    of_map = tile_levels(eased(recipe, difficulty), index)
    levels[low_x : low_x + m_x, low_y : low_y + m_y] = of_map + np.int16(1)
    above = float(amid(of_map)) - recipe.ground_level
    return Tile(
        raised=unframed(levels, width, unit),
        ground=recipe.ground_level,
        size=(n_x * width, n_y * width),
        origin=np.array([(low_x + m_x / 2) * width, (low_y + m_y / 2) * width, above * unit]),
    )


def lowered_columns(raised: StepField, origin: Array) -> Iterator[Column]:
    """Yield few boxes of one level each that fill a field which is raised by a level, so that level 0 has boxes too.

    origin: of the raised field, (3,), metres, a unit lower; materials are the levels before they were raised.
    """
    for centre, size, material in columns(raised):
        x, y, z = (np.array(centre) + origin).tolist()
        yield Column((x, y, z), size, material - 1)


def corner_heights(heights: Array, per_block: int) -> Array:
    """Heights at the corners of small squares of blocks (n_x, n_y), `per_block` along each side of a block.

    (n_x * per_block + 1, n_y * per_block + 1): an edge has the height of the higher block.
    """
    # Of the four squares that meet at a corner the highest counts; outside are copies of the outermost squares.
    small = np.pad(np.repeat(np.repeat(heights, per_block, axis=0), per_block, axis=1), 1, mode="edge")
    along_x = np.maximum(small[:-1], small[1:])
    return np.asarray(np.maximum(along_x[:, :-1], along_x[:, 1:]))


def slope_length(block_width: float, per_block: int) -> float:
    """Return how far a block slopes over a lower neighbour, metres, if a height field has its `corner_heights`."""
    return block_width / per_block


def highest_near(field: StepField, place: Array, radius: float) -> float:
    """Height, metres, of the highest block up to `radius` metres along x and y from a place, metres from the corner.

    -inf if no block is that near, as with a radius of 0 at the edge of two blocks.
    """
    low, high = ((place + side) / field.block_width for side in (-radius, radius))
    ends = zip(low + _SAME, high - _SAME, strict=True)
    x, y = (slice(max(floor(first), 0), ceil(last)) for first, last in ends)
    return float(field.heights[x, y].max(initial=-np.inf))


def check_recipe(recipe: object) -> None:
    """Raise a ParameterError unless a sub-terrain can be made of this."""
    if not isinstance(recipe, Recipe):
        raise ParameterError("recipe", f"{shown(recipe)} is not a recipe; pass one, and a sub-terrain for each")
    check_tile(recipe)


def hashed_index(*numbers: float | None) -> int:
    """Return the index of a map by a hash of some numbers, so that equal ones always give the same map."""
    words = b"".join(struct.pack("<d", np.nan if value is None else value) for value in numbers)
    return int.from_bytes(hashlib.blake2b(words, digest_size=8).digest(), "little") % SEEDS


def _cells(along: float, axis: str, width: float) -> int:
    """Blocks along a side of a tile."""
    cells = round(along / width)
    if cells < 1 or abs(cells * width - along) > _SAME:
        near = " or ".join(f"{count * width:g}" for count in (int(along / width), int(along / width) + 1) if count)
        raise ParameterError(
            "size", f"{along:g} m along {axis} is not a multiple of the block width {width:g} m; use {near}"
        )
    return cells
