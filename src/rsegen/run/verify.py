"""Compares folders with the journals of what rsegen wrote there: maps, drives, series, experiments and data sets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rsegen.errors import FileError, FilesDamaged
from rsegen.io.checksums import JOURNAL
from rsegen.run.journal import Journal, compare, read_errors, read_journal


@dataclass(frozen=True, kw_only=True, slots=True)
class Verified:
    """How many folders with a journal and files were compared, and the files that no journal lists."""

    folders: int
    files: int
    unlisted: tuple[Path, ...]


def verify(folder: str | Path) -> Verified:
    """Compare a folder, and the folders in it, with their journals.

    Raises FilesDamaged if a file is missing, empty or changed, FileError if there is no journal. Nothing is built
    again; `Dataset.verify` does that too.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(f"{folder}: there is no such folder")
    with read_errors(folder):
        inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
        journals = {path: journal for path in (folder, *inside) if (journal := read_journal(path))}
    if not journals:
        raise FileError(f"{folder}: no {JOURNAL} in it, nor in its folders, so its files cannot be compared")
    unlisted = [path for home, journal in journals.items() for path in _compared(home, journal)]
    files = sum(len(journal.files) for journal in journals.values())
    return Verified(folders=len(journals), files=files, unlisted=tuple(unlisted))


def _compared(home: Path, journal: Journal) -> list[Path]:
    """Return the files of a folder that its journal does not list; FilesDamaged for the first that is not as it was."""
    with read_errors(home):
        found = compare(home, journal)
    wrong = [(name, "was changed after rsegen wrote it") for name in found.changed]
    wrong += [(name, "is missing or empty") for name in found.missing]
    for name, what in wrong[:1]:
        more = f"; {len(wrong) - 1} more files in this folder are changed, missing or empty" if wrong[1:] else ""
        raise FilesDamaged(f"{home / name}: {what}{more}")
    return [] if journal.holds in ("files", "experiment") else [home / name for name in found.foreign]
