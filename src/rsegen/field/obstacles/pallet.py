"""NIST's pallet patterns, with the block statistics of the one real pallet that could be measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import count
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.obstacles.base import Grid, Obstacle, Patch, register
from rsegen.field.obstacles.rearranged import rearranged
from rsegen.field.stepfield import Ints, Levels, Mask
from rsegen.params.sorts import Cell, Choice, Integer, ListOf, Place

_BEYOND = (9, 27, 24, 12)
"""Number of posts of each length in the measured pallet, outside its ridge of 4 units and the adjacent lines."""


_MANY_LEVELS = 200
_ONE_BY_ONE = 16
"""Limits of a pallet of up to 100 levels, nearly all of which need three or fewer: a third of a second each."""

_FEW_POSTS = 1000
_MOST_SPENT = 250 * _FEW_POSTS
"""Posts that are rearranged in vain in one map, a minute and a half; a small pallet costs as much as one of 1000."""


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Pallet(Obstacle):
    """Pallets of posts in one of NIST's patterns (flat, hill or diagonal), one per chunk."""

    kind: ClassVar[str] = "pallet"
    default_place: ClassVar[str] = "on every chunk"

    pattern: Annotated[
        tuple[str, ...],
        ListOf(
            Choice(("flat", "hill", "diagonal")),
            help="flat: no ridge; hill: one across x; diagonal: one from corner to corner; "
            "several alternate, chunk by chunk along x",
        ),
    ] = ("diagonal",)
    symmetry: Annotated[
        str,
        Choice(
            ("random", "symmetric"),
            help="random: both sides of the ridge are drawn; symmetric: one side mirrors the other",
        ),
    ] = "random"
    turns: Annotated[
        tuple[int, ...], ListOf(Integer(0, 3), help="quarter turns counterclockwise; several alternate")
    ] = (0,)
    step: Annotated[
        int,
        Integer(
            1,
            32767,
            unit="units",
            help="difference between one post length and the next: 2 for full-cubic pallets if "
            "the unit is half a post's width, as in maps that also have half-cubic ones",
        ),
    ] = 1

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.step >= self.max_height:
            raise ParameterError("step", f"{self.step} is more than the highest level, {self.max_height - 1}")

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Two opposite corners of the map."""
        return (0, 0), (grid.n_x - 1, grid.n_y - 1)

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """The levels of one pallet per square of chunk size, and of a smaller one for a rest at the end."""
        (x1, x2), (y1, y2) = (sorted(ends) for ends in zip(first, last, strict=True))
        levels, limits = np.zeros((x2 - x1 + 1, y2 - y1 + 1), dtype=np.int16), _Limits()
        for number, tile in enumerate(_tiles(levels.shape, grid.chunk_size)):
            pattern, turns = self.pattern[number % len(self.pattern)], self.turns[number % len(self.turns)]
            n_x, n_y = levels[tile].shape[:: -1 if turns % 2 else 1]
            levels[tile] = np.rot90(self._pallet(pattern, (n_x, n_y), limits, rng), turns)
        levels = np.floor(levels * self.step * (1 - self.softness / 100) + 1e-9).astype(np.int16)
        return Patch((slice(x1, x2 + 1), slice(y1, y2 + 1)), levels, np.ones(levels.shape, dtype=bool))

    def _pallet(self, pattern: str, shape: Cell, limits: _Limits, rng: np.random.Generator) -> Levels:
        """The levels of one pallet, unrotated, in multiples of `step`: always the same blocks in a random order."""
        top = (self.max_height - 1) // self.step
        limit = max(-(-top // 2), 1)
        zones = np.minimum(_off_the_ridge(pattern, shape), 2)
        drawn = _half(pattern, shape) if self.symmetry == "symmetric" else np.ones(shape, dtype=bool)
        shoulders = dict.fromkeys(range(max(top - 2, top - limit), top), 1.0)
        levels = np.full(shape, -1)
        ridge, beside = partial(_shared, {top: 1.0}), partial(_shared, shoulders)
        for zone, shared in enumerate((ridge, beside, partial(_shared_beyond, top))):
            cells = np.flatnonzero(drawn & (zones == zone))
            levels.flat[cells[np.argsort(rng.random(len(cells)), kind="stable")]] = shared(len(cells))
        zones = np.where(drawn & (zones > 0), zones, -1)
        orders = (rearranged(levels, most, rng, zones) for most in limits.of_a_pallet(limit, top, levels.size))
        found = next(order for order in orders if order is not None)  # small pallets of many levels have higher steps
        return np.asarray(np.where(drawn, found, _mirrored(pattern, found)))


class _Limits:
    """The largest steps with which the pallets of one map are tried, from the smoothest on.

    One by one, as long as that is quick; after `_ONE_BY_ONE` of a pallet, or if the map has cost too much already, ever
    further apart, and the next pallets begin where these ended. So from the start if there are very many levels.
    """

    def __init__(self) -> None:
        self._spent, self._highest = 0, 0

    def of_a_pallet(self, least: int, top: int, posts: int) -> Iterator[int]:
        """Limits from `least` to `top`, with which every order is right; ask for the next one if there is no order."""
        many = top > _MANY_LEVELS
        limit = max(least, min(self._highest, top)) if many or self._spent > _MOST_SPENT else least
        apart = 1
        for tried in count(1):
            self._highest = max(self._highest, limit)
            yield limit
            if limit == top:
                return
            self._spent += max(posts, _FEW_POSTS)
            one_by_one = tried < _ONE_BY_ONE and self._spent <= _MOST_SPENT and not many
            apart = 1 if one_by_one else (16 if many else 4) * apart
            limit = min(limit + apart, top)


def _tiles(shape: Cell, side: int) -> Iterator[tuple[slice, slice]]:
    """Squares of `side` cells, along x first."""
    for y in range(0, shape[1], side):
        for x in range(0, shape[0], side):
            yield slice(x, x + side), slice(y, y + side)


def _off_the_ridge(pattern: str, shape: Cell) -> Ints:
    """Distance of each post from the ridge, in lines of posts; flat pallets have a distance beyond all of them."""
    n_x, n_y = shape
    i, j = np.ogrid[:n_x, :n_y]
    if pattern == "diagonal":
        return np.asarray(np.abs((2 * i + 1) * n_y - (2 * j + 1) * n_x) * max(shape) // (2 * n_x * n_y))
    far = max(shape) if pattern == "flat" else 0
    return np.broadcast_to(np.abs(2 * i + 1 - n_x) // 2 + far, shape)


def _half(pattern: str, shape: Cell) -> Mask:
    """The mask of the ridge and one side of it."""
    n_x, n_y = shape
    i, j = np.ogrid[:n_x, :n_y]
    if pattern == "diagonal":
        return np.asarray((2 * i + 1) * n_y >= (2 * j + 1) * n_x)
    return np.broadcast_to(2 * i + 1 <= n_x, shape)


def _mirrored(pattern: str, levels: Levels) -> Levels:
    """The levels mirrored across the ridge; for a diagonal that is not square, rotated by half a turn."""
    if pattern != "diagonal":
        return levels[::-1]
    return levels.T if levels.shape[0] == levels.shape[1] else levels[::-1, ::-1]


@lru_cache(maxsize=64)
def _shared_beyond(top: int, blocks: int) -> Ints:
    """The levels of `blocks` blocks outside the ridge and its shoulders, for posts of up to `top` steps."""
    at = np.linspace(0, len(_BEYOND) - 1, top) if top > 1 else np.zeros(top)
    return _shared(dict(enumerate(np.interp(at, range(len(_BEYOND)), _BEYOND).tolist())), blocks)


def _shared(wanted: dict[int, float], blocks: int) -> Ints:
    """The levels of `blocks` blocks in the wanted proportions, by the method of largest remainders."""
    exact = np.array(list(wanted.values())) / sum(wanted.values()) * blocks
    counts = np.floor(exact + 1e-9).astype(np.int64)
    counts[np.argsort(counts - exact, kind="stable")[: blocks - counts.sum()]] += 1
    return np.repeat(np.array(list(wanted)), counts)
