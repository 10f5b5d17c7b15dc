"""The files of a data set: which maps are in which file, its name and its size.

    DIR/manifest.json       the recipe, and the size and checksum of every file
    DIR/levels-00000.npy    block levels of the first maps, (maps, n_x, n_y), frames left out
    DIR/metrics-00000.npy   a row of metrics for each of them; or .parquet
    DIR/levels-00001.npy    of the next maps ...

All of it follows from the recipe, so no name is ever taken from a file.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.metrics.batch import COLUMNS
from rsegen.field.stepfield import Ints, StepField, framed
from rsegen.params.sorts import Choice, Integer, validate
from rsegen.recipe.recipe import Recipe

CELLS = 1_000_000
"""Cells in a shard, about: a second of work or less, a megabyte."""

MOST = 100_000
"""Shards in a data set at most: the manifest is read as a whole."""

ROW = np.dtype([("map", "<i8"), *((name, "<f4") for name in COLUMNS)])
"""A row of a table of metrics: the index of the map in its recipe, and its metrics."""


@dataclass(frozen=True, kw_only=True)
class ShardLayout:
    """A recipe of many maps, how many of them a shard has (0: about a million cells), and the form of the metrics."""

    recipe: Recipe
    shard_maps: Annotated[int, Integer(0, 10**9, unit="maps", help="maps in a file; 0: about a million cells")] = 0
    metrics: Annotated[
        str, Choice(("npy", "parquet", "none"), help="form of the table of metrics; parquet needs rsegen[dataset]")
    ] = "npy"

    def __post_init__(self) -> None:
        validate(self)
        n_x, n_y = self.recipe.grid.shape
        least = -(-self.recipe.maps // MOST)
        object.__setattr__(self, "shard_maps", self.shard_maps or max(CELLS // (n_x * n_y), least))
        if self.shard_maps < least:
            raise ParameterError(
                "shard_maps", f"{self.shard_maps} would make {self.shards} shards; give {least} or more"
            )

    @property
    def shards(self) -> int:
        """How many shards there are."""
        return -(-self.recipe.maps // self.shard_maps)

    @property
    def dtype(self) -> np.dtype[np.integer]:
        """The smallest of uint8 and int16 that holds every level that a map of the recipe can have."""
        return np.dtype("u1" if self.recipe.highest_level < 2**8 else "<i2")

    @cached_property
    def flat_field(self) -> StepField:
        """A flat field with the frames of the maps: they differ from it in nothing but their levels."""
        return self.field(np.zeros(self.recipe.grid.shape, dtype=np.int16))

    def field(self, blocks: Ints) -> StepField:
        """The field of a map with these block levels: frames round them, lengths in metres."""
        recipe = self.recipe
        levels, frame = framed(blocks.astype(np.int16), recipe.chunk_size, recipe.boundary)
        return StepField(
            levels=levels,
            frame=frame,
            block_width=recipe.block_width_cm / 100,
            unit=recipe.unit_cm / 100,
            frame_height=recipe.frame_height_cm / 100,
        )

    def places(self, number: int) -> range:
        """The maps of a shard, counted from 0 in the data set."""
        first = number * self.shard_maps
        return range(first, min(first + self.shard_maps, self.recipe.maps))

    def indices(self, number: int) -> range:
        """The indices in the recipe of the maps of a shard."""
        places = self.places(number)
        return self.recipe.indices[places.start : places.stop]

    def shape(self, number: int) -> tuple[int, int, int]:
        """Shape of the levels of a shard: (maps, n_x, n_y)."""
        return (len(self.places(number)), *self.recipe.grid.shape)

    def bytes(self, number: int) -> int:
        """Bytes of the levels of a shard, without the file's header."""
        maps, n_x, n_y = self.shape(number)
        return maps * n_x * n_y * self.dtype.itemsize

    @property
    def bytes_per_map(self) -> int:
        """Bytes of disk that a map needs."""
        n_x, n_y = self.recipe.grid.shape
        return n_x * n_y * self.dtype.itemsize + (0 if self.metrics == "none" else ROW.itemsize)

    def names(self, number: int) -> dict[str, str]:
        """The names of the files of a shard, by what they hold."""
        table = {} if self.metrics == "none" else {"metrics": f"metrics-{number:05d}.{self.metrics}"}
        return {"levels": f"levels-{number:05d}.npy"} | table
