"""The base classes of obstacle kinds: parameters with their bounds, and the method that makes levels of them.

A kind is a frozen dataclass under `@register` whose annotated fields are its parameters. No other module mentions it.
A row of a recipe becomes levels in three steps, the last two with the random generator of its key:

    first, last --wanted_ends--> places that may be "random" --ends--> two cells --patch--> levels in a window

Many maps are made at once where a kind allows it (recipe/batch.py). An `@elementwise` method may be given an array,
with a value for each map, in place of a number, and gives arrays then, so no second formula is written. A method
without the mark, also one that overrides a marked one, is called with numbers: for each map, or for each pair of ends
of a kind that `draws_nothing`. Layouts draw the numbers of all maps with rectangles alike in one array.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from rsegen.errors import PluginError
from rsegen.field.stepfield import Array, Ints, Levels, Mask
from rsegen.obstacles.ends import square_ends
from rsegen.obstacles.given import SLACK, levels_of, margin_of, refuse_other_layout
from rsegen.params.registry import Contract, Registry, name_conflict
from rsegen.params.sorts import (
    ANYWHERE,
    MOST_LEVELS,
    Cell,
    CellRef,
    Choice,
    Flag,
    Float,
    Integer,
    Json,
    Parameter,
    Place,
    Text,
    changed,
    parameters,
    validate,
)
from rsegen.params.streams import Streams, randint

_Method = TypeVar("_Method", bound=Callable[..., Any])


def elementwise(method: _Method) -> _Method:
    """Mark a method that takes arrays, a value for each map, in place of numbers: it branches on no drawn value."""
    method.is_elementwise = True  # type: ignore[attr-defined]  # of the function, so what overrides it has no mark
    return method


def is_elementwise(method: Callable[..., Any]) -> bool:
    """Return whether a method is marked as `elementwise`."""
    return getattr(method, "is_elementwise", False)


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


EVERYWHERE = slice(None), slice(None)
"""The window of a patch on the whole map."""


class Patch(NamedTuple):
    """The levels of an obstacle in a window of the map, and the mask of the cells that it covers."""

    window: tuple[slice, slice]
    levels: Levels
    footprint: Mask


@dataclass(frozen=True, kw_only=True, slots=True)
class Obstacle(ABC):
    """An obstacle at its place in a map: one row of a recipe's list.

    `key` names its random stream: while it stays, so does the draw. Without one the recipe derives a key from the row
    itself, so that adding, moving or removing other rows leaves this one as it was.

    An obstacle that is not `enabled` stays in the list and is left out of the maps. Its own values are checked as those
    of any other, but not whether it fits into the map, so that one that does not can be switched off.
    """

    kind: ClassVar[str]
    also: ClassVar[tuple[str, ...]] = ()
    default_place: ClassVar[str] = "at a random position"
    """Position, in words, of an obstacle without one in its recipe."""

    levels: Annotated[
        int,
        Integer(
            2,
            MOST_LEVELS,
            usual=(2, 20),
            help="number of levels: 5 levels of 10 cm are the heights 0, 10, 20, 30, 40 cm above the ground",
        ),
    ]
    softness: Annotated[
        float,
        Float(
            0,
            100,
            unit="%",
            help="width of the slopes, 0: vertical walls; for random kinds: how much every height is "
            "reduced, so that five levels are flat from 80 % on",
        ),
    ] = 0.0
    first: Annotated[Place | None, CellRef(help="one end or corner, x and y in block cells of the map")] = None
    last: Annotated[Place | None, CellRef(help="the other end or corner")] = None
    blend: Annotated[
        str, Choice(("replace", "max", "add", "min"), help="how it is combined with earlier obstacles")
    ] = "replace"
    key: Annotated[
        str | None,
        Text(
            r"[A-Za-z0-9_.\-]{1,64}",
            "1..64 letters, digits, _ . -",
            help="name of its random stream: the same key gives the same draw",
        ),
    ] = None
    enabled: Annotated[bool, Flag(help="whether it is in the maps; if not, it stays in the list")] = True

    def __post_init__(self) -> None:
        validate(self)

    def entry(self) -> dict[str, Json]:
        """Return the row as a recipe file has it: the kind, then the parameters that differ from their defaults."""
        values = changed(self)
        return {"kind": self.kind} | {name: values[name] for name in row_parameters(type(self)) if name in values}

    def check_size(self, grid: Grid) -> None:  # noqa: B027  # most kinds fit
        """Raise a ParameterError if the obstacle does not fit into a map of this size."""

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Return the ends of an obstacle for which the recipe gives none: random."""
        return ANYWHERE, ANYWHERE

    def wanted_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Return `first` and `last`, or the default end in place of one that the recipe does not give."""
        first, last = self.default_ends(grid)
        return self.first or first, self.last or last

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return the cells of the two ends; random coordinates are uniform over the map."""
        (x1, y1), (x2, y2), n_x, n_y = first, last, grid.n_x, grid.n_y
        x1 = randint(rng, 0, n_x - 1) if x1 == "random" else x1
        y1 = randint(rng, 0, n_y - 1) if y1 == "random" else y1
        x2 = randint(rng, 0, n_x - 1) if x2 == "random" else x2
        y2 = randint(rng, 0, n_y - 1) if y2 == "random" else y2
        return (x1, y1), (x2, y2)

    @property
    def level_range(self) -> tuple[int, int]:
        """The lowest and the highest level that a block may have, counted from the ground: below 0 in pits."""
        return 0, self.levels - 1

    @property
    def draws_nothing(self) -> bool:
        """Return whether the levels follow from the two ends alone, so that maps with the same ends are alike."""
        return False

    @property
    def draws_by_cell(self) -> bool:
        """Return whether the levels are `drawn` from one random number per cell of the rectangle between the ends."""
        return False

    @property
    def draws_alike(self) -> bool:
        """Return whether a `Filling` makes the levels of many maps together, by `spanning`."""
        return False

    @abstractmethod
    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the levels of the obstacle, from the ground, between these two cells, which `ends` gave."""

    def patches(self, grid: Grid, ends: Ints) -> Patch:
        """Return the levels between many pairs of ends (pairs, 2, 2), on the whole map, if they draw nothing."""
        levels = np.zeros((len(ends), *grid.shape), dtype=np.int16)
        footprint = np.zeros(levels.shape, dtype=bool)
        for pair, (first, last) in enumerate(ends.tolist()):
            patch = self.patch(grid, tuple(first), tuple(last), _NO_DRAW)
            levels[(pair, *patch.window)], footprint[(pair, *patch.window)] = patch.levels, patch.footprint
        return Patch(EVERYWHERE, levels, footprint)


_NO_DRAW = np.random.Generator(np.random.PCG64(0))
"""Generator for a `patch` that draws nothing."""


PLACING: Mapping[str, Parameter] = MappingProxyType(
    {name: parameters(Obstacle)[name] for name in ("first", "last", "blend", "key", "enabled")}
)
"""Parameters that place an obstacle, the same for all kinds; all the others are a kind's own."""


