"""The interface of importers of heights, and the steps from heights in centimetres to levels, and to a recipe.

An importer is one file of this folder with one class: a frozen dataclass whose annotated fields are its options, under
`@register`. Nothing else needs to know of it. Files come from strangers: nothing in them is trusted.

Heights h become levels floor(h / unit + 0.5). They have to be whole units up to decimals' rounding, or, on request,
measured blocks: then the mean error must be below 0.2 units, where random heights have 0.25, and few may be halfway.
Else the message says what the numbers may be: another ground, unit, or unit of length. What breaks it: heights of which
most are 0, whose few others may be of any unit.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rsegen.errors import FileError, ParameterError, PluginError, refuse_other, shown
from rsegen.input_files import first_inside
from rsegen.params.registry import Contract, Registry, name_conflict
from rsegen.params.sorts import CENTIMETRES, Cell, FilePath, parameters, validate
from rsegen.recipe.recipe import Recipe
from rsegen.writing.sidecars import RESERVED_FLAGS

if TYPE_CHECKING:
    from rsegen.field.stepfield import Array, Ints, Mask
    from rsegen.heights.coordinate_system import CellSides


_MEASURED = 0.2
"""Mean rounding error, in units, above which heights are not blocks of that unit; of random ones it is 0.25."""

_HALFWAY = 0.4
"""Error, in units, from which on a height is almost halfway between two levels; it is at most 0.5."""

_MOST_HALFWAY = 0.05
"""Share of heights that may be almost halfway: fewer are of blocks of which every sixth is off by over 0.2 units."""

_NEAR = 0.12
"""Mean error, in units, below which heights count as nearly whole units when a unit is looked for.

It is half of what random heights have: with more, advice would name a wrong unit; with less, none for coarse measures.
"""

_WHOLE = 1e-3
"""Error, in units, up to which a height is a whole unit: the rounding of three decimals."""

_VISIBLE_CM = 1e-3
"""Rounding errors up to this come from decimals in the file, and are not reported."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Rounding:
    """The rounding of heights: the largest error and its cell x, y, and the mean, in cm; the number of filled holes.

    As text it is one line, empty if there is nothing to say.
    """

    largest_cm: float
    cell: Cell
    mean_cm: float
    filled: int

    def __str__(self) -> str:
        x, y = self.cell
        error = f"rounded by {self.mean_cm:.2g} cm on average, by {self.largest_cm:.2g} cm at most (x {x}, y {y})"
        filled = f"{self.filled:,} hole{'s'[: self.filled > 1]} filled from the neighbours"
        return "; ".join([error] * (self.largest_cm > _VISIBLE_CM) + [filled] * (self.filled > 0))


def are_not_blocks(units: Array, levels: Ints) -> bool:
    """Return whether heights, in units, are too far from whole units to be measured blocks of that unit."""
    import numpy as np

    errors = np.abs(units - levels)
    halfway = int((errors > _HALFWAY).sum())
    lost = bool(units.max(initial=0) > _WHOLE) and not levels.any()  # all rounded to 0
    return lost or float(errors.mean()) > _MEASURED or halfway > max(_MOST_HALFWAY * units.size, 1)


def advice(heights_cm: Array, unit_cm: float, *, whole: bool = True) -> str:
    """Return advice on heights [cm] that are no whole units: another ground, or another unit.

    whole: they have to be whole units; else only those are wrong that are too low or too high for a level.
    """
    import numpy as np

    heights = heights_cm[np.isfinite(heights_cm)]
    if heights.size and (heights.min() < -unit_cm / 2 or not whole):
        return _advice_of_ground(float(heights.min()), float(heights.max()), unit_cm)
    heights = heights[heights >= 0]
    if not heights.any():
        return "set other values (cm, m, in, ...)"
    # First another ground, then this unit measured badly, then another unit, of which blocks have 1 to 150 cm.
    lowest = float(heights.min())
    if lowest > unit_cm / 4 and _are_near(heights - lowest, unit_cm):
        return f"they are whole units above {lowest:.6g} cm: set datum_cm {lowest:.6g} if that is the ground"
    step = _largest_step(heights)
    if step is None:
        return "set another unit_cm, other values (cm, m, in, ...), or rounded"
    if abs(step / unit_cm - 1) < _NEAR:
        return "they are nearly whole units: rounded takes the nearest"
    may_be = {"levels": 1.0} if abs(step - 1) < 1e-6 else {}
    may_be |= {name: factor for name, factor in CENTIMETRES.items() if 1 <= step * factor <= 150}
    ways = (
        f"values {name}" + (f" and unit_cm {step * factor:.4g}" if name != "levels" else "")
        for name, factor in may_be.items()
    )
    return f"they are whole multiples of {step:.4g}: set {', or '.join(ways)}"


