"""The blocks that a lab owns, in a file."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from rsegen.errors import FileError, ParameterError, shown
from rsegen.input_files import text_of
from rsegen.params.sorts import CENTIMETRES, MOST_LEVELS, Float, Integer

COLUMNS = ["height_cm", "count"]
_IN_INCHES = ["height_in", "count"]
_MAX_INVENTORY_MIB = 1


def inventory_in(path: Path, unit_cm: float) -> tuple[int, ...]:
    """Return the number of blocks of level 1, 2, ... in a CSV file of heights and counts; a height may stand twice.

    Heights are in cm, or in inches if their column is height_in. Cells are separated by commas or semicolons; with
    semicolons a comma is a decimal point. Empty lines, and those that begin with `#`, are comments.
    """
    counts: Counter[int] = Counter()
    (_, head), *rows = _rows(path)
    for line, row in rows:
        level, count = _row(f"{path}: line {line}", row, unit_cm, "in" if head == _IN_INCHES else "cm")
        counts[level] += count
    return tuple(counts[level] for level in range(1, max(counts, default=0) + 1)) or (0,)


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the header and the rows below it, each with its line."""
    lines = text_of(path, _MAX_INVENTORY_MIB, "an inventory").splitlines()
    lines = ["" if not line.strip() or line.startswith("#") else line for line in lines]  # they keep their numbers
    semicolons = ";" in next(filter(None, lines), "")
    rows = filter(None, reader := csv.reader(lines, delimiter=";" if semicolons else ","))
    try:
        head = next(rows, [])
        if head not in (COLUMNS, _IN_INCHES):
            raise FileError(
                f"{path}: does not begin with the line {','.join(COLUMNS)}; use levels in numbers, or such a file"
            )
        yield reader.line_num, head
        for row in rows:
            yield reader.line_num, [cell.replace(",", ".") for cell in row] if semicolons else row
    except csv.Error as error:
        raise FileError(f"{path}: line {reader.line_num}: {error}") from None


def _row(where: str, row: list[str], unit_cm: float, written: str) -> tuple[int, int]:
    """Return the level of the blocks in a row, and how many of them there are."""
    if len(row) != len(COLUMNS):
        raise FileError(f"{where}: {shown(','.join(row))} is not a height and a count")
    height = Float(0, 100_000, unit=written).check(where, Float().parse(row[0]))
    count = Integer(0, 10**9).check(where, Integer(0).parse(row[1].strip()))
    level = round(height * CENTIMETRES[written] / unit_cm)
    if abs(level * unit_cm - height * CENTIMETRES[written]) > 1e-6 or not 1 <= level <= MOST_LEVELS:
        raise ParameterError(where, f"a block of {height:g} {written} is not a whole number of units of {unit_cm:g} cm")
    return level, count
