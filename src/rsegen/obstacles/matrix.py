"""The matrix: given levels, from a measured pallet, an image or cells painted by hand.

Stretched over a rectangle of n cells, it takes for each cell centre (2 k + 1) / (2 n) the one of its own m cells that
lies under it, in integers: (2 k + 1) m // (2 n). So stretching rounds nothing, and a matrix of the size of its
rectangle is copied. The cost is checking and reading the rows, a tenth of a second per million cells.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.field.stepfield import Ints
from rsegen.obstacles.base import Grid, Obstacle, Patch, elementwise, register
from rsegen.obstacles.ends import ends_of_size
from rsegen.obstacles.given import SLACK
from rsegen.params.sorts import ANYWHERE, MOST_LEVELS, Cell, Json, Place, as_int, parameters, refuse_longer

_ROW = r"([0-9]{1,5}|\.)( ([0-9]{1,5}|\.))*"
"""A row in its canonical form. Five digits hold every level; a larger number is refused by the bounds of `levels`."""

_SCHEMA_ROW = r"^[0-9. ,]*[0-9.][0-9. ,]*$"
"""A row as a file may have it, for editors."""

_MOST_ROWS = 1_000_000
"""Longest list of rows: a longer one in a file is refused before it is looked at."""


@dataclass(frozen=True)
class Rows:
    """Levels in rows of text, as in `["0 1 2", ". 1 ."]`: the top row is the largest y, a dot leaves its cell alone."""

    help: str = ""

    def check(self, where: str, value: object) -> tuple[str, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise ParameterError(where, f"{shown(value)} is not a list of rows; expected {self.describe()}")
        refuse_longer(where, value, _MOST_ROWS)
        rows = tuple(self._row(f"{where}[{index}]", row) for index, row in enumerate(value))
        lengths = [row.count(" ") + 1 for row in rows]
        for index, length in enumerate(lengths):
            if length != lengths[0]:
                raise ParameterError(f"{where}[{index}]", f"has {length} cells, and {where}[0] {lengths[0]}")
        return rows

    def _row(self, where: str, value: object) -> str:
        row = value.replace(",", " ") if isinstance(value, str) else _joined(value)
        row = " ".join(row.split())
        if not re.fullmatch(_ROW, row):
            raise ParameterError(where, f"{shown(value)} is not a row of levels and dots, as in '0 1 . 2'")
        return row

    def parse(self, text: str) -> object:
        return text.split("/")

    def format(self, value: Any) -> str:
        return "/".join(row.replace(" ", ",") for row in value)

    def schema(self) -> dict[str, Json]:
        cells = {"type": "array", "items": {"type": ["integer", "null"], "minimum": 0}, "minItems": 1}
        return {"type": "array", "items": {"anyOf": [{"type": "string", "pattern": _SCHEMA_ROW}, cells]}, "minItems": 1}

    def describe(self) -> str:
        return 'rows of levels, as in ["0 1 2", ". 1 ."]'


def _joined(row: object) -> str:
    """Return a list of integers as text, in which None becomes a dot; the empty string for anything else."""
    cells = row if isinstance(row, (list, tuple)) else ()
    return " ".join("." if cell is None else str(as_int(cell)) for cell in cells)


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Matrix(Obstacle):
    """Given levels, one per cell, or stretched over the rectangle first..last; softness scales them down."""

    kind: ClassVar[str] = "matrix"
    also: ClassVar[tuple[str, ...]] = ("custom", "table", "grid", "array")
    default_place: ClassVar[str] = "in its own size, from cell (0, 0)"

    levels: Annotated[
        int,
        replace(parameters(Obstacle)["levels"], help="number of levels; default: one more than the highest in rows"),
    ] = None  # type: ignore[assignment]  # an int from __post_init__ on
    rows: Annotated[
        Sequence[str],
        Rows(help="levels of its cells, north up (the top row has the largest y); a dot leaves a cell unchanged"),
    ] = ("1",)

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        highest = int(self.cell_levels().max())
        if not self.levels:  # none was given
            object.__setattr__(self, "levels", min(max(highest + 1, 2), MOST_LEVELS))
        if highest >= self.levels:
            raise ParameterError(
                "levels", f"{self.levels} has the levels 0..{self.levels - 1}, and rows has a {highest}"
            )

    @classmethod
    def of(cls, levels: Ints, *, key: str | None = None) -> Matrix:
        """Return the matrix with levels of shape (n_x, n_y); a negative level leaves its cell unchanged."""
        rows = (" ".join("." if level < 0 else str(level) for level in row) for row in levels.T[::-1].tolist())
        return cls(rows=tuple(rows), key=key)

    @property
    def size(self) -> Cell:
        """Number of cells along x and y."""
        return self.rows[0].count(" ") + 1, len(self.rows)

    def cell_levels(self) -> Ints:
        """Return the level of each cell, shape (n_x, n_y); -1 for a cell that is left unchanged."""
        text = " ".join(self.rows).replace(".", "-1")
        n_x, n_y = self.size
        return np.fromstring(text, dtype=np.int32, sep=" ").reshape(n_y, n_x)[::-1].T

    def check_size(self, grid: Grid) -> None:
        """Raise a ParameterError if the matrix in its own size ends outside the map."""
        for axis, (own, cells, start, stop) in enumerate(
            zip(self.size, grid.shape, *self.wanted_ends(grid), strict=True)
        ):
            low = 0 if start == "random" else start
            if stop == "random" and low + own > cells:
                raise ParameterError(
                    "rows", f"{own} cells along {'xy'[axis]} from {low} on do not fit into 0..{cells - 1}; set last"
                )

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """Return cell (0, 0) and no given end: the matrix has its own size."""
        return (0, 0), ANYWHERE

    @elementwise
    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Return ends; random ones make a rectangle of the size of the matrix inside the map."""
        return ends_of_size(grid.shape, first, last, self.size, rng)

    @property
    def draws_nothing(self) -> bool:
        """Return whether `patch` is still the one of this class."""
        return type(self).patch is Matrix.patch

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """Return for each cell of the rectangle the level under its centre; mirrored if last is below first."""
        own = self.cell_levels()[np.ix_(*(_under(*along) for along in zip(first, last, self.size, strict=True)))]
        levels = np.floor(own * (1 - self.softness / 100) + SLACK).astype(np.int16)
        window = tuple(slice(min(ends), max(ends) + 1) for ends in zip(first, last, strict=True))
        return Patch((window[0], window[1]), np.maximum(levels, np.int16(0)), own >= 0)


def _under(first: int, last: int, own: int) -> Ints:
    """Return which of `own` matrix cells lies under the centre of each map cell, from the lower end to the higher."""
    cells = abs(last - first) + 1
    under = (2 * np.arange(cells) + 1) * own // (2 * cells)
    return under if first <= last else under[::-1]
