"""NIST's pallet patterns (Jacoff et al. 2008), with the block statistics of a model of one.

The model is Team Hector's visual mesh of a red diagonal pallet, `stepfield_red_diagonal.dae`, with its shortest posts
of 5 cm as level 0; the designers' own rules and cut lists could not be read. It has 10 x 10 posts, all of the highest
level on the ridge, the two adjacent lines ("shoulders") half of the level below it and half of the next, and no step
larger than half the highest level, rounded up. A pallet here has

    zone 0, the ridge       the highest level t
    zone 1, its shoulders   t - 2 and t - 1, equally often
    zone 2, beyond          levels 0 .. t - 1, in the proportions of that model

so every pallet of one pattern and size is made of the same posts. They are shuffled within their zones, and rearranged
(see `rearranged`) until no step is too large. Nearly all pallets of up to 100 levels need three attempts or fewer;
small pallets of many levels have no such order, and get the smallest larger step for which one is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import count, product
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Ints, Levels, Mask
from rsegen.obstacles.base import Filling, Grid, Obstacle, Patch, register
from rsegen.obstacles.given import SLACK
from rsegen.obstacles.rearranged import rearranged
from rsegen.params.arrays import order_of_draws
from rsegen.params.sorts import Cell, Choice, Integer, ListOf
from rsegen.params.streams import Streams

_BEYOND = (9, 27, 24, 12)
"""Number of posts of level 0, 1, 2, 3 in the model beyond its ridge (10 of level 4) and shoulders (18)."""

_MANY_LEVELS = 200
"""Highest level above which limits are not tried one by one: there would be hundreds of them."""

_ONE_BY_ONE = 16
"""Limits that are tried one after the other before they are taken further apart; each costs a third of a second.

Nearly all pallets of up to 100 levels need three or fewer.
"""

_FEW_POSTS = 1000
"""Posts below which the cost of a pallet hardly depends on their number: it is numpy's cost per call."""

