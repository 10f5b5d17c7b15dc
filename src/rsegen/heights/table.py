"""Import tables of heights: typed by hand, exported by a spreadsheet, or written by rsegen, also as a build sheet.

A table has a row of numbers per line, the top line the largest y. A build sheet has a row per cell, with its x and y,
in any order; it is known by its header, as rsegen wrote it or as a spreadsheet saved it again: with semicolons, quotes,
decimal commas, or other line ends. A grid in Esri's ASCII format, as maps of ground are written, begins with its number
of columns. Blank cells and rows of comments are allowed; whatever else is no number is refused
with its line and column.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from rsegen.errors import FileError, ParameterError, library_message, shown
from rsegen.heights.base import (
    MOST_CELLS,
    USUAL_UNIT_CM,
    Heights,
    is_esri_grid,
    refuse_too_many_cells,
    register,
)
from rsegen.heights.coordinate_system import IN_METRES, CellSides, beside, refuse_distorted
from rsegen.heights.measured import Measured
from rsegen.input_files import text_of
from rsegen.params.sorts import CENTIMETRES, Cell, Choice, parameters
from rsegen.recipe.recipe import Recipe

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array


COLUMNS = ("pallet", "order", "x", "y", "height_cm")
"""Columns of the rows of a build sheet (`build_sheets/document.py`).

x and y count the block cells of the map; a cell without a block has no order.

In sheets in inches the last one is height_in.
"""

RECIPE_KEYS = ("chunk_size", "unit_cm", "block_width_cm", "boundary", "frame_height_cm", "units")
"""Recipe parameters in the comments, from which the map can be imported again."""

_MOST_ROWS = 1_000_000
"""Rows of a build sheet at most, one per cell: each is a value in Python, of some 200 bytes."""


@cache
def _head() -> re.Pattern[str]:
    """Return the pattern of a build sheet's header, with any of the usual separators, in cm or inches."""
    names = r"([,;\t])".join(f'"?{name}"?' for name in COLUMNS).replace("_cm", "_(?P<unit>cm|in)")
    return re.compile(rf"^{names}[,;\t]*\r?$", re.MULTILINE)


@cache
def _parameter_pattern() -> re.Pattern[str]:
    """Return the pattern of a comment of a build sheet that says a parameter of the recipe."""
    return re.compile(rf'^"?# *({"|".join(RECIPE_KEYS)}): *([^\s,;"]{{1,40}})', re.MULTILINE)


def _value(where: str, name: str, text: str) -> Any:
    """Return a value of a recipe that a file says; a FileError, which begins with `where`, for an invalid one."""
    sort = parameters(Recipe)[name]
    try:
        return sort.check(name, sort.parse(text))
    except ParameterError as error:
        raise FileError(f"{where}: {error}") from None


def _listed(path: Path, text: str, head: re.Match[str]) -> Array:
    """Return the heights of a build sheet, (n_x, n_y); a FileError if a cell is missing, duplicate, or no number."""
    import numpy as np

    cells: dict[Cell, float] = {}
    for line, cell, height in _rows(path, text, head):
        if cell in cells:
            raise FileError(f"{path}: line {line}: duplicate cell x {cell[0]}, y {cell[1]}")
        cells[cell] = height
    if not cells:
        raise FileError(f"{path}: no cell below the header {','.join(COLUMNS)}")
    n_x, n_y = (max(cell[axis] for cell in cells) + 1 for axis in (0, 1))
    # No cell is there twice, so their number tells whether one is missing.
    if len(cells) < n_x * n_y:
        x, y = next((x, y) for x in range(n_x) for y in range(n_y) if (x, y) not in cells)
        raise FileError(
            f"{path}: the cell x {x}, y {y} of {n_x} x {n_y} is missing; a cell without a block has height 0"
        )
    heights = np.empty((n_x, n_y))
    heights[tuple(np.array(list(cells)).T)] = list(cells.values())
    return heights


def _rows(path: Path, text: str, head: re.Match[str]) -> Iterator[tuple[int, Cell, float]]:
    """Yield line, cell and height of each row below the header; comments and rows of blanks are left out."""
    first = text.count("\n", 0, head.end()) + 2
    body = text[head.end() :]
    rows = max(body.count(end) - body.endswith(end) for end in "\n\r")
    if rows > _MOST_ROWS:
        raise FileError(f"{path}: {rows:,} rows; up to {_MOST_ROWS:,} can be read")
    # Quotes are stripped here: for csv, a quote that is not closed would make one cell of all rows after it.
    try:
        for line, row in enumerate(csv.reader(body.splitlines()[1:], delimiter=head[1], quoting=csv.QUOTE_NONE), first):
            cells = [cell.strip(' "') for cell in row]
            if any(cells) and not cells[0].startswith("#"):
                yield line, *_cell(f"{path}: line {line}", cells, head[1])
    except csv.Error as error:
        raise FileError(f"{path}: {error}") from None