def _advice_of_ground(lowest: float, highest: float, unit_cm: float) -> str:
    """Return advice on heights [cm] of which some are too low or too high for a level: another ground or unit."""
    if lowest < _DEEPEST_CM or highest > MOST_CM:
        return (
            f"heights are {lowest:g} to {highest:g} cm: set other values (cm, m, in, ...), or write into the file "
            "which number stands for no data (`gdal_translate -a_nodata -9999 FILE NEW.tif`)"
        )
    ground, top = math.floor(lowest), math.ceil(highest)
    larger = math.ceil((top - ground) / _HIGHEST)
    also = f", and unit_cm {larger} or more" if larger > unit_cm else ""
    return f"heights are {ground} to {top} cm: set datum_cm {ground} if the lowest is the ground{also}"


def _largest_step(heights: Array) -> float | None:
    """Return the largest length of which all heights are nearly whole multiples, if the blocks have up to ten levels.

    It is looked for among the lowest height, without ground and outliers, and its half, third and quarter. Then it is
    the median of height / level, as a single height is measured badly.
    """
    import numpy as np

    positive = heights[heights > heights.max() * 0.02]  # less than a fifth of the lowest of ten levels is ground
    lowest = float(np.quantile(positive, 0.1))
    steps = (lowest / parts for parts in range(1, 5))
    near = (step for step in steps if heights.max() / step < 10.5 and _are_near(heights, step))
    step = next(near, None)
    return None if step is None else float(np.median(positive / np.maximum(np.rint(positive / step), 1)))


def _are_near(heights: Array, unit: float) -> bool:
    import numpy as np

    units = heights / unit
    return float(np.abs(units - np.rint(units)).mean()) < _NEAR


def lower_medians(rows: Array) -> Array:
    """Return the lower median of the values of each row that are not nan; nan if all are."""
    import numpy as np

    middles = np.maximum(np.count_nonzero(~np.isnan(rows), axis=1) - 1, 0) // 2
    return np.take_along_axis(np.sort(rows, axis=1), middles[:, None], axis=1)[:, 0]  # nan are last


def filled(heights: Array, holes: Mask) -> Array:
    """Return heights (n_x, n_y) with the lower median of the known of its eight neighbours in every hole.

    A hole is filled from its edge to its middle, ring by ring; at least one cell has to be no hole.
    """
    import numpy as np

    # Each pass fills the holes that have a known neighbour, and the next one counts these as known.
    complete = np.where(holes, np.nan, heights)
    missing = np.argwhere(holes)
    while len(missing):
        padded = np.pad(complete, 1, constant_values=np.nan)
        around = [padded[missing[:, 0] + i, missing[:, 1] + j] for i in range(3) for j in range(3)]  # and itself: nan
        medians = lower_medians(np.stack(around, axis=1))
        known = ~np.isnan(medians)
        complete[tuple(missing[known].T)] = medians[known]
        missing = missing[~known]
    return complete


MOST_CM = 2e6
"""Heights of ground above or below 0 at most: no place on Earth is 20 km from the sea's level."""

_DEEPEST_CM = -990_000
"""Depth that hardly any place on Earth has: -9999 and -32768 m stand for no data."""

MOST_CELLS = 2**24
"""Cells of a file at most: 4096 x 4096, which need 0.8 GB while they become a map."""

USUAL_UNIT_CM = 10.0
"""The unit of heights if neither the file nor the user gives one: a recipe's default."""

