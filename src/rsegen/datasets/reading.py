"""Read a data set: levels mapped into memory, any map by its place, metrics as columns.

Only what is indexed is read from the disk, in microseconds per map, however many there are. Arrays and tables of
metrics are converted to files and back; the same values give the same bytes, except for Parquet's, which depend on
pyarrow.

Maps are also laid out as tiles of a terrain, for curriculum learning:

    rows (+x): from the easiest map to the hardest     columns (+y): maps of about the same difficulty, or a recipe each

They are chosen by a metric: the maps nearest to evenly spaced values, each used once, or at evenly spaced ranks.
Cost: a sum over all maps per row; a metric that is not in the table of the data set is measured map by map, which
costs most. What breaks it: a metric with few different values, of which neighbouring rows then have the same.
"""

from __future__ import annotations

import io
import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen import npy_files
from rsegen.datasets import DATASET
from rsegen.datasets.difficulty_tiles import amid, kind_of_column
from rsegen.datasets.layout import (
    CELLS,
    ROW,
    Shard,
    ShardLayout,
    read_manifest,
    refuse_other_checksums,
    refuse_other_sizes,
)
from rsegen.errors import DatasetDamaged, FileError, ParameterError, UnknownName, UserError, shown
from rsegen.field.crossing import CrossingModel
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.input_files import open_regular
from rsegen.measuring.batch import COLUMNS, Table, batch_metrics
from rsegen.measuring.catalogue import RMS, By, metric_by
from rsegen.params.extras import pip_install
from rsegen.params.sorts import Choice, FilePath, Integer, as_int
from rsegen.recipe.building import blocks
from rsegen.recipe.recipe import Recipe


def table(form: str, maps: range, figures: Table) -> bytes:
    """Return the metrics of maps, given by their indices, as the content of a file: rows of ROW, or Parquet."""
    if form == "parquet":
        pyarrow, parquet = arrow()
        file = io.BytesIO()
        parquet.write_table(pyarrow.table({"map": np.array(maps, dtype=np.int64), **figures}), file)
        return file.getvalue()
    rows = np.empty(len(maps), dtype=ROW)
    rows["map"] = maps
    for name in COLUMNS:
        rows[name] = figures[name]
    return npy_files.npy_bytes(rows)


def mapped_array(path: Path, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the array in a file, mapped into memory; FileError if it has another shape or type, or does not exist."""
    array = npy_files.mapped(path)
    if array.shape != shape or array.dtype != dtype:
        raise FileError(f"{path}: has shape {array.shape} of {array.dtype}; expected {shape} of {dtype}")
    return np.asarray(array)


def read_parquet(path: Path, maps: int) -> dict[str, NDArray[Any]]:
    """Return the columns of a Parquet table; FileError if it is another table, or does not exist."""
    pyarrow, parquet = arrow()
    try:
        with open_regular(path) as opened:
            file = parquet.ParquetFile(opened)
            types = {field.name: field.type for field in file.schema_arrow}
            expected = {"map": pyarrow.int64(), **dict.fromkeys(COLUMNS, pyarrow.float32())}
            if file.metadata.num_rows != maps or types != expected:
                raise FileError(f"{path}: is not the metrics of {maps} maps")
            columns = file.read()
    except (OSError, pyarrow.ArrowException) as error:
        why = getattr(error, "strerror", None) or str(error).partition("\n")[0][:200]
        raise FileError(f"{path}: not a table in Parquet: {why}") from None
    return {name: columns[name].to_numpy() for name in ROW.names or ()}


def arrow() -> tuple[Any, Any]:
    """Return pyarrow and its Parquet; a ParameterError that says how to install it, if it is missing."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise ParameterError("metrics", f"parquet needs pyarrow: {pip_install([DATASET.name])}; or use npy") from None
    return pyarrow, parquet


_LEAST_COMPARED = 100
"""Maps of a recipe that are compared with each other at least, however large they are."""

OPEN = 256
"""Shards that are mapped at the same time, at most: each has a file descriptor, of which systems give 1024 and less."""


class LevelsOfMaps:
    """The block levels of all maps as one array (maps, n_x, n_y) that reads only what is indexed."""

    def __init__(self, layout: ShardLayout, folder: Path) -> None:
        self._layout = layout
        self._folder = folder
        self._shard = lru_cache(OPEN)(self._mapped)
        self.shape: tuple[int, ...] = (layout.maps, *layout.grid_shape)
        self.dtype: np.dtype[Any] = layout.dtype

    def _mapped(self, number: int) -> Ints:
        path = self._folder / self._layout.names(number)["levels"]
        return mapped_array(path, self._layout.shape(number), self._layout.dtype)

    def __reduce__(self) -> tuple[type[LevelsOfMaps], tuple[ShardLayout, Path]]:
        return LevelsOfMaps, (self._layout, self._folder)

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Ints]:
        for number in range(self._layout.shards):
            yield from self._shard(number)

    def __getitem__(self, maps: int | slice | Ints | Mask | list[int]) -> Ints:
        """Return a map (n_x, n_y), or several, (maps, n_x, n_y), for a slice, a list of places, or a mask."""
        if isinstance(maps, slice):
            return self._several(np.arange(*maps.indices(len(self))))
        if isinstance(maps, (list, np.ndarray)):
            return self._several(self._places(np.asarray(maps)))
        own = as_int(maps)
        if own is None:
            raise IndexError(f"{shown(maps)} is not the place of a map; use an integer, a slice, or a list of integers")
        place = own + len(self) if own < 0 else own
        if not 0 <= place < len(self):
            raise IndexError(f"there is no map {maps}; the data set has {len(self)}")
        number, row = self._layout.row_at(place)
        levels: Ints = self._shard(number)[row]
        return levels

    def _places(self, maps: Ints | Mask) -> Ints:
        """Places from 0 on, of negative places or a mask."""
        if maps.dtype == bool and maps.shape == (len(self),):
            return np.flatnonzero(maps)
        if maps.ndim != 1 or (maps.size and not np.issubdtype(maps.dtype, np.integer)):
            raise IndexError("expected a list of integers, or a boolean for every map")
        beyond = maps[(maps < -len(self)) | (maps >= len(self))]
        if beyond.size:
            raise IndexError(f"there is no map {beyond[0]}; the data set has {len(self)}")
        return np.where(maps < 0, maps + len(self), maps).astype(np.intp)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: FBT001  # as numpy calls it
        return np.asarray(self[:], dtype=dtype)

    def _several(self, places: Ints) -> Ints:
        """Return the maps at some places, read shard by shard."""
        levels = np.empty((len(places), *self.shape[1:]), dtype=self.dtype)
        numbers, rows = self._layout.rows_at(places)
        for number in np.unique(numbers):
            in_shard = numbers == number
            levels[in_shard] = self._shard(int(number))[rows[in_shard]]
        return levels


