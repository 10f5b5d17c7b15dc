"""Makes one shard of a data set in a hidden folder: the levels and metrics of some maps, each file whole or not at all.

The process that runs the data set records the shard, and only then moves its files into their places.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rsegen.field.metrics.batch import batch_metrics
from rsegen.field.stepfield import Levels
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.manifest import Shard
from rsegen.io.dataset.tables import npy, table
from rsegen.io.record import WrittenFile
from rsegen.recipe.batch import build_many


@dataclass(frozen=True, kw_only=True, slots=True)
class ShardTask:
    """Makes shards by their numbers: all that a worker needs to know."""

    layout: ShardLayout
    folder: Path
    sync: bool = True

    @property
    def seconds(self) -> float:
        """About how long a shard takes; decides how the shards are divided among workers, never the result."""
        n_x, n_y = self.layout.grid_shape
        obstacles = max(len(recipe.obstacles) for recipe in self.layout.recipes)
        return self.layout.shard_maps * (3e-5 * obstacles + n_x * n_y * 1.5e-7)

    def __call__(self, numbers: Iterable[int]) -> tuple[Shard, ...]:
        """Shards, on disk."""
        return tuple(map(self.make, numbers))

    def make(self, number: int) -> Shard:
        """One shard, on disk in the hidden folder."""
        layout, names = self.layout, self.layout.names(number)
        levels, files = self._levels(number), {}
        if layout.metrics != "none":
            content = table(layout.metrics, layout.indices(number), batch_metrics(levels, layout.flat_field))
            files["metrics"] = self._written(names["metrics"], content)
        return Shard(number=number, files={"levels": self._written(names["levels"], npy(levels)), **files})

    def _levels(self, number: int) -> Levels:
        levels = build_many(self.layout.recipe_of_shard(number), self.layout.indices(number))
        found = levels.astype(self.layout.dtype)
        if (found != levels).any():
            raise OverflowError(f"a level of shard {number} is no {self.layout.dtype}")
        return found

    def _written(self, name: str, content: bytes) -> WrittenFile:
        """Write a file under a name of its own, then rename it: on a cluster two workers may make the same one."""
        hidden = self.folder / f"{name}.{secrets.token_hex(4)}"
        with open(hidden, "wb") as file:
            file.write(content)
            if self.sync:
                file.flush()
                os.fsync(file.fileno())
        hidden.replace(self.folder / name)
        return WrittenFile.of(content)
