"""The levels of a map's blocks as CSV, north up."""

from __future__ import annotations

from collections.abc import Iterator

from rsegen.exporters.numbers import decimal
from rsegen.field.stepfield import StepField


def csv(field: StepField) -> Iterator[bytes]:
    """The lines of the CSV file: levels in units, without frames, north up; `#` starts a comment."""
    unit = f"{decimal(field.unit * 100)} cm"
    yield f"# block levels in units of {unit}; north up: the top row is the largest y, x grows to the right\n".encode()
    for row in field.blocks.T[::-1]:
        yield (",".join(map(str, row.tolist())) + "\n").encode()