_HIGHEST = 32766
"""The highest level: a recipe has at most 32,767 levels, as levels are int16, and the lowest is 0."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Heights:
    """The content of a file: levels of shape (n_x, n_y), their unit [cm], and values of the recipe that it has.

    errors_cm, holes: (n_x, n_y), by how much each height is above its level, and which cells were filled, if known.
    sides: of blocks, if the file says how wide its cells are; in `recipe_values` too if they are squares of known size.
    metres_up: of the unit of heights, if the file says it, whatever unit they were read in.
    levels of -1 are of cells that the file does not know: they have no block, and the matrix leaves them as they are.
    """

    levels: Ints
    unit_cm: float
    recipe_values: Mapping[str, Any] = field(default_factory=dict)
    errors_cm: Array | None = None
    holes: Mask | None = None
    sides: CellSides | None = None
    metres_up: float | None = None

    def __post_init__(self) -> None:
        """Raise a ValueError for what is not as said above: importers are others' code too."""
        import numpy as np

        from rsegen.heights.coordinate_system import CellSides

        # First the levels, which all else is laid over, and then what may be missing.
        levels = np.asarray(self.levels)
        if levels is not self.levels or levels.dtype.kind not in "iu" or levels.ndim != 2 or not levels.size:
            got = f"{type(self.levels).__name__} of {levels.dtype}, of shape {levels.shape}"
            raise ValueError(f"levels are a {got}; expected an array of integers of shape (n_x, n_y)")
        if levels.min() < -1 or levels.max() > _HIGHEST:
            found = f"levels are {levels.min()} to {levels.max()}"
            raise ValueError(f"{found}; they may be 0 to {_HIGHEST}, or -1 for a cell without a block")
        for name in ("errors_cm", "holes"):
            array = getattr(self, name)
            if array is not None and np.shape(array) != levels.shape:
                raise ValueError(f"{name} has the shape {np.shape(array)}, and levels {levels.shape}")
        if self.sides is not None and not isinstance(self.sides, CellSides):
            raise ValueError(f"sides are {shown(self.sides)}; expected rsegen.heights.coordinate_system.CellSides")
        if self.metres_up is not None and not isinstance(self.metres_up, (int, float)):
            raise ValueError(f"metres_up is {shown(self.metres_up)}; expected a number")
        if unknown := sorted(self.recipe_values.keys() - parameters(Recipe).keys()):
            raise ValueError(f"recipe_values has {unknown[0]!r}, which is no parameter of a recipe")

    @property
    def unknown(self) -> int:
        """The number of cells that the file does not know."""
        return int((self.levels < 0).sum())

    @property
    def rounding(self) -> Rounding | None:
        """The rounding of the heights, None if it is unknown."""
        import numpy as np

        if self.errors_cm is None or self.holes is None:
            return None
        errors = np.where(self.holes, 0, np.abs(self.errors_cm))
        x, y = (int(at) for at in np.unravel_index(errors.argmax(), errors.shape))
        mean = float(errors.sum() / max((~self.holes).sum(), 1))
        return Rounding(largest_cm=float(errors[x, y]), cell=(x, y), mean_cm=mean, filled=int(self.holes.sum()))


@dataclass(frozen=True, kw_only=True, slots=True)
class Importer(ABC):
    """Reads heights from one sort of file, with its options."""

    name: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]]

    def __post_init__(self) -> None:
        validate(self)

    @abstractmethod
    def read(self, path: Path, unit_cm: float | None) -> Heights:
        """Return the heights in a file, in units of `unit_cm` if that is given; a FileError if it has none."""


def refuse_too_many_cells(path: Path, n_x: int, n_y: int) -> None:
    """Raise a FileError if a file has too many cells, or none; called before they are read."""
    from rsegen.writing.resources import refuse_many_heights

    if not 0 < n_x * n_y <= MOST_CELLS:
        raise FileError(f"{path}: {n_x} x {n_y} cells; from 1 up to {MOST_CELLS:,} can be read")
    refuse_many_heights(str(path), n_x, n_y)