def _cell(where: str, row: list[str], delimiter: str) -> tuple[Cell, float]:
    """Return the cell and height of one row. If semicolons separate the cells, a comma is a decimal point."""
    if len(row) < len(COLUMNS):
        raise FileError(f"{where}: {len(row)} cells, {len(COLUMNS)} in the header")
    x, y, height = row[2 : len(COLUMNS)]
    for name, text in (("x", x), ("y", y)):
        if not (text.isascii() and text.isdecimal() and len(text) < 8):
            raise FileError(f"{where}: {name} {shown(text)} is not the number of a cell, from 0 on")
    try:
        return (int(x), int(y)), float(height.replace(",", ".") if delimiter == ";" else height)
    except ValueError:
        raise FileError(f"{where}: height_cm {shown(height)} is not a number") from None


_MAX_TABLE_MIB = 128
"""The largest table that is read, MiB: 4096 x 4096 cells of seven letters."""

_OURS = re.compile(r"# block levels in units of ([0-9.]{1,12}) cm")


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Table(Measured):
    """A row of numbers per line, the top row the largest y, with commas, semicolons, tabs or blanks; # comments."""

    name: ClassVar[str] = "table"
    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".tsv", ".txt", ".asc")

    values: Annotated[
        str,
        Choice(
            ("auto", *CENTIMETRES, "levels"),
            help="unit of the numbers; auto: as in files of rsegen, else cm; in: inches; ft: feet",
        ),
    ] = "auto"

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights of a table, or of a build sheet, which has all its parameters in itself."""
        # Three kinds of files, known by their text: build sheets, Esri's grids, and plain rows of numbers.
        text = text_of(path, _MAX_TABLE_MIB, "a table of heights")
        if head := _head().search(text):
            written = head["unit"]
            if self.values not in ("auto", written):
                problem = f"{path} is a build sheet, whose heights are in {written}; do not set {self.values}"
                raise ParameterError("values", problem)
            own_values = {name: _value(str(path), name, value) for name, value in _parameter_pattern().findall(text)}
            unit = unit_cm or own_values.get("unit_cm", USUAL_UNIT_CM)
            return self.measured(path, _listed(path, text, head) * CENTIMETRES[written], unit, own_values)
        if is_esri_grid(text):
            if self.values == "auto":
                raise ParameterError("values", f"{path} is a grid that does not say its unit; set m, cm, mm, in or ft")
            unit = unit_cm or USUAL_UNIT_CM
            numbers, cells = _of_esri_grid(path, text)
            return self.measured(path, numbers * {**CENTIMETRES, "levels": unit}[self.values], unit, cells=cells)
        ours = _OURS.match(text)
        values = ("levels" if ours else "cm") if self.values == "auto" else self.values
        unit = unit_cm or (_value(f"{path}: line 1", "unit_cm", ours[1]) if ours else USUAL_UNIT_CM)
        numbers = _numbers(path, text, blanks=self.fill_holes)
        return self.measured(path, numbers * {**CENTIMETRES, "levels": unit}[values], unit)


_ESRI_LINE = re.compile(
    r"\s*(ncols|nrows|[xy]ll(?:corner|center)|cellsize|d[xy]|nodata_value)\s+(\S+)\s*", re.IGNORECASE
)
"""A line of the header of a grid in Esri's ASCII format."""


_ESRI_NO_DATA = "-9999"
"""The number that stands for no data in a grid whose header gives none, by Esri's definition."""


