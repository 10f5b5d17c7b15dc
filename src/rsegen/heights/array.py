"""Import arrays that numpy saved (.npy)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from rsegen.errors import FileError
from rsegen.heights.base import USUAL_UNIT_CM, Heights, refuse_too_many_cells, register
from rsegen.heights.measured import Measured
from rsegen.params.sorts import CENTIMETRES, Choice


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Saved(Measured):
    """An array of shape (n_x, n_y), as StepField.levels is: axis 0 along x, axis 1 along y, no pickles."""

    name: ClassVar[str] = "array"
    suffixes: ClassVar[tuple[str, ...]] = (".npy",)

    values: Annotated[str, Choice((*CENTIMETRES, "levels"), help="unit of the numbers; in: inches; ft: feet")] = "cm"

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights of an array, whose shape is checked before anything is read."""
        import numpy as np

        from rsegen.npy_files import mapped

        array = mapped(path)
        if array.ndim != 2 or array.dtype.kind not in "biuf":
            sort = str(array.dtype)[:60]
            raise FileError(f"{path}: {array.ndim} axes of {sort}; expected an array of numbers with two axes")
        refuse_too_many_cells(path, *array.shape)
        unit = unit_cm or USUAL_UNIT_CM
        centimetres = {**CENTIMETRES, "levels": unit}[self.values]
        return self.measured(path, np.asarray(array, dtype=np.float64) * centimetres, unit)