def whole_units(
    path: Path, heights_cm: Array, unit_cm: float, *, rounded: bool, any_heights: bool = True, holes: Mask | None = None
) -> Ints:
    """Return heights [cm], shape (n_x, n_y), as levels; a FileError for the first that is no whole unit.

    rounded: other heights are rounded, but without any_heights only if they are measured blocks of that unit; holes:
    cells that do not count in that.
    """
    import numpy as np

    # Whatever is no level is refused with the first such cell, in the order in which a person reads the table.
    units = heights_cm / unit_cm
    levels = np.floor(units + 0.5)
    bad = ~np.isfinite(units) | (levels < 0) | (levels > _HIGHEST)
    if not rounded:
        with np.errstate(invalid="ignore"):
            bad |= np.abs(units - levels) > _WHOLE
    if bad.any():
        # The first in reading order; the top row of a table is the largest y.
        row, column = (int(at) for at in np.argwhere(bad[:, ::-1].T)[0])
        height = heights_cm[:, ::-1][column, row]
        amiss, hint = "nan cm is a hole", "fill_holes gives it the height of its neighbours"
        if not np.isnan(height):
            amiss = f"{height:g} cm is not 0..{_HIGHEST} whole units of {unit_cm:g} cm"
            hint = advice(heights_cm, unit_cm, whole=not rounded)
        others = int(bad.sum()) - 1
        more = f" ({others} more such cell{'s'[: others > 1]})" if others else ""
        raise FileError(f"{path}: row {row + 1} from the top, column {column + 1}: {amiss}{more}; {hint}")
    judged = np.ones(levels.shape, dtype=bool) if holes is None else ~holes
    if rounded and not any_heights and are_not_blocks(units[judged], levels[judged]):
        heights = heights_cm[judged]
        raise FileError(
            f"{path}: heights of {heights.min():.4g} to {heights.max():.4g} cm are not blocks of {unit_cm:g} cm: "
            f"{advice(heights, unit_cm)}; any_heights rounds them anyway"
        )
    return levels.astype(np.int32)


def _problem(cls: type[Importer]) -> str:
    """Return the problem of a plug-in's importer, a suffix or an option; empty if all is well."""
    for suffix in cls.suffixes:
        if not (suffix.startswith(".") and suffix.islower()):
            return f"reads files named *{suffix}; use a suffix such as .asc, in small letters"
    return name_conflict(cls, RESERVED_FLAGS) or ("" if cls() else "cannot be made without options")


IMPORTERS: Registry[type[Importer]] = Registry(
    "format of heights",
    package="rsegen.heights",
    group="rsegen.importers",
    contract=Contract(base=Importer, names=lambda cls: tuple(cls.suffixes), check=_problem),
)
"""Every importer by the suffixes of its files."""

register = IMPORTERS.register
"""Decorator of an importer, which is known by the suffixes of its files then."""


_ESRI_START = re.compile(r"\s*n(cols|rows)\s+\d+\s*$", re.IGNORECASE | re.MULTILINE)
"""The first line of a grid in Esri's ASCII format."""


def is_esri_grid(text: str) -> bool:
    """Return whether a text begins as a grid in Esri's ASCII format does, in which maps of ground are written."""
    return bool(_ESRI_START.match(text))


def reads(path: Path, start: bytes) -> str:
    """Return what reads a file with heights (`Capability.reads`): a table by its suffix, an occupancy grid by a key."""
    suffix = path.suffix.lower()
    if suffix in (".yaml", ".yml"):
        is_known = bool(re.search(rb"^image:", start, re.MULTILINE))
    elif suffix == ".asc":  # a grid, or else a cloud
        is_known = is_esri_grid(start.decode("latin-1"))
    else:
        is_known = suffix in IMPORTERS and suffix != ".txt"  # which may be anything
    return "rsegen import (for heights)" if is_known else ""


_OF_GDAL = (".dem", ".hgt", ".nc", ".img", ".vrt", ".adf", ".bil", ".flt", ".grd")
"""Endings of files with ground, of which GDAL makes images."""


