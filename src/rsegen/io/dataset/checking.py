"""Checks that the files of a data set are those that its manifest lists."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from pathlib import Path

from rsegen.errors import DatasetDamaged
from rsegen.io.checksums import Checksum, checksum_of
from rsegen.io.dataset.layout import ShardLayout
from rsegen.io.dataset.manifest import Shard


def refuse_other_sizes(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> None:
    """Raise DatasetDamaged for the first file that is missing, or has another size than the manifest says."""
    for path, part in _files(folder, layout, shards):
        found = path.stat().st_size if path.is_file() else None
        if found != part.bytes:
            there = "is missing" if found is None else f"has {found} bytes, and the manifest says {part.bytes}"
            raise DatasetDamaged(f"{path}: {there}; the command that made the data set repairs it with --resume")


def refuse_other_checksums(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> None:
    """Raise DatasetDamaged for the first file with a wrong checksum."""
    for path, part in _files(folder, layout, shards):
        if checksum_of(path) != part:
            raise DatasetDamaged(
                f"{path}: has changed, its checksum is wrong; "
                "the command that made the data set repairs it with --resume"
            )


def random_places(maps: int, wanted: int) -> list[int]:
    """`wanted` places of maps, chosen at random; all of them if there are fewer."""
    return sorted(random.SystemRandom().sample(range(maps), min(wanted, maps)))


def _files(folder: Path, layout: ShardLayout, shards: Iterable[Shard]) -> Iterator[tuple[Path, Checksum]]:
    for shard in shards:
        names = layout.names(shard.number)
        yield from ((folder / names[what], part) for what, part in shard.files.items())
