"""Random blocks: every cell has its own level, uniform (the paper's figure 4), weighted, or normal.

Each level is a function of one random number u of the cell, by the inverse of its distribution, so a cell's draw does
not depend on any other cell's, and all cells of many maps are drawn by one call. The cost is O(1) per cell; weighted
and normal levels take a binary search among the levels, `counts` (a shuffle of given blocks) a sort of the cells.
`max_step` (the same blocks in an order without larger steps, see `rearranged`) ties the cells together: dozens of
sweeps over them, by the same calls for many maps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.obstacles.base import Grid, Obstacle, Patch, Region, elementwise, register
from rsegen.obstacles.rearranged import rearranged
from rsegen.params.arrays import asarray, cast, least, level_of, order_of_draws
from rsegen.params.sorts import MOST_LEVELS, Cell, Float, Integer, Json, Parameter, list_parts, refuse_longer
from rsegen.params.streams import Streams


@dataclass(frozen=True)
class Weights:
    """A weight for each level, lowest first: any numbers from 0 on, not all of them 0."""

    sort: ClassVar[Parameter] = Float(0, 1e12)
    plural: ClassVar[str] = "weights"
    meaning: ClassVar[str] = "one number from 0 on for each level, lowest level first, as in [1, 2, 2, 1, 1]"

    help: str = ""

    def check(self, where: str, value: object) -> tuple[Any, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise ParameterError(where, f"{shown(value)} is not a list of {self.plural}; expected {self.meaning}")
        refuse_longer(where, value, MOST_LEVELS)
        numbers = tuple(self.sort.check(f"{where}[{level}]", number) for level, number in enumerate(value))
        if not any(numbers):
            raise ParameterError(where, f"all {self.plural} are 0; at least one must be above 0")
        return numbers

    def parse(self, text: str) -> object:
        return [self.sort.parse(part) for part in list_parts(text)]

    def format(self, value: Any) -> str:
        return ",".join(map(str, value))

    def schema(self) -> dict[str, Json]:
        return {"type": "array", "items": self.sort.schema(), "minItems": 1, "maxItems": MOST_LEVELS}

    def describe(self) -> str:
        return self.meaning


@dataclass(frozen=True)
class Counts(Weights):
    """A number of blocks for each level, lowest first: whole numbers from 0 on, not all of them 0."""

    sort: ClassVar[Parameter] = Integer(0, 10**9)
    plural: ClassVar[str] = "counts"
    meaning: ClassVar[str] = "a number of blocks for each level, lowest level first, as in [9, 27, 33, 21, 10]"


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Random(Region):
    """Random blocks, each cell independent, with equally likely levels or by `weights`; softness scales them down."""

    kind: ClassVar[str] = "random"
    also: ClassVar[tuple[str, ...]] = ("rough", "uniform")

    weights: Annotated[
        Sequence[float] | None, Weights(help="relative frequency of each level, lowest first; default: all equal")
    ] = None
    counts: Annotated[
        Sequence[int] | None,
        Counts(help="exact number of blocks of each level, lowest first; they add up to the number of cells"),
    ] = None
    max_step: Annotated[
        int | None,
        Integer(
            1, 32767, unit="units", help="largest step between neighbours in the region; the same blocks are reordered"
        ),
    ] = None

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        for name in ("weights", "counts"):
            per_level = getattr(self, name)
            if per_level is not None and len(per_level) != self.levels:
                problem = f"{len(per_level)} {name} for {self.levels} levels; expected one for each level"
                raise ParameterError(name, problem)
        if self.counts is not None and (self.weights is not None or self.softness):
            raise ParameterError(
                "counts", "excludes weights and softness, as it sets the number of blocks of each level; leave them out"
            )

    def check_size(self, grid: Grid) -> None:
        """Raise a ParameterError if `counts` do not add up to the cells of the region."""
        if self.counts is None:
            return
        low, high = self.wanted_ends(grid)
        if "random" in (*low, *high):
            raise ParameterError("counts", "needs a region of fixed size; set first and last")
        cells = math.prod(abs(a - b) + 1 for a, b in zip(low, high, strict=True))  # type: ignore[operator]  # no "random"
        if cells != sum(self.counts):
            raise ParameterError(
                "counts", f"{sum(self.counts)} blocks for {cells} cells: the counts must add up to the number of cells"
            )

    @property
    def draws_by_cell(self) -> bool:
        """Return whether no blocks are reordered, and `patch` is still the one of this class."""
        return type(self).patch is Random.patch and self.max_step is None

    @property
    def draws_per_cell(self) -> int:
        """Return 2 if blocks are shuffled: the first number is the one of a level that is not counted."""
        return 1 if self.counts is None else 2

    @property
    def draws_alike(self) -> bool:
        """Return whether blocks are reordered, by the `patch` of this class, so that many maps are made together."""
        return type(self).patch is Random.patch and self.max_step is not None

    def levels_in_maps(self, uniform: Array) -> Levels:
        """Return levels sampled per cell, or shuffled from `counts` in each map."""
        if self.counts is None:
            return Region.levels_in_maps(self, uniform)
        # Sorted by their numbers, all permutations of the blocks are equally likely.
        blocks = asarray(np.repeat(np.arange(self.levels, dtype=np.int16), self.counts), uniform)
        levels: Levels = blocks[order_of_draws(uniform.reshape(len(uniform), -1))].reshape(uniform.shape)
        return levels

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return levels sampled per cell or shuffled from `counts`, reordered until no step exceeds `max_step`."""
        if self.counts is None and self.max_step is None:
            return Region.patch(self, grid, first, last, rng)
        (levels,), covered = self.spanning(grid, (last[0] - first[0], last[1] - first[1]), Streams.at(rng))
        return Patch(self.window(grid, first, last), levels, covered)

    def spanning(self, grid: Grid, span: Cell, streams: Streams) -> tuple[Levels, Mask]:
        """Return the levels of many maps (maps, n_x, n_y) between two ends that are so far apart; all are covered.

        ParameterError if there is no order of the blocks of a map.
        """
        shape = abs(span[0]) + 1, abs(span[1]) + 1
        levels = self.levels_in_maps(streams.drawn((self.draws_per_cell, *shape))[:, -1])
        if self.max_step is not None:
            levels, is_ordered = rearranged(levels, self.max_step, streams)
            if not is_ordered.all():
                raise ParameterError(
                    "max_step",
                    f"{self.max_step}: no order of these blocks was found; use more, or more blocks of middle levels",
                )
        return levels, np.ones(shape, dtype=bool)

    @elementwise
    def drawn(self, uniform: Array) -> Levels:
        """Return floor(n f) with f = u (1 - s/100); with weights, the level whose part of [0, 1) contains f."""
        f = uniform * (1 - self.softness / 100) if self.softness else uniform
        if self.weights is None:
            return cast(self.levels * f, "int16")  # type: ignore[no-any-return]  # f is never below 0: the floor
        shares = np.array(list(accumulate(self.weights))) / math.fsum(self.weights)
        top = max(level for level, weight in enumerate(self.weights) if weight)
        return cast(least(level_of(shares, f), top), "int16")  # type: ignore[no-any-return]  # an array as the numbers


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class NormalRandom(Region):
    """Random blocks with normally distributed heights, each cell independent; softness scales them down."""

    kind: ClassVar[str] = "normal_random"
    also: ClassVar[tuple[str, ...]] = ("normal", "gaussian", "gauss")

    spread: Annotated[
        float, Float(0.001, 100, usual=(0.05, 1), help="standard deviation, as a share of the full height")
    ] = 0.2

    @elementwise
    def drawn(self, uniform: Array) -> Levels:
        """Return floor(n f) with f = clip(0.5 + z spread, 0, 1 - eps) (1 - s/100), z the normal quantile of u.

        No quantile per cell is needed: f reaches level k if u >= P(z < z_k), so the levels are found among n bounds.
        """
        scale = self.levels * (1 - self.softness / 100)
        quantiles = ((level / scale - 0.5) / self.spread for level in range(1, math.ceil(scale)))
        # P(Z < z), rounded, so that math libraries that differ in the last bit give the same levels.
        bounds = [round(0.5 * math.erfc(-z / math.sqrt(2)), 12) for z in quantiles]
        return cast(level_of(np.array(bounds), uniform), "int16")  # type: ignore[no-any-return]  # as the numbers