@cache
def own_parameters(cls: type[Obstacle]) -> Mapping[str, Parameter]:
    """Return the parameters of a kind without those that place an obstacle."""
    return MappingProxyType({name: sort for name, sort in parameters(cls).items() if name not in PLACING})


@cache
def row_parameters(cls: type[Obstacle]) -> Mapping[str, Parameter]:
    """Return all parameters of a kind in the order of files, lists and the manual: its own, then the placing ones."""
    return MappingProxyType({**own_parameters(cls), **PLACING})


class Shaped(Obstacle):
    """An obstacle with a profile in [0, 1], such as a barrier or peak; it covers the cells of level 1 or more.

    An elementwise `profile` is given the ends of many maps as floats of shape (maps, 1, 1).
    """

    __slots__ = ()

    @property
    def draws_nothing(self) -> bool:
        """Return whether `patch` is still the one of this class: a profile has no random numbers."""
        return type(self).patch is Shaped.patch

    @abstractmethod
    def overhang(self, grid: Grid) -> float:
        """Return how far the obstacle may extend beyond the rectangle of its ends, in cells."""

    @abstractmethod
    def profile(self, x: Array, y: Array, first: Cell, last: Cell, grid: Grid) -> Array:
        """Return the profile f in [0, 1] at the cell centres x of shape (n, 1) and y of shape (1, m)."""

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the levels floor((n - 1) f): the highest on the axis or apex alone, lower in steps on the sides."""
        window = _window(grid, first, last, margin_of(self, grid))
        x, y = np.ogrid[window]

        def part(rows: slice) -> Levels:
            along_x = np.arange(rows.start, rows.stop, dtype=float)[:, None]
            with np.errstate(over="ignore"):  # a slope of almost no width
                f = self.profile(along_x, y.astype(float), first, last, grid)
            return levels_of(self, f, (rows.stop - rows.start, y.size))

        levels = _by_rows(window, part)
        return Patch(window, levels, self.covers(levels, x, y, first, last))

    @elementwise
    def covers(self, levels: Levels, x: Ints, y: Ints, first: Cell, last: Cell) -> Mask:
        """Return the mask of the cells that the obstacle covers: cells of level 1 or more."""
        return levels >= 1

    def patches(self, grid: Grid, ends: Ints) -> Patch:
        """Return the levels between many pairs of ends (pairs, 2, 2), on the whole map, by one profile of them all."""
        if not (is_elementwise(self.profile) and is_elementwise(self.covers) and type(self).patch is Shaped.patch):
            return Obstacle.patches(self, grid, ends)
        x, y = (at.astype(float) for at in np.ogrid[: grid.n_x, : grid.n_y])
        columns = np.moveaxis(ends.astype(float), 0, -1)[..., None, None]
        first, last = ((at[0], at[1]) for at in columns)  # arrays in place of numbers
        with np.errstate(over="ignore"):  # a slope of almost no width
            f = self.profile(x, y, first, last, grid)
        levels = levels_of(self, f, (len(ends), *grid.shape))
        footprint = self.covers(levels, x, y, first, last)
        margin = margin_of(self, grid)
        for at, a, b in zip((x, y), first, last, strict=True):
            footprint = footprint & (at >= np.minimum(a, b) - margin) & (at <= np.maximum(a, b) + margin)
        return Patch(EVERYWHERE, levels, footprint)


class Sloped(Shaped):
    """A shape with slopes of w = (softness / 100) * L cells on all sides, with the chunk size L."""

    __slots__ = ()

    def overhang(self, grid: Grid) -> float:
        """Return w + 1/2 cells, beyond which the profile is 0."""
        return self.softness / 100 * grid.chunk_size + 0.5

    def sloped(self, away: Array, grid: Grid) -> Array:
        """Return 1 up to half a cell away from the shape, 1 - (d - 1/2) / w beyond; vertical walls if w = 0."""
        beyond, w = away - 0.5, self.softness / 100 * grid.chunk_size
        slope = np.maximum(0.0, 1 - beyond / w) if w else 0.0
        return np.asarray(np.where(beyond <= 0, 1.0, slope))


class Filling(Obstacle):
    """A kind that fills the rectangle first..last, by default the whole map."""

    __slots__ = ()
    default_place: ClassVar[str] = "on the whole map"

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Return two opposite corners of the map."""
        return (0, 0), (grid.n_x - 1, grid.n_y - 1)

    @staticmethod
    def window(grid: Grid, first: Cell, last: Cell) -> tuple[slice, slice]:
        """Return the rectangle between two cells."""
        return _window(grid, first, last, 0)

    def spanning(self, grid: Grid, span: Cell, streams: Streams) -> tuple[Levels, Mask]:
        """Return the levels of many maps, (maps, n_x, n_y) or (n_x, n_y), and the covered cells, of a kind that
        `draws_alike`.

        They are between two ends that are so far apart, made of the next numbers of the streams.
        """
        raise NotImplementedError

    def patches_drawn(self, grid: Grid, ends: Ints, streams: Streams) -> Patch:
        """Return the levels of many maps between their ends (maps, 2, 2), on the whole map, by their streams."""
        levels = np.zeros((len(ends), *grid.shape), dtype=np.int16)
        footprint, spans, lowest = np.zeros(levels.shape, dtype=bool), ends[:, 1] - ends[:, 0], ends.min(axis=1)
        for span in np.unique(spans, axis=0):
            maps = np.flatnonzero((spans == span).all(axis=1))
            own, covered = self.spanning(grid, tuple(span.tolist()), streams.part(maps))
            x, y = (lowest[maps, axis, None] + np.arange(covered.shape[axis]) for axis in (0, 1))
            place = maps[:, None, None], x[:, :, None], y[:, None, :]
            levels[place], footprint[place] = own, covered
        return Patch(EVERYWHERE, levels, footprint)