def _of_esri_grid(path: Path, text: str) -> tuple[Array, CellSides | None]:
    """Return the numbers of a grid, shape (n_x, n_y), nan where it has none, and the sides of its cells.

    A row may be on several lines. The unit of the sides is in NAME.prj next to it, if anywhere.
    """
    import numpy as np

    values, at = {}, 0
    while line := _ESRI_LINE.match(text, at):
        values[line[1].lower()], at = line[2], line.end()
    numbers = text[at:].split(None, MOST_CELLS)
    try:
        n_x, n_y, none = int(values["ncols"]), int(values["nrows"]), float(values.get("nodata_value", _ESRI_NO_DATA))
        refuse_too_many_cells(path, n_x, n_y)
        cells = np.array(numbers, dtype=np.float64)
    except KeyError:
        missing = next(name for name in ("ncols", "nrows") if name not in values)
        raise FileError(f"{path}: no line {missing} in the header of the grid") from None
    except ValueError as error:
        raise FileError(f"{path}: {library_message(error)}") from None
    if len(cells) != n_x * n_y:
        raise FileError(f"{path}: {len(cells):,} numbers; {n_x} x {n_y} cells have {n_x * n_y:,}")
    return np.where(cells == none, np.nan, cells).reshape(n_y, n_x)[::-1].T, _sides(path, values)


def _sides(path: Path, header: Mapping[str, str]) -> CellSides | None:
    """Return the sides of the cells of a grid, None if its header does not say them; FileError for distorted ones."""
    system = beside(path)
    numbers = {name: float(text) for name, text in header.items() if _is_number(text)}
    place = numbers.get("xllcorner", numbers.get("xllcenter", 0)), numbers.get("yllcorner", numbers.get("yllcenter", 0))
    refuse_distorted(path, system, place, IN_METRES)
    x, y = (numbers.get(name, numbers.get("cellsize", 0)) for name in ("dx", "dy"))
    return CellSides(x, y, system.metres) if min(x, y) > 0 else None


def _numbers(path: Path, text: str, *, blanks: bool) -> Array:
    """Return the cells of all lines, shape (n_x, n_y); nan for blank ones, if those are allowed."""
    import numpy as np

    lines = _lines(path, text)
    first, start = lines[0] if lines else (1, "")
    width = _count(start)
    refuse_too_many_cells(path, width, len(lines))
    # numpy reads a whole line at once; which cell is bad is looked for only if one is.
    rows, bad = [], False
    for line_number, line in lines:
        cells = [cell or "nan" for cell in _cells(line, width)] if blanks else _cells(line, width)
        if len(cells) != width:
            raise FileError(f"{path}: line {line_number}: {_count(line)} cells, and {width} in line {first}")
        try:
            rows.append(np.array(cells, dtype=np.float64))
        except ValueError:
            bad = True
    if bad:
        raise FileError(f"{path}: {_first_bad(lines, blanks=blanks)}")
    return np.array(rows)[::-1].T


def _lines(path: Path, text: str) -> list[tuple[int, str]]:
    """Return the lines with cells, each with its number."""
    if max(text.count("\n"), text.count("\r")) > MOST_CELLS:
        raise FileError(f"{path}: more lines than the {MOST_CELLS:,} cells that can be read")
    lines = ((line_number, line.strip()) for line_number, line in enumerate(text.splitlines(), 1))
    return [(line_number, line) for line_number, line in lines if line and line[0] != "#"]


def _delimiter(line: str) -> str | None:
    """Return the delimiter of the cells of a line, None for blanks."""
    return next((delimiter for delimiter in ";,\t" if delimiter in line), None)


def _count(line: str) -> int:
    """Return the number of a line's cells, which are not made."""
    delimiter = _delimiter(line)
    return line.count(delimiter) + 1 if delimiter else sum(1 for _ in re.finditer(r"\S+", line))


def _cells(line: str, most: int = MOST_CELLS) -> list[str]:
    """Return a line's cells, or one more than `most`; if semicolons separate them, a comma is a decimal point."""
    delimiter = _delimiter(line)
    if delimiter == ";":
        return [cell.strip().replace(",", ".") for cell in line.split(";", most)]
    return [cell.strip() for cell in line.split(delimiter, most)]


def _first_bad(lines: Iterable[tuple[int, str]], *, blanks: bool) -> str:
    """Return the first cell that is no number, and how many others there are."""
    cells = ((line, at, cell) for line, text in lines for at, cell in enumerate(_cells(text), 1))
    bad = (cell for cell in cells if not (_is_number(cell[2]) or (blanks and not cell[2])))
    line, column, cell = next(bad)
    others = sum(1 for _ in bad)
    amiss = f"{shown(cell)} is not a number" if cell else "is blank: fill_holes gives it the height of its neighbours"
    more = f" ({others} more such cell{'s'[: others > 1]})" if others else ""
    return f"line {line}, column {column}: {amiss}{more}"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