def _is_heights(path: Path) -> bool:
    """Return whether an importer reads a file, by its name; the file that says what is in a bag of ROS 2 has none."""
    return path.suffix.lower() in IMPORTERS and path.name != "metadata.yaml"


def importer_for(path: Path) -> type[Importer]:
    """Return the importer for a file by its suffix, or a FileError that lists the known ones."""
    importer = IMPORTERS.get(path.suffix.lower())
    if not importer:
        if path.suffix.lower() in _OF_GDAL:
            raise FileError(f"{path}: write it as GeoTIFF with `gdal_translate -b 1 -ot Float32 FILE NEW.tif`")
        if inside := first_inside(path, _is_heights):
            raise FileError(f"{path}: a folder; use a file in it, such as {inside}")
        raise FileError(f"{path}: heights are read from files named {', '.join('*' + suffix for suffix in IMPORTERS)}")
    return importer


def imported(
    path: str | Path, reading: Importer | None = None, unit_cm: float | None = None, chunk_size: int | None = None
) -> Recipe:
    """Return the recipe of one map: the heights in a file as a matrix, without frames unless the file names them.

    Parameters
    ----------
    path : str or Path
        The file.
    reading : Importer, optional
        How it is read; by default as the end of its name says.
    unit_cm : float, optional
        Height of one level, cm; by default as the file says.
    chunk_size : int, optional
        Side of a chunk in blocks, which must divide both sides; by default as the file says, or 10 if it divides both
        sides, else the largest number up to 1000 that does.

    Returns
    -------
    Recipe
        The recipe.

    Raises
    ------
    FileError
        If the file cannot be read.
    ParameterError
        If a value is wrong.
    """
    path = FilePath("a file").check("path", path)
    reading = importer_for(path)() if reading is None else reading
    refuse_other("reading", reading, Importer)
    return recipe_of_heights(path, heights_in(path, reading, unit_cm), chunk_size)


def heights_in(path: Path, reading: Importer, unit_cm: float | None = None) -> Heights:
    """Return the heights in a file, as levels of `unit_cm`, by default of the unit that the file says."""
    import numpy as np

    with np.errstate(all="ignore"):  # what is no number, or too large for one, is found in whole_units
        heights: object = reading.read(path, unit_cm)
    if not isinstance(heights, Heights):
        raise PluginError(f"plug-in {reading.name}: read() gave {shown(heights)}; expected rsegen.heights.base.Heights")
    return heights


def recipe_of_heights(path: Path, heights: Heights, chunk_size: int | None = None) -> Recipe:
    """Return the recipe of one map of heights; filled holes are a matrix of their own; see `imported`."""
    import numpy as np

    from rsegen.obstacles.matrix import Matrix
    from rsegen.recipe.from_field import largest_chunk

    n_x, n_y = heights.levels.shape
    common, side = math.gcd(n_x, n_y), chunk_size or heights.recipe_values.get("chunk_size")
    if side and common % side:
        raise ParameterError("chunk_size", f"{side} does not divide {n_x} x {n_y} cells; {common} does")
    # Without frames any chunk size that divides both sides gives the same map: the usual 10, or else the largest.
    side = side or (10 if common % 10 == 0 else largest_chunk(n_x, n_y))
    parts = {"heights": heights.levels}
    # -1 leaves a cell as it is, so whoever removes the second matrix has the holes again.
    if heights.holes is not None and heights.holes.any():
        parts = {
            "heights": np.where(heights.holes, -1, heights.levels),
            "filled-holes": np.where(heights.holes, heights.levels, -1),
        }
    recipe_values = {"boundary": "none", **heights.recipe_values, "unit_cm": heights.unit_cm, "chunk_size": side}
    return Recipe(
        name=re.sub(r"[^A-Za-z0-9_.\-]", "_", path.stem).lstrip(".-")[:64] or "heights",
        description=re.sub(r"[\x00-\x1f]", " ", f"heights of {path.name}")[:500],
        chunks=(n_x // side, n_y // side),
        seed=0,
        obstacles=tuple(Matrix.of(levels, key=key) for key, levels in parts.items()),
        **recipe_values,
    )
