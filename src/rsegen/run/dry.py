"""A dry run: the names of the files that a run would write, replace, remove and keep; nothing on the disk is changed.

    with dry_run() as notes:
        command()           every store that is opened inside (store.py) notes names in place of writing

All that refuses a run refuses its dry run. Files of maps are named by what makes them, so the names are right by
construction; a run whose work is long, such as trials or shards, names its files beforehand by `foresee`, and ends.
What breaks it: a file that is put on the disk by anything but a store.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from rsegen.input_files import JOURNAL

FATES = ("write", "replace", "remove", "keep")


class _Ended(Exception):  # no error: a dry run has noted all that it can
    """The end of a dry run whose work would be long."""


class Notes:
    """Notes of a dry run: the fate of each file."""

    def __init__(self) -> None:
        self._fates: dict[Path, str] = {}

    def put(self, folder: Path, names: Iterable[str]) -> None:
        """Note files that are put into a folder, and the journal that will list them."""
        for name in dict.fromkeys((*names, JOURNAL)):
            path = folder / name
            self._fates[path] = "replace" if os.path.lexists(path) else "write"

    def put_whole(self, folder: Path, names: Iterable[str]) -> None:
        """Note files of a folder that takes the place of what has its name, if anything does."""
        self.put(folder, names)
        self.rest(folder, "remove")

    def rest(self, folder: Path, fate: str) -> None:
        """Note the fate of all other files of a folder."""
        for path in folder.rglob("*"):
            if not path.is_dir():
                self._fates.setdefault(path, fate)

    def by_fate(self) -> Mapping[str, list[str]]:
        """Return the sorted paths of the files of each fate."""
        return {fate: sorted(str(path) for path, its in self._fates.items() if its == fate) for fate in FATES}

    def lines(self) -> Iterator[str]:
        """Yield a line for each file, and how many there are."""
        files = self.by_fate()
        yield from (f"{fate:<8}{path}" for fate, paths in files.items() for path in paths)
        counts = ", ".join(f"{len(paths)} to {fate}" for fate, paths in files.items() if paths)
        yield f"a dry run: {counts or 'no files'}; nothing was changed"


_NOTES: ContextVar[Notes | None] = ContextVar("the notes of a dry run", default=None)


def notes() -> Notes | None:
    """Return the notes of the dry run that this is, None if it is none."""
    return _NOTES.get()


@contextmanager
def dry_run() -> Iterator[Notes]:
    """Let stores that are opened inside note the names of files, and write none."""
    noted = Notes()
    token = _NOTES.set(noted)
    try:
        with suppress(_Ended):
            yield noted
    finally:
        _NOTES.reset(token)


def foresee(folder: Path, names: Iterable[str], *, kept: Iterable[str] = (), is_whole: bool = False) -> None:
    """Note the files that will be put into a folder, and end it, in a dry run; else do nothing.

    kept: those that exist and stay; is_whole: whether they take the place of all that is in the folder
    """
    if (noted := notes()) is None:
        return
    stay = frozenset(kept)
    noted.put(folder, [name for name in names if name not in stay])
    noted.rest(folder, "remove" if is_whole else "keep")
    raise _Ended