_MOST_SPENT = 250 * _FEW_POSTS
"""Posts that may be rearranged in vain in one map, a minute and a half, before limits are taken further apart."""


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Pallet(Filling):
    """Pallets of posts in one of NIST's patterns (flat, hill or diagonal), one per chunk."""

    kind: ClassVar[str] = "pallet"
    also: ClassVar[tuple[str, ...]] = ("nist", "stepfield", "step_field")
    default_place: ClassVar[str] = "on every chunk"

    pattern: Annotated[
        Sequence[str],
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
    turns: Annotated[Sequence[int], ListOf(Integer(0, 3), help="quarter turns counterclockwise; several alternate")] = (
        0,
    )
    step: Annotated[
        int,
        Integer(
            1,
            32767,
            unit="units",
            usual=(1, 5),
            help="difference between one post length and the next: 2 for full-cubic pallets if "
            "the unit is half a post's width, as in maps that also have half-cubic ones",
        ),
    ] = 1

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        if self.step >= self.levels:
            raise ParameterError("step", f"{self.step} is more than the highest level, {self.levels - 1}")

    @property
    def draws_alike(self) -> bool:
        """Return whether `patch` is still the one of this class, so that pallets of many maps are made together."""
        return type(self).patch is Pallet.patch

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the levels of one pallet per square of chunk size, and of smaller ones for the rest at the ends."""
        (levels,), covered = self.spanning(grid, (last[0] - first[0], last[1] - first[1]), Streams.at(rng))
        return Patch(self.window(grid, first, last), levels, covered)

    def spanning(self, grid: Grid, span: Cell, streams: Streams) -> tuple[Levels, Mask]:
        """Return the levels of many maps (maps, n_x, n_y) between two ends that are so far apart; all are covered."""
        levels = np.zeros((len(streams), abs(span[0]) + 1, abs(span[1]) + 1), dtype=np.int16)
        limits, side = [_Limits() for _ in range(len(streams))], grid.chunk_size
        starts = product(*(range(0, cells, side) for cells in levels.shape[:0:-1]))  # along x first
        for index, (y, x) in enumerate(starts):
            tile = slice(None), slice(x, x + side), slice(y, y + side)
            pattern, turns = self.pattern[index % len(self.pattern)], self.turns[index % len(self.turns)]
            n_x, n_y = levels[tile].shape[1:][:: -1 if turns % 2 else 1]
            levels[tile] = np.rot90(self._pallets(pattern, (n_x, n_y), limits, streams), turns, axes=(1, 2))
        levels = np.floor(levels * self.step * (1 - self.softness / 100) + SLACK).astype(np.int16)
        return levels, np.ones(levels.shape[1:], dtype=bool)

    def _pallets(self, pattern: str, shape: Cell, limits: Sequence[_Limits], streams: Streams) -> Levels:
        """Return a pallet of each map, (maps, *shape), unrotated, in multiples of `step`: blocks in a random order."""
        top = (self.levels - 1) // self.step
        limit = max(-(-top // 2), 1)  # half, rounded up: 2 of 4 in Team Hector's model
        zones = np.minimum(_off_the_ridge(pattern, shape), 2)
        drawn = _half(pattern, shape) if self.symmetry == "symmetric" else np.ones(shape, dtype=bool)
        shoulders = dict.fromkeys(range(max(top - 2, top - limit), top), 1.0)
        levels = np.full((len(streams), shape[0] * shape[1]), -1, dtype=np.int16)
        on_ridge, on_shoulders = partial(_shared, {top: 1.0}), partial(_shared, shoulders)
        numbers, start = streams.drawn((int(drawn.sum()),)), 0
        for zone, shared in enumerate((on_ridge, on_shoulders, partial(_shared_beyond, top))):
            cells = np.flatnonzero(drawn & (zones == zone))
            part, start = slice(start, start + len(cells)), start + len(cells)
            np.put_along_axis(levels, cells[order_of_draws(numbers[:, part])], shared(len(cells)).astype(np.int16), 1)
        zones = np.where(drawn & (zones > 0), zones, -1)  # the ridge stays; the mirrored side is made at the end
        arranged = _arranged(
            levels.reshape(-1, *shape), zones, [own.of_a_pallet(limit, top, drawn.size) for own in limits], streams
        )
        return np.asarray(np.where(drawn, arranged, _mirrored(pattern, arranged)))


def _arranged(levels: Levels, zones: Ints, limits: Sequence[Iterator[int]], streams: Streams) -> Levels:
    """Return the levels of many maps (maps, n_x, n_y), each rearranged under the first of its limits with an order."""
    arranged, left = levels.copy(), np.arange(len(levels))
    while len(left):
        # Maps with the same limit are rearranged together; those without an order ask for their next limit.
        limit_of, is_done = np.array([next(limits[index]) for index in left.tolist()]), np.zeros(len(left), dtype=bool)
        for limit in np.unique(limit_of).tolist():
            places = np.flatnonzero(limit_of == limit)
            maps = left[places]
            own = streams.part(maps)
            arranged[maps], is_done[places] = rearranged(levels[maps], limit, own, zones)
            streams.put(maps, own)
        left = left[~is_done]
    return arranged


class _Limits:
    """Limits of the steps with which the pallets of one map are tried, from the smoothest on.

    They rise one by one as long as that is quick. After `_ONE_BY_ONE` attempts at a pallet, or if the map has cost too
    much already, they rise ever faster, and the next pallets begin with the last limit. With very many levels they do
    so from the start. The attempts then grow with the logarithm of the levels, not with the levels.
    """

    def __init__(self) -> None:
        self._spent, self._highest = 0, 0

    def of_a_pallet(self, least: int, top: int, posts: int) -> Iterator[int]:
        """Yield limits from `least` to `top`, which allows every order; ask for the next one if there is no order."""
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
            apart = 1 if one_by_one else (16 if many else 4) * apart  # up to 32766 in a few attempts
            limit = min(limit + apart, top)


def _off_the_ridge(pattern: str, shape: Cell) -> Ints:
    """Return the distance of each post from the ridge, in lines of posts; in flat pallets all are beyond shoulders."""
    n_x, n_y = shape
    i, j = np.ogrid[:n_x, :n_y]
    if pattern == "diagonal":
        return np.asarray(np.abs((2 * i + 1) * n_y - (2 * j + 1) * n_x) * max(shape) // (2 * n_x * n_y))
    far = max(shape) if pattern == "flat" else 0
    return np.broadcast_to(np.abs(2 * i + 1 - n_x) // 2 + far, shape)


def _half(pattern: str, shape: Cell) -> Mask:
    """Return the mask of the ridge and one side of it."""
    n_x, n_y = shape
    i, j = np.ogrid[:n_x, :n_y]
    if pattern == "diagonal":
        return np.asarray((2 * i + 1) * n_y >= (2 * j + 1) * n_x)
    return np.broadcast_to(2 * i + 1 <= n_x, shape)


def _mirrored(pattern: str, levels: Levels) -> Levels:
    """Return levels (maps, n_x, n_y) mirrored across the ridge; for a diagonal that is not square, turned by half."""
    if pattern != "diagonal":
        return levels[:, ::-1]
    return levels.swapaxes(1, 2) if levels.shape[1] == levels.shape[2] else levels[:, ::-1, ::-1]


@lru_cache(maxsize=64)
def _shared_beyond(top: int, blocks: int) -> Ints:
    """Return the levels of `blocks` blocks beyond the shoulders of a pallet whose ridge has level `top`.

    Other numbers of levels than the measured four take its proportions at evenly spaced points between.
    """
    at = np.linspace(0, len(_BEYOND) - 1, top) if top > 1 else np.zeros(top)
    return _shared(dict(enumerate(np.interp(at, range(len(_BEYOND)), _BEYOND).tolist())), blocks)


def _shared(wanted: dict[int, float], blocks: int) -> Ints:
    """Return the levels of `blocks` blocks in the wanted proportions, by the method of largest remainders."""
    exact = np.array(list(wanted.values())) / sum(wanted.values()) * blocks
    counts = np.floor(exact + SLACK).astype(np.int64)
    counts[np.argsort(counts - exact, kind="stable")[: blocks - counts.sum()]] += 1
    return np.repeat(np.array(list(wanted)), counts)
