"""A dry run: the names of the files that a run would write, replace, remove and keep; nothing on the disk is changed.

    with dry_run() as notes:
        command()           every store that is opened inside (store.py) notes names in place of writing

All that refuses a run refuses its dry run. Files of maps are named by what makes them, so the names are right by
construction; a run whose work is long, such as trials or shards, names its files beforehand (`announce_files`), and
ends.
What breaks it: a file that is put on the disk by anything but a store.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from rsegen.errors import OutputError
from rsegen.input_files import JOURNAL
from rsegen.writing.store import NOTES, Store, refuse_taken, refuse_unit
from rsegen.writing.undo import refuse_dangling

FATES = ("write", "replace", "remove", "keep")


class _Ended(Exception):  # no error: a dry run has noted all that it can
    """The end of a dry run whose work would be long."""


class Notes:
    """Notes of a dry run: the fate of each file."""

    def __init__(self) -> None:
        self._fates: dict[Path, str] = {}

    def put(self, folder: Path, names: Iterable[str], *, is_listed: bool = True) -> None:
        """Note files that are put into a folder, and the journal that will list them."""
        for name in dict.fromkeys((*names, *([JOURNAL] if is_listed else []))):
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

    @contextmanager
    def store(self, folder: Path, *, output: Path | None = None, is_whole: bool = False) -> Iterator[Store]:
        """Open a folder whose files are noted; an OutputError, about `output`, if nothing may be written there."""
        above = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
        refuse_dangling(above)
        if not above.is_dir() or not os.access(above, os.W_OK):
            problem = f"{above} is {'read-only' if above.is_dir() else 'a file'}"
            raise OutputError(f"{output or folder}: cannot be written: {problem}")
        with TemporaryDirectory(prefix="rsegen-") as staging:
            yield _DryStore(folder, self, Path(staging), is_whole=is_whole)

    def by_fate(self) -> Mapping[str, list[str]]:
        """Return the sorted paths of the files of each fate."""
        return {fate: sorted(str(path) for path, its in self._fates.items() if its == fate) for fate in FATES}

    def lines(self) -> Iterator[str]:
        """Yield a line for each file, and how many there are."""
        files = self.by_fate()
        yield from (f"{fate:<8}{path}" for fate, paths in files.items() for path in paths)
        counts = ", ".join(f"{len(paths)} to {fate}" for fate, paths in files.items() if paths)
        yield f"a dry run: {counts or 'no files'}; nothing was changed"


@contextmanager
def dry_run() -> Iterator[Notes]:
    """Let stores that are opened inside note the names of files, and write none."""
    noted = Notes()
    token = NOTES.set(noted)
    try:
        with suppress(_Ended):
            yield noted
    finally:
        NOTES.reset(token)


class _DryStore(Store):
    """A store of a dry run: it notes the names of files, and stages in a temporary folder what is made before it.

    is_whole: whether its files take the place of all that is in the folder
    """

    def __init__(self, folder: Path, noted: Notes, staging: Path, *, is_whole: bool) -> None:
        super().__init__(folder, sync=False)
        self.staging = staging
        self._noted, self._is_whole = noted, is_whole

    def put_folder(self, root: Path, name: str, holds: str, *, force: bool) -> None:
        """Note the files of a folder."""
        refuse_taken([self.folder / name], force=force, holds=holds)
        files = (path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file())
        self._noted.put_whole(self.folder / name, files)

    def put(
        self, bundle: Mapping[str, Iterable[bytes]], *, force: Collection[str] | bool = False, holds: str = "files"
    ) -> None:
        """Note files of the folder."""
        if self._is_whole:
            self._noted.put_whole(self.folder, bundle)
            return
        journal = self.journal.content
        for name in bundle:
            refuse_unit(self.folder, name, journal, force=force, is_single=not holds)
        self._noted.put(self.folder, bundle, is_listed=bool(holds or journal))

    def announce_files(self, names: Iterable[str], kept: Iterable[str] = ()) -> None:
        """Note these files, and end the dry run."""
        announce_files(self.folder, names, kept=kept, is_whole=self._is_whole)


def announce_files(folder: Path, names: Iterable[str], *, kept: Iterable[str] = (), is_whole: bool = False) -> None:
    """Note the files that will be put into a folder, and end it, in a dry run; else do nothing.

    kept: those that exist and stay; is_whole: whether they take the place of all that is in the folder
    """
    if (noted := NOTES.get()) is None:
        return
    stay = frozenset(kept)
    if new := [name for name in names if name not in stay]:
        noted.put(folder, new)
    noted.rest(folder, "remove" if is_whole else "keep")
    raise _Ended
