"""The base classes of obstacle kinds: parameters with their bounds, and the method that makes levels of them.

A kind is a frozen dataclass under `@register` whose annotated fields are its parameters. No other module mentions it.

Random coordinates of the two ends of an obstacle that has a given size.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple, TypeVar

import numpy as np

from rsegen.errors import PluginError
from rsegen.field.stepfield import Array, Levels, Mask
from rsegen.params.registry import Contract, Registry, clash
from rsegen.params.sorts import ANYWHERE, Cell, Coordinate, Float, Integer, Place, validate
from rsegen.params.streams import randint

MOST_LEVELS = 32767
"""Of an obstacle: the heights of blocks are 16-bit integers."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The size of a map in block cells, frames left out."""

    n_x: int
    n_y: int
    chunk_size: int

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and y."""
        return self.n_x, self.n_y


class Patch(NamedTuple):
    """The levels of an obstacle in a window of the map, and the mask of the cells that it covers."""

    window: tuple[slice, slice]
    levels: Levels
    footprint: Mask


@dataclass(frozen=True, kw_only=True, slots=True)
class Obstacle(ABC):
    """An obstacle of a recipe without its position."""

    kind: ClassVar[str]
    default_place: ClassVar[str] = "at a random position"
    """Where the obstacle lies if the recipe gives no position."""

    max_height: Annotated[
        int,
        Integer(
            2,
            MOST_LEVELS,
            unit="units",
            help="number of levels (also `levels`): 5 levels of 10 cm are the heights 0, 10, 20, 30, 40 cm",
        ),
    ]
    softness: Annotated[
        float,
        Float(
            0,
            100,
            unit="%",
            help="width of the slopes, 0: vertical walls; for random kinds: how much every height is reduced",
        ),
    ] = 0.0

    def __post_init__(self) -> None:
        validate(self)

    def check(self, first: Place, last: Place) -> None:  # noqa: B027  # most kinds lie anywhere
        """Raise a ParameterError if this kind cannot lie between these two ends."""

    def check_size(self, grid: Grid, first: Place | None, last: Place | None) -> None:  # noqa: B027  # most kinds fit
        """Raise a ParameterError if this kind does not fit into its position in a map."""

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """The ends if a recipe gives none: random."""
        return ANYWHERE, ANYWHERE

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """The cells of the two ends; random coordinates are uniform over the map."""
        (x1, y1), (x2, y2), n_x, n_y = first, last, grid.n_x, grid.n_y
        x1 = randint(rng, 0, n_x - 1) if x1 == "random" else x1
        y1 = randint(rng, 0, n_y - 1) if y1 == "random" else y1
        x2 = randint(rng, 0, n_x - 1) if x2 == "random" else x2
        y2 = randint(rng, 0, n_y - 1) if y2 == "random" else y2
        return (x1, y1), (x2, y2)

    @property
    def draws_nothing(self) -> bool:
        """Whether its levels follow from its two ends, so that all maps with these ends have the same."""
        return False

    @property
    def draws_by_cell(self) -> bool:
        """Whether its levels are one `drawn` from a random number for each cell of the rectangle of its ends."""
        return False

    @abstractmethod
    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """The levels of the obstacle between its two ends."""


class Shaped(Obstacle):
    """An obstacle with a profile in [0, 1], such as a barrier or peak; it covers the cells of level 1 or more."""

    __slots__ = ()

    @property
    def draws_nothing(self) -> bool:
        """If no kind derived from it says otherwise: a profile has no random numbers."""
        return type(self).patch is Shaped.patch

    @abstractmethod
    def reach(self, grid: Grid) -> float:
        """How far the obstacle may extend beyond the rectangle of its ends, in cells."""

    @abstractmethod
    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """The profile f in [0, 1] at the cell centres x of shape (n, 1) and y of shape (1, m)."""

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """The levels floor((n - 1) f): the highest on the axis or apex alone, descending in steps on the sides."""
        window = _window(grid, first, last, int(np.ceil(self.reach(grid))))

        def part(rows: slice) -> Levels:
            x, y = np.ogrid[rows, window[1]]
            with np.errstate(over="ignore"):  # a slope of almost no width
                f = self.profile(x.astype(float), y.astype(float), first, last, grid)
            return np.floor((self.max_height - 1) * f + 1e-9).astype(np.int16)

        levels = _by_rows(window, part)
        return Patch(window, levels, levels >= 1)


class Region(Obstacle):
    """A random kind: it samples every cell of the rectangle first..last, by default of the whole map."""

    __slots__ = ()
    default_place: ClassVar[str] = "on the whole map"

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """The ends if a recipe gives none: two opposite corners of the map."""
        return (0, 0), (grid.n_x - 1, grid.n_y - 1)

    @property
    def draws_by_cell(self) -> bool:
        """If no kind derived from it says otherwise."""
        return type(self).patch is Region.patch

    @abstractmethod
    def drawn(self, uniform: Array) -> Levels:
        """Levels from random numbers in [0, 1), one level per number."""

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """The level of each cell from a random number of its own."""
        window = _window(grid, first, last, 0)
        width = window[1].stop - window[1].start
        levels = _by_rows(window, lambda rows: self.levels_of(rng.random((rows.stop - rows.start, width))))
        return Patch(window, levels, np.ones(levels.shape, dtype=bool))

    def levels_of(self, uniform: Array) -> Levels:
        """What `drawn` gives; PluginError if that is not one level per number."""
        levels = self.drawn(uniform)
        if np.shape(levels) != uniform.shape:
            raise PluginError(f"obstacle kind {self.kind}: drawn() must give an array of shape {uniform.shape}")
        return levels


def _window(grid: Grid, first: Cell, last: Cell, margin: int) -> tuple[slice, slice]:
    """The rectangle of both cells, wider by `margin` on every side, clipped to the map."""
    parts = [
        slice(max(0, min(a, b) - margin), min(n, max(a, b) + margin + 1))
        for a, b, n in zip(first, last, grid.shape, strict=True)
    ]
    return parts[0], parts[1]


def _by_rows(window: tuple[slice, slice], part: Callable[[slice], Levels]) -> Levels:
    """The levels of a window, computed in batches of rows, so that the random numbers need little memory."""
    rows, columns = window
    step = max(_CELLS_AT_ONCE // (columns.stop - columns.start), 1)
    if rows.stop - rows.start <= step:
        return part(rows)
    return np.concatenate([part(slice(low, min(low + step, rows.stop))) for low in range(rows.start, rows.stop, step)])


_CELLS_AT_ONCE = 2**18

RESERVED = frozenset({"kind", "first", "last", "blend", "key"})
"""What a row of a recipe says of every obstacle, so no kind has a parameter of such a name."""


KINDS: Registry[type[Obstacle]] = Registry(
    "obstacle kind",
    package="rsegen.field.obstacles",
    group="rsegen.obstacles",
    contract=Contract(base=Obstacle, names=lambda cls: (cls.kind,), check=lambda cls: clash(cls, RESERVED)),
)
"""Every obstacle class by the name of its kind."""

_Kind = TypeVar("_Kind", bound=type[Obstacle])


def register(cls: _Kind) -> _Kind:
    """Register an obstacle class under the name of its kind."""
    KINDS.add(cls.kind, cls)
    return cls


def random_ends(first: Coordinate, last: Coordinate, span: int, cells: int, rng: np.random.Generator) -> Cell:
    """Both coordinates on one axis, `span` cells apart if at least one of them is random."""
    if first == "random" and last == "random":
        low = randint(rng, 0, cells - 1 - span)
        return low, low + span
    if first == "random":
        return _beside(last, span, cells), last  # type: ignore[arg-type,return-value]  # last is given
    if last == "random":
        return first, _beside(first, span, cells)
    return first, last


def _beside(at: int, span: int, cells: int) -> int:
    """The coordinate `span` cells further, or back if that is outside the map; always on the map."""
    return at + span if at + span < cells else max(at - span, 0)
