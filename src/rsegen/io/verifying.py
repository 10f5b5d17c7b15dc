"""Compares folders with the records of what rsegen wrote there: maps, drives, series, experiments and data sets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import FileError, FilesDamaged
from rsegen.io.contents import compare
from rsegen.io.record import RECORD, read_record


@dataclass(frozen=True, kw_only=True, slots=True)
class Verified:
    """How many folders with a record and files were compared, and the files that no record lists."""

    folders: int
    files: int
    unlisted: tuple[Path, ...]


def verify(folder: str | Path) -> Verified:
    """Compare a folder, and the folders in it, with their records, or a data set with its manifest.

    Raises FilesDamaged if a file is missing, empty or changed, FileError if there is no record. Nothing is built
    again; `Dataset.verify` does that too.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(f"{folder}: there is no such folder")
    found = [_verified(each) for each in _with_record(folder)]
    if not found:
        raise FileError(
            f"{folder}: no {RECORD} in it, nor in its folders, so its files cannot be compared (0.1 wrote none)"
        )
    return Verified(
        folders=len(found),
        files=sum(one.files for one in found),
        unlisted=tuple(path for one in found for path in one.unlisted),
    )


def _with_record(folder: Path) -> Iterator[Path]:
    """The folder and those in it, each if it has a record or manifest."""
    inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    for path in (folder, *inside):
        if any((path / name).is_file() for name in (RECORD, "manifest.json")):
            yield path


def _verified(folder: Path) -> Verified:
    """One folder; FilesDamaged for the first file that is not as rsegen wrote it."""
    record = read_record(folder)
    if record is None:
        return _verified_dataset(folder)
    found = compare(folder, record)
    wrong = [(name, "was changed after rsegen wrote it") for name in found.changed]
    wrong += [(name, "is missing or empty") for name in found.damaged]
    for name, what in wrong[:1]:
        more = f"; {len(wrong) - 1} more files in this folder are changed, missing or empty" if wrong[1:] else ""
        raise FilesDamaged(f"{folder / name}: {what}{more}")
    own = () if record.content == "files" else found.foreign
    return Verified(folders=1, files=len(record.files), unlisted=tuple(folder / name for name in own))


def _verified_dataset(folder: Path) -> Verified:
    from rsegen.io.dataset.reading import Dataset

    dataset = Dataset(folder)
    dataset.verify(rebuild=0)
    return Verified(folders=1, files=sum(len(shard.files) for shard in dataset.shards), unlisted=())
