"""The matrix: given levels, from a measured pallet, an image or cells painted by hand."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from rsegen.errors import ParameterError, shown
from rsegen.field.obstacles.base import Grid, Obstacle, Patch, random_ends, register
from rsegen.field.stepfield import Ints
from rsegen.params.sorts import ANYWHERE, Cell, Json, Place, as_int, refuse_longer

_ROW = r"([0-9]{1,5}|\.)( ([0-9]{1,5}|\.))*"
_MOST_ROWS = 1_000_000
_SCHEMA_ROW = r"^[0-9. ,]*[0-9.][0-9. ,]*$"


@dataclass(frozen=True)
class Rows:
    """Levels in rows of text, as in `["0 1 2", ". 1 ."]`: the top row is the largest y, a dot leaves its cell alone."""

    help: str = ""

    def check(self, where: str, value: object) -> tuple[str, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise ParameterError(where, f"{shown(value)} is not a list of rows; give {self.describe()}")
        refuse_longer(where, value, _MOST_ROWS)
        rows = tuple(self._row(f"{where}[{number}]", row) for number, row in enumerate(value))
        lengths = [row.count(" ") + 1 for row in rows]
        for number, length in enumerate(lengths):
            if length != lengths[0]:
                raise ParameterError(f"{where}[{number}]", f"has {length} cells, and {where}[0] {lengths[0]}")
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
    """A list of integers as text, in which None becomes a dot; the empty string for anything else."""
    cells = row if isinstance(row, (list, tuple)) else ()
    return " ".join("." if cell is None else str(as_int(cell)) for cell in cells)


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Matrix(Obstacle):
    """Given levels, one per cell, or stretched over the rectangle first..last; softness scales them down."""

    kind: ClassVar[str] = "matrix"
    default_place: ClassVar[str] = "in its own size, from cell (0, 0)"

    rows: Annotated[
        tuple[str, ...],
        Rows(help="levels of its cells, north up (the top row has the largest y); a dot leaves a cell unchanged"),
    ] = ("1",)

    def __post_init__(self) -> None:
        Obstacle.__post_init__(self)
        highest = self.levels().max()
        if highest >= self.max_height:
            raise ParameterError(
                "max_height", f"{self.max_height} has the levels 0..{self.max_height - 1}, and rows has a {highest}"
            )

    @classmethod
    def of(cls, levels: Ints) -> Matrix:
        """The matrix with levels of shape (n_x, n_y); a negative level leaves its cell unchanged."""
        rows = (" ".join("." if level < 0 else str(level) for level in row) for row in levels.T[::-1].tolist())
        return cls(max_height=max(int(levels.max()) + 1, 2), rows=tuple(rows))

    @property
    def size(self) -> Cell:
        """The number of cells along x and y."""
        return self.rows[0].count(" ") + 1, len(self.rows)

    def levels(self) -> Ints:
        """The given levels, shape (n_x, n_y); -1 for a cell that is left unchanged."""
        text = " ".join(self.rows).replace(".", "-1")
        n_x, n_y = self.size
        return np.fromstring(text, dtype=np.int32, sep=" ").reshape(n_y, n_x)[::-1].T

    def check_size(self, grid: Grid, first: Place | None, last: Place | None) -> None:
        """Raise a ParameterError if the matrix in its own size ends outside the map."""
        for axis, (own, cells) in enumerate(zip(self.size, grid.shape, strict=True)):
            start = (first or (0, 0))[axis]
            low = 0 if start == "random" else start
            if (last or ANYWHERE)[axis] == "random" and low + own > cells:
                raise ParameterError(
                    "rows", f"{own} cells along {'xy'[axis]} from {low} on do not fit into 0..{cells - 1}; give last"
                )

    def default_ends(self, grid: Grid) -> tuple[Place, Place]:
        """The ends if a recipe gives none: its own size, from cell (0, 0)."""
        return (0, 0), ANYWHERE

    def ends(self, grid: Grid, first: Place, last: Place, rng: np.random.Generator) -> tuple[Cell, Cell]:
        """Random ends make a rectangle of its own size inside the map."""
        (x1, x2), (y1, y2) = (
            random_ends(a, b, own - 1, cells, rng)
            for a, b, own, cells in zip(first, last, self.size, grid.shape, strict=True)
        )
        return (x1, y1), (x2, y2)

    @property
    def draws_nothing(self) -> bool:
        """If no kind derived from it says otherwise."""
        return type(self).patch is Matrix.patch

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        """The level of each cell of the rectangle is the one under its centre; mirrored if last is below first."""
        own = self.levels()[np.ix_(*(_under(*along) for along in zip(first, last, self.size, strict=True)))]
        levels = np.floor(own * (1 - self.softness / 100) + 1e-9).astype(np.int16)
        window = tuple(slice(min(ends), max(ends) + 1) for ends in zip(first, last, strict=True))
        return Patch((window[0], window[1]), np.maximum(levels, np.int16(0)), own >= 0)


def _under(first: int, last: int, own: int) -> Ints:
    """Which of `own` matrix cells lies under the centre of each map cell, from the lower to the higher end."""
    cells = abs(last - first) + 1
    under = (2 * np.arange(cells) + 1) * own // (2 * cells)
    return under if first <= last else under[::-1]
