"""A format of heights."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from rsegen.errors import FileError
from rsegen.heights.base import USUAL_UNIT_CM, Heights, Importer, whole_units
from rsegen.params.sorts import Integer


@dataclass(frozen=True, kw_only=True, slots=True)
class Asc(Importer):
    """Heights from an ASCII grid (ASC) in metres."""

    name: ClassVar[str] = "ASCII grid"
    suffixes: ClassVar[tuple[str, ...]] = (".heights",)

    head: Annotated[int, Integer(0, 20, help="lines before the heights")] = 3

    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """The rows after the head."""
        try:
            metres = np.loadtxt(path, skiprows=self.head, ndmin=2)
        except (OSError, ValueError) as error:
            raise FileError(f"{path}: not an ASCII grid: {error}") from None
        unit = USUAL_UNIT_CM if unit_cm is None else unit_cm
        return Heights(levels=whole_units(path, metres[::-1].T * 100, unit, rounded=False), unit_cm=unit)
