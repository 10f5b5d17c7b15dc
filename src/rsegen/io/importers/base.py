"""What an importer is: options with their bounds, and how a file becomes levels.

A format is one file of this folder with one class: a frozen dataclass whose annotated fields are its options, under
`@register`. Nothing else needs to know of it. Files come from strangers: nothing in them is trusted.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from rsegen.errors import FileError
from rsegen.exporters.formats.base import FORMATS as WRITTEN
from rsegen.exporters.formats.base import RESERVED
from rsegen.field.stepfield import Array, Ints, Mask
from rsegen.io.importers.rounding import Rounding, advice, are_not_blocks
from rsegen.io.resources import refuse_many_heights
from rsegen.params.contract import Contract, clash
from rsegen.params.registry import Registry
from rsegen.params.sorts import parameters, validate

MOST_CELLS = 2**24
"""Cells of a file at most: 4096 x 4096."""

USUAL_UNIT_CM = 10.0
"""The unit of heights if neither the file nor the user gives one."""

_HIGHEST = 32766


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Heights:
    """The content of a file: levels of shape (n_x, n_y), their unit [cm], and values of the recipe that it has.

    errors_cm, holes: (n_x, n_y), by how much each height is above its level, and which cells were filled, if known.
    """

    levels: Ints
    unit_cm: float
    recipe_values: Mapping[str, Any] = field(default_factory=dict)
    errors_cm: Array | None = None
    holes: Mask | None = None

    @property
    def rounding(self) -> Rounding | None:
        """How far the heights were rounded, if that is known."""
        return None if self.errors_cm is None or self.holes is None else Rounding.of(self.errors_cm, self.holes)


@dataclass(frozen=True, kw_only=True, slots=True)
class Importer(ABC):
    """Reads heights from one sort of file, with its options."""

    name: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        validate(self)

    @abstractmethod
    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """The heights in a file, in units of `unit_cm` if that is given; a FileError if it has none."""


def refuse_too_many_cells(path: Path, n_x: int, n_y: int) -> None:
    """Raise a FileError if a file has too many cells, or none; called before they are read."""
    if not 0 < n_x * n_y <= MOST_CELLS:
        raise FileError(f"{path}: {n_x} x {n_y} cells; from 1 up to {MOST_CELLS:,} can be read")
    refuse_many_heights(str(path), n_x, n_y)


def whole_units(
    path: Path,
    heights_cm: Array,
    unit_cm: float,
    *,
    rounded: bool,
    any_heights: bool = True,
    holes: Mask | None = None,
) -> Ints:
    """Heights [cm], shape (n_x, n_y), as levels; a FileError for the first that is no whole unit, unless `rounded`.

    any_heights: else heights that are no measured blocks of that unit are refused; holes: cells that do not tell.
    """
    units = heights_cm / unit_cm
    levels = np.floor(units + 0.5)
    bad = ~np.isfinite(units) | (levels < 0) | (levels > _HIGHEST)
    if not rounded:
        with np.errstate(invalid="ignore"):
            bad |= np.abs(units - levels) > 1e-3
    if bad.any():
        column, row = (int(at) for at in np.argwhere(bad[:, ::-1])[0])
        height = heights_cm[:, ::-1][column, row]
        amiss = (
            "nan cm is a hole"
            if np.isnan(height)
            else f"{height:g} cm is not 0..{_HIGHEST} whole units of {unit_cm:g} cm"
        )
        said = "fill_holes gives it the height of its neighbours" if np.isnan(height) else advice(heights_cm, unit_cm)
        raise FileError(
            f"{path}: row {row + 1} from the top, column {column + 1}: {amiss}{_others(int(bad.sum()) - 1)}; {said}"
        )
    told = np.ones(levels.shape, dtype=bool) if holes is None else ~holes
    if rounded and not any_heights and are_not_blocks(units[told], levels[told]):
        heights = heights_cm[told]
        raise FileError(
            f"{path}: heights of {heights.min():.4g} to {heights.max():.4g} cm are not blocks of {unit_cm:g} cm: "
            f"{advice(heights, unit_cm)}; "
            "any_heights rounds them anyway"
        )
    return levels.astype(np.int32)


def _others(count: int) -> str:
    return f" ({count} more such cell{'s'[: count > 1]})" if count else ""


def _problem(cls: type[Importer]) -> str:
    """What is wrong with the suffixes and the options of a plug-in's importer."""
    for suffix in cls.suffixes:
        if not (suffix.startswith(".") and suffix.islower()):
            return f"reads files named *{suffix}; give a suffix such as .asc, in small letters"
    reserved = RESERVED.union(*(parameters(other) for other in WRITTEN.values()))
    return clash(cls, reserved) or ("" if cls() else "cannot be made without options")


IMPORTERS: Registry[type[Importer]] = Registry(
    "format of heights",
    package="rsegen.io.importers",
    group="rsegen.importers",
    contract=Contract(base=Importer, names=lambda cls: tuple(cls.suffixes), check=_problem),
)
"""Every importer by the suffixes of its files."""

_Importer = TypeVar("_Importer", bound=type[Importer])


def register(cls: _Importer) -> _Importer:
    """Register an importer under the suffixes of its files."""
    for suffix in cls.suffixes:
        IMPORTERS.add(suffix, cls)
    return cls
