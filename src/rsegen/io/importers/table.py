"""Imports tables of heights: typed by hand, exported by a spreadsheet, or written by rsegen."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import FileError, ParameterError, shown
from rsegen.field.stepfield import Array
from rsegen.io.importers import build_sheet
from rsegen.io.importers.base import USUAL_UNIT_CM, Heights, Importer, refuse_too_many_cells, register, whole_units
from rsegen.io.text_files import text_of
from rsegen.params.sorts import Choice, Flag

_MOST_MIB = 128
_OURS = re.compile(r"# block levels in units of ([0-9.]{1,12}) cm")


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Table(Importer):
    """A row of numbers a line, the top row the largest y, apart by commas, semicolons, tabs or blanks; # comments."""

    name: ClassVar[str] = "table"
    suffixes: ClassVar[tuple[str, ...]] = (".csv", ".tsv", ".txt")

    values: Annotated[
        str, Choice(("auto", "cm", "m", "levels"), help="what its numbers are; auto: as rsegen wrote them, else cm")
    ] = "auto"
    rounded: Annotated[bool, Flag(help="round heights that are no whole units, which are refused otherwise")] = False

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Blank and invalid cells are refused with their place. A build sheet has all its parameters in itself."""
        text = text_of(path, _MOST_MIB, "a table of heights")
        if build_sheet.is_build_sheet(text):
            return self._read_list(path, text, unit_cm)
        ours = _OURS.match(text)
        values = ("levels" if ours else "cm") if self.values == "auto" else self.values
        unit = unit_cm or (float(ours[1]) if ours else USUAL_UNIT_CM)
        heights = _numbers(path, text) * centimetres(values, unit)
        return Heights(levels=whole_units(path, heights, unit, rounded=self.rounded), unit_cm=unit)

    def _read_list(self, path: Path, text: str, unit_cm: float | None) -> Heights:
        if self.values not in ("auto", "cm"):
            raise ParameterError("values", f"{path} is a build sheet, whose heights are in cm; give no {self.values}")
        recipe_values = build_sheet.recipe_values(path, text)
        unit = unit_cm or recipe_values.get("unit_cm", USUAL_UNIT_CM)
        levels = whole_units(path, build_sheet.heights_cm(path, text), unit, rounded=self.rounded)
        return Heights(levels=levels, unit_cm=unit, recipe_values=recipe_values)


def centimetres(values: str, unit_cm: float) -> float:
    """Centimetres of one unit of a file's numbers."""
    return {"cm": 1.0, "m": 100.0, "levels": unit_cm}[values]


def _numbers(path: Path, text: str) -> Array:
    """The cells of all lines, shape (n_x, n_y)."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, _cells(line)) for number, line in lines if line and line[0] != "#"]
    for number, cells in rows:
        if len(cells) != len(rows[0][1]):
            first = f"{len(rows[0][1])} in line {rows[0][0]}"
            raise FileError(f"{path}: line {number}: {len(cells)} cells, and {first}")
    refuse_too_many_cells(path, len(rows[0][1]) if rows else 0, len(rows))
    try:
        numbers = np.array([cells for _, cells in rows], dtype=np.float64)
    except ValueError:
        raise FileError(f"{path}: {_first_bad(rows)}") from None
    return numbers[::-1].T


def _cells(line: str) -> list[str]:
    """A line's cells; if semicolons separate them, a comma is a decimal point."""
    if ";" in line:
        return [cell.strip().replace(",", ".") for cell in line.split(";")]
    delimiter = next((delimiter for delimiter in ",\t" if delimiter in line), None)
    return [cell.strip() for cell in line.split(delimiter)]


def _first_bad(rows: list[tuple[int, list[str]]]) -> str:
    """The first cell that is no number, and how many others there are."""
    bad = [(line, column, cell) for line, cells in rows for column, cell in enumerate(cells, 1) if not _number(cell)]
    line, column, cell = bad[0]
    amiss = f"{shown(cell)} is not a number" if cell else "is blank"
    others = f" ({len(bad) - 1} more such cell{'s'[: len(bad) > 2]})" if len(bad) > 1 else ""
    return f"line {line}, column {column}: {amiss}{others}"


def _number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