SPACING = Choice(("value", "rank"))
"""Spacing of the rows: even in the metric itself, or in its rank among all maps."""


class Tiles(NamedTuple):
    """A terrain, as IsaacLab, mjlab and legged_gym lay theirs out: difficulty rises along x, from row to row.

    Attributes
    ----------
    levels : ndarray, shape (rows, columns, n_x, n_y)
        Block levels, frames left out.
    heights : ndarray, shape (rows, columns, cells_x, cells_y)
        Heights in metres, frames counted.
    origins : ndarray, shape (rows, columns, 3)
        The middle of each tile, metres, all together centred on x = y = 0; z is the height of the highest cell that
        meets there, so that a robot does not start inside a block.
    places : ndarray of int, shape (rows, columns)
        Which map of the data set it is.
    difficulty : ndarray of float32, shape (rows, columns)
        Its metric.
    size : tuple of float
        Metres of one tile along x and y, frames counted.
    """

    levels: Ints
    heights: Array
    origins: Array
    places: NDArray[np.intp]
    difficulty: NDArray[np.float32]
    size: tuple[float, float]


class Dataset:
    """The maps of one or several recipes in a folder, as `rsegen dataset` makes it; maps are counted from 0.

    The maps of the first recipe come first. `recipe_of(place)` is the recipe of one map. Of a single recipe,
    `recipe.indices[place]` is its index: the same number, unless there is a `first_map`. Its files are not trusted: no
    name is taken from its manifest.

    Parameters
    ----------
    folder : str or Path
        Folder of the data set.

    Raises
    ------
    DatasetDamaged
        If a file has another size than the manifest says.
    FileError
        If there is no data set.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder: Path = FilePath().check("folder", folder)
        self.layout: ShardLayout
        self.shards: list[Shard]
        self.layout, self.shards = read_manifest(self.folder)
        refuse_other_sizes(self.folder, self.layout, self.shards)

    def __reduce__(self) -> tuple[type[Dataset], tuple[Path]]:
        return Dataset, (self.folder,)

    def __repr__(self) -> str:
        return (
            f"Dataset({str(self.folder)!r}: {len(self)} maps of {' x '.join(map(str, self.layout.grid_shape))} blocks)"
        )

    @property
    def recipe(self) -> Recipe:
        """The recipe of all maps; a UserError if there are several."""
        first, *others = self.recipes
        if others:
            raise UserError(f"{self.folder}: has {len(self.recipes)} recipes; take recipes, or recipe_of(place)")
        return first

    @property
    def recipes(self) -> tuple[Recipe, ...]:
        """The recipes, in the order of their maps."""
        return tuple(self.layout.recipes)

    def recipe_of(self, place: int) -> Recipe:
        """Return the recipe of one map and no other, as DIR#17 names it; a UserError if there is no such map."""
        recipe, index = self.layout.map_at(Integer(0, len(self) - 1).check("place", place))
        return recipe.alone(index)

    @cached_property
    def recipe_numbers(self) -> NDArray[np.int16]:
        """The number of the recipe of each map, counted from 0: (maps,)."""
        return np.repeat(np.arange(len(self.recipes), dtype=np.int16), [recipe.maps for recipe in self.recipes])

    @property
    def bytes(self) -> int:
        """The size of its shards on disk."""
        return sum(part.bytes for shard in self.shards for part in shard.files.values())

    @cached_property
    def levels(self) -> LevelsOfMaps:
        """The block levels of all maps, mapped into memory: (maps, n_x, n_y)."""
        return LevelsOfMaps(self.layout, self.folder)

    def __len__(self) -> int:
        return self.layout.maps

    def __getitem__(self, maps: int | slice | Ints | Mask | list[int]) -> Ints:
        levels = self.levels[maps]
        return levels if levels.flags.writeable else levels.copy()

    def __getitems__(self, maps: list[int]) -> Ints:
        """Several maps at once, (maps, n_x, n_y), which torch's DataLoader asks for."""
        return self.levels[maps]

    def __iter__(self) -> Iterator[Ints]:
        return iter(self.levels)

    def field(self, place: int) -> StepField:
        """Return a map with its frames and metres, as `build` makes it."""
        return self.layout.field(self[place])

    def heights(self, place: int) -> Array:
        """Height of every cell of one map, frames counted, in metres: (n_x, n_y)."""
        return self.field(place).heights

    @cached_property
    def metrics(self) -> dict[str, NDArray[Any]]:
        """A column for each metric, one row per map: read, or measured if the data set has no table.

        `map` is its index in its recipe; all else is named as in `rsegen metrics --csv`, in metres, NaN for none.
        """
        tables = [self._table(number) for number in range(self.layout.shards)]
        return {name: np.concatenate([table[name] for table in tables]) for name in ROW.names or ()}

    def _table(self, number: int) -> Mapping[str, NDArray[Any]]:
        maps, name = self.layout.indices(number), self.layout.names(number).get("metrics")
        if name is None:
            places = self.layout.places(number)
            return {
                "map": np.array(maps, dtype=np.int64),
                **batch_metrics(self[places.start : places.stop], self.layout.flat_field),
            }
        if self.layout.metrics == "parquet":
            return read_parquet(self.folder / name, len(maps))
        rows = mapped_array(self.folder / name, (len(maps),), ROW)
        return {column: rows[column] for column in ROW.names or ()}

    def tiles(
        self,
        rows: int,
        columns: int,
        by: By = RMS,
        *,
        robot: CrossingModel | None = None,
        spacing: str = "value",
        recipes: Sequence[str] | None = None,
    ) -> Tiles:
        """Return a terrain of rows x columns maps that gets harder from row to row, by any metric.

        by: the name of a metric, rsegen's own or a plug-in's, or a function StepField -> float. Metrics that are not in
        the table of the data set are measured map by map.
        robot: for metrics of a robot, such as `reach.west_east.cost`; maps that it cannot cross are left out.
        spacing: `value`, the metric rises evenly from the least to the greatest of each recipe; or `rank`, its rank.
        recipes: names of recipes, each for equally many neighbouring columns; all by default.
        """
        # For each recipe the maps of its columns, then what they are as a terrain.
        spacing = SPACING.check("spacing", spacing)
        rows, columns = (Integer(1).check(name, value) for name, value in (("rows", rows), ("columns", columns)))
        kinds = _kinds(self, recipes, columns)
        figures, named = _figures(self, by, robot, np.isin(self.recipe_numbers, kinds))
        places = np.empty((rows, columns), dtype=np.intp)
        for kind in np.unique(kinds):
            own = np.flatnonzero((self.recipe_numbers == kind) & ~np.isnan(figures))
            own = own[np.argsort(figures[own], kind="stable")]  # from the least to the greatest
            count = int((kinds == kind).sum())
            if rows * count > len(own):
                of = "" if len(self.recipes) == 1 else f" of {self.recipes[kind].name}"
                raise ParameterError(
                    "rows", f"{rows} x {count} tiles{of} need as many maps, and {len(own)} have a {named}"
                )
            if spacing == "rank":
                ranks = np.linspace(0, len(own) - 1, rows * count).round().astype(np.intp)
                places[:, kinds == kind] = own[ranks].reshape(rows, count)
            else:
                places[:, kinds == kind] = _by_value(figures, own, rows, count)
        levels = self[places.ravel()]
        heights = np.array([self.layout.field(blocks).heights for blocks in levels])
        size = self.layout.flat_field.extent
        x, y = ((np.arange(n) - (n - 1) / 2) * side for n, side in zip((rows, columns), size, strict=True))
        middles = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        return Tiles(
            levels=levels.reshape(rows, columns, *levels.shape[1:]),
            heights=heights.reshape(rows, columns, *heights.shape[1:]),
            origins=np.concatenate([middles, amid(heights).reshape(rows, columns, 1)], axis=-1),
            places=places,
            difficulty=figures[places],
            size=size,
        )

    def distinct(self, name: str) -> tuple[int, int]:
        """Return how many different maps are among the first ones of a recipe, and how many were compared.

        Up to 10,000 are compared, fewer if they are large. A recipe that draws little repeats its maps soon, under
        other indices and seeds too.
        """
        names = [recipe.name for recipe in self.recipes]
        if name not in names:
            raise UnknownName.among("name", "recipe", name, names)
        number = names.index(name)
        first = sum(recipe.maps for recipe in self.recipes[:number])
        # About as many as one shard has, by default.
        most = max(CELLS // prod(self.layout.grid_shape), _LEAST_COMPARED)
        compared = self[first : first + min(self.recipes[number].maps, most)]
        return len({levels.tobytes() for levels in compared}), len(compared)

    def verify(self, rebuild: int = 8) -> None:
        """Raise DatasetDamaged for the first file with a wrong checksum, or map that is built again and differs.

        `rebuild` maps are built again, chosen at random.
        """
        refuse_other_checksums(self.folder, self.layout, self.shards)
        for place in sorted(random.SystemRandom().sample(range(len(self)), min(rebuild, len(self)))):
            if not np.array_equal(self[place], blocks(*self.layout.map_at(place))):
                raise DatasetDamaged(
                    f"{self.folder}#{place}: is not the map that this version of rsegen makes of the recipe"
                )


def _kinds(dataset: Dataset, names: Sequence[str] | None, columns: int) -> NDArray[np.intp]:
    """Return the number of the recipe of each column."""
    known = {recipe.name: kind for kind, recipe in enumerate(dataset.recipes)}
    chosen = list(known) if names is None else names
    if isinstance(chosen, str) or not isinstance(chosen, Sequence):
        raise ParameterError("recipes", f"{shown(names)} is not a list of names of recipes")
    for index, name in enumerate(chosen):
        if not isinstance(name, str) or name not in known:
            raise UnknownName.among(f"recipes[{index}]", "recipe", name, known)
    if not 0 < len(chosen) <= columns:
        raise ParameterError("recipes", f"{len(chosen)} for {columns} columns; use at most one per column")
    return np.array([known[chosen[kind_of_column(column, columns, len(chosen))]] for column in range(columns)])


def _by_value(figures: NDArray[np.float32], ranked: NDArray[np.intp], rows: int, columns: int) -> NDArray[np.intp]:
    """Return row by row the maps nearest to evenly spaced values, from the least to the greatest.

    Each row has neighbours in rank, all above the row before, and leaves enough maps for the rows after it: where maps
    are few, as at both ends, two rows may have the same maps as their nearest.
    """
    values = figures[ranked].astype(np.float64)
    places, first = np.empty((rows, columns), dtype=np.intp), 0
    for row, target in enumerate(np.linspace(values[0], values[-1], rows)):
        # The sum of distances from the target of each `columns` neighbours, as a difference of running sums.
        until = np.concatenate([[0.0], np.cumsum(np.abs(values - target))])
        last = len(values) - (rows - row) * columns
        first += int(np.argmin((until[columns:] - until[:-columns])[first : last + 1]))
        places[row] = ranked[first : first + columns]
        first += columns
    return places


def _figures(dataset: Dataset, by: By, robot: CrossingModel | None, wanted: Mask) -> tuple[NDArray[np.float32], str]:
    """Return a metric of every map, NaN for none, and its name: from the table, or measured on each that is wanted."""
    metric = metric_by(by, robot)
    if isinstance(by, str) and by in COLUMNS and robot is None:
        return dataset.metrics[by], by
    figures = np.full(len(dataset), np.nan, dtype=np.float32)
    figures[wanted] = [metric(dataset.field(int(place))) for place in np.flatnonzero(wanted)]
    return figures, metric.name
