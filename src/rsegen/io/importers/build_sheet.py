"""Reads build sheets (CSV, one row per cell), as rsegen wrote them or as a spreadsheet saved them again."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from rsegen.errors import FileError, ParameterError, shown
from rsegen.exporters.sheet.listing import COLUMNS, RECIPE_KEYS
from rsegen.field.stepfield import Array
from rsegen.io.importers.rounding import CENTIMETRES
from rsegen.params.places import Cell
from rsegen.params.sorts import parameters
from rsegen.recipe.recipe import Recipe

_HEAD = re.compile(
    r"^" + r"([,;\t])".join(f'"?{name}"?' for name in COLUMNS).replace("_cm", "_(?P<unit>cm|in)") + r"[,;\t]*\r?$",
    re.MULTILINE,
)
_SAID = re.compile(rf'^"?# *({"|".join(RECIPE_KEYS)}): *([^\s,;"]{{1,40}})', re.MULTILINE)
_MOST_ROWS = 1_000_000


def is_build_sheet(text: str) -> bool:
    """Whether a text has the header of a build sheet."""
    return bool(_HEAD.search(text))


def recipe_values(path: Path, text: str) -> dict[str, Any]:
    """The values of a recipe in its comments; a FileError for an invalid one."""
    sorts = parameters(Recipe)
    try:
        return {name: sorts[name].check(name, sorts[name].parse(value)) for name, value in _SAID.findall(text)}
    except ParameterError as error:
        raise FileError(f"{path}: {error}") from None


def heights_cm(path: Path, text: str) -> Array:
    """Heights [cm] of shape (n_x, n_y); a FileError if a cell is missing, duplicate, or no number."""
    cells: dict[Cell, float] = {}
    for line, cell, height in _rows(path, text):
        if cell in cells:
            raise FileError(f"{path}: line {line}: duplicate cell x {cell[0]}, y {cell[1]}")
        cells[cell] = height
    if not cells:
        raise FileError(f"{path}: no cell below the header {','.join(COLUMNS)}")
    n_x, n_y = (max(cell[axis] for cell in cells) + 1 for axis in (0, 1))
    if len(cells) < n_x * n_y:
        x, y = next((x, y) for x in range(n_x) for y in range(n_y) if (x, y) not in cells)
        raise FileError(
            f"{path}: the cell x {x}, y {y} of {n_x} x {n_y} is missing; a cell without a block has height 0"
        )
    heights = np.empty((n_x, n_y))
    heights[tuple(np.array(list(cells)).T)] = list(cells.values())
    return heights * CENTIMETRES[unit_of(text)]


def unit_of(text: str) -> str:
    """The unit of the heights of a build sheet, by its header: cm or in."""
    head = _HEAD.search(text)
    return head["unit"] if head else "cm"


def _rows(path: Path, text: str) -> Iterator[tuple[int, Cell, float]]:
    """Line, cell and height of each row; comments and rows of blanks are left out."""
    head = _HEAD.search(text)
    if not head:
        return
    first = text.count("\n", 0, head.end()) + 2
    body = text[head.end() :]
    rows = max(body.count(end) - body.endswith(end) for end in "\n\r")
    if rows > _MOST_ROWS:
        raise FileError(f"{path}: {rows:,} rows; up to {_MOST_ROWS:,} can be read")
    lines = body.splitlines()[1:]
    for line, row in enumerate(_split_rows(path, lines, head[1]), first):
        if any(row) and not row[0].startswith("#"):
            yield line, *_cell(f"{path}: line {line}", row, head[1])


def _split_rows(path: Path, lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    try:
        for row in csv.reader(lines, delimiter=delimiter, quoting=csv.QUOTE_NONE):
            yield [cell.strip(' "') for cell in row]
    except csv.Error as error:
        raise FileError(f"{path}: {error}") from None


def _cell(where: str, row: list[str], delimiter: str) -> tuple[Cell, float]:
    """The cell and height of one row. If semicolons separate the cells, a comma is a decimal point."""
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