class Region(Filling):
    """A random kind: it samples every cell of its rectangle."""

    __slots__ = ()

    @property
    def draws_by_cell(self) -> bool:
        """Return whether `patch` is still the one of this class."""
        return type(self).patch is Region.patch

    @abstractmethod
    def drawn(self, uniform: Array) -> Levels:
        """Return levels from random numbers in [0, 1), one level per number."""

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the level of each cell, made from a random number of its own."""
        window = self.window(grid, first, last)
        width = window[1].stop - window[1].start
        levels = _by_rows(window, lambda rows: self.levels_of(rng.random((rows.stop - rows.start, width))))
        return Patch(window, levels, np.ones(levels.shape, dtype=bool))

    @property
    def draws_per_cell(self) -> int:
        """Return how many numbers are drawn for each cell, one for all cells after the other; the last one counts."""
        return 1

    def levels_in_maps(self, uniform: Array) -> Levels:
        """Return the levels of many maps from the random numbers of their cells, (maps, n, m)."""
        return self.levels_of(uniform.reshape(-1, uniform.shape[-1])).reshape(uniform.shape)

    def levels_of(self, uniform: Array) -> Levels:
        """Return `drawn(uniform)`; PluginError if that is not one level per number."""
        levels = self.drawn(uniform)
        if np.shape(levels) != uniform.shape:
            raise PluginError(f"obstacle kind {self.kind}: drawn() must return an array of shape {uniform.shape}")
        if isinstance(levels, np.ndarray) and levels.dtype.kind not in "iu":
            raise PluginError(f"obstacle kind {self.kind}: drawn() gives levels of {levels.dtype}; expected integers")
        return levels


class Layout(Filling):
    """A kind that is laid out block by block in its rectangle, from `first` on.

    Its number of levels is its whole height or depth: 5 levels are up to 4 units above the ground, or below it.
    """

    __slots__ = ()

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends; random ones make a square inside the map, with a random side of L/2..L if no side is given."""
        return square_ends(grid.shape, grid.chunk_size, first, last, rng)

    @property
    def draws_nothing(self) -> bool:
        """Return whether a layout has no random numbers, as most, and `patch` is still the one of this class."""
        return self.draws_alike and type(self).draws is Layout.draws

    @property
    def draws_alike(self) -> bool:
        """Return whether `patch` is still the one of this class, so that layouts of many maps are made together."""
        return type(self).patch is Layout.patch

    def draws(self, shape: Cell) -> Cell:
        """Return the shape of the random numbers for a rectangle of this shape; they follow the numbers of the ends."""
        return 0, 0

    @abstractmethod
    def laid_out(self, shape: Cell, drawn: Array) -> tuple[Levels, Mask]:
        """Return the levels from the ground (..., n_x, n_y), and the covered cells (n_x, n_y), of a rectangle.

        drawn: random numbers, (..., *draws(shape)), of one rectangle or of many.
        """

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return the layout, mirrored along an axis on which last is below first; softness lowers it towards 0."""
        span = last[0] - first[0], last[1] - first[1]
        levels, covered = self._spanning(span, rng.random)
        return Patch(self.window(grid, first, last), levels, covered)

    def spanning(self, grid: Grid, span: Cell, streams: Streams) -> tuple[Levels, Mask]:
        """Return the layouts of many maps (maps, n_x, n_y) between two ends that are so far apart."""
        return self._spanning(span, streams.arrays)

    def _spanning(self, span: Cell, random: Callable[[Cell], Array]) -> tuple[Levels, Mask]:
        """Return the layout between two ends that are so far apart, (..., n_x, n_y), and the covered cells."""
        shape = abs(span[0]) + 1, abs(span[1]) + 1
        levels, covered = self.laid_out(shape, random(self.draws(shape)))
        refuse_other_layout(self, levels, covered, shape)
        lower = np.floor(np.abs(levels) * (1 - self.softness / 100) + SLACK)
        x, y = (slice(None, None, 1 if along >= 0 else -1) for along in span)
        return (np.sign(levels) * lower).astype(np.int16)[..., x, y], covered[x, y]


class UpOrDown(Layout):
    """A layout that rises out of the ground, or sinks into it, by a parameter `direction` of its kind.

    It is a parameter of the kind, and not of this class, as parameters keep the order in which a kind declares them.
    """

    __slots__ = ()
    direction: str

    @property
    def level_range(self) -> tuple[int, int]:
        """The lowest and the highest level, counted from the ground: of one that goes both ways, below it and above."""
        return 0 if self.direction == "up" else 1 - self.levels, 0 if self.direction == "down" else self.levels - 1


def to_rim(shape: Cell) -> Ints:
    """Return how many cells lie between each cell of a rectangle and its rim, (n_x, n_y): 0 on the outermost ring."""
    i, j = (np.minimum(np.arange(n), np.arange(n)[::-1]) for n in shape)
    return np.minimum(i[:, None], j)


def inward(way: str, shape: Cell) -> Ints:
    """Return how many cells lie before each cell of a rectangle on a way into it, (n_x, n_y).

    way: "x" or "y", along that axis from its first cell; any other word: from the rim to the middle.
    """
    return np.indices(shape)["xy".index(way)] if way in ("x", "y") else to_rim(shape)


def _window(grid: Grid, first: Cell, last: Cell, margin: int) -> tuple[slice, slice]:
    """Return the rectangle of both cells, wider by `margin` on every side, clipped to the map."""
    parts = [
        slice(max(0, min(a, b) - margin), min(n, max(a, b) + margin + 1))
        for a, b, n in zip(first, last, grid.shape, strict=True)
    ]
    return parts[0], parts[1]


_CELLS_AT_ONCE = 2**18
"""Cells that are computed together: each array of floats over them takes 2 MB, however large the map is."""


def _by_rows(window: tuple[slice, slice], part: Callable[[slice], Levels]) -> Levels:
    """Return the levels of a window, computed in batches of rows; `part` is called in ascending order."""
    rows, columns = window
    step = max(_CELLS_AT_ONCE // (columns.stop - columns.start), 1)
    if rows.stop - rows.start <= step:
        return part(rows)
    return np.concatenate([part(slice(low, min(low + step, rows.stop))) for low in range(rows.start, rows.stop, step)])


RESERVED = frozenset({"kind", *PLACING})
"""Keys that every row of a recipe may have, so no kind declares a parameter of such a name."""


KINDS: Registry[type[Obstacle]] = Registry(
    "obstacle kind",
    package="rsegen.obstacles",
    group="rsegen.obstacles",
    contract=Contract(
        base=Obstacle, names=lambda cls: (cls.kind,), check=lambda cls: name_conflict(cls, RESERVED, Obstacle)
    ),
)
"""Every obstacle class by the name of its kind."""


register = KINDS.register
"""Decorator of an obstacle class, which is known by the name of its kind then."""
