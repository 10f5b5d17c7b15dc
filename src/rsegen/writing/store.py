"""A folder that one run alone writes into: staged in a hidden folder, put in place in one swap, listed in a journal.

    DIR/.rsegen/lock         this run has the folder
    DIR/.rsegen/new/0a1b...  what is being written
    DIR/.rsegen/old/1/NAME   what is being replaced, between two renames on a disk that cannot exchange two names
    DIR/.rsegen.next/        a data set or experiment that will replace DIR as a whole, once it is complete

What exists is replaced only if rsegen wrote it and it has not changed since; it is looked at before the swap, and once
more after it, when nobody else has it. If anything fails, what was swapped is swapped back. A single file is replaced
because a person said so, and leaves nothing next to it. docs/engine.md draws what a kill leaves, and who removes it.
Cost: each file is read once to be checked, if it is replaced, and waits for the disk unless --no-sync. What breaks it:
a file that somebody changes in the milliseconds between check and swap, and a disk that reports as written what is not.
"""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from contextvars import ContextVar
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from rsegen.errors import REFUSED, OutputError, RsegenError, Stopped, Stuck, WriteError, shown, system_reason
from rsegen.gazebo import Bundle
from rsegen.input_files import JOURNAL, Checksum
from rsegen.params.sorts import Json
from rsegen.writing.journal import (
    HIDDEN,
    Journal,
    OpenJournal,
    asides,
    is_empty,
    is_intact,
    journal_text,
    kept,
    read_errors,
    read_journal,
    refuse_link,
    refuse_loss,
    refuse_loss_below,
)
from rsegen.writing.lock import Lock, refuse_locked
from rsegen.writing.stop import held
from rsegen.writing.swap import sync, sync_trees
from rsegen.writing.undo import Swaps, make_folder, remove_empty

if TYPE_CHECKING:
    from rsegen.writing.dry import Notes

PATIENCE = 5.0
"""Seconds that the writer of a single file waits for another run in the same folder.

Another writer of single files is done in less; a long run is reported after it.
"""

NEXT = f"{HIDDEN}.next"
"""The folder in a folder in which what will replace it grows."""

NOTES: ContextVar[Notes | None] = ContextVar("the notes of a dry run (dry.py), None in a run that writes", default=None)


def stage_all(root: Path, bundle: Mapping[PurePosixPath, Iterable[bytes]]) -> dict[str, Checksum]:
    """Write the files of a bundle below a staged folder; an OutputError if a path leads out of it."""
    checksums = {}
    for name, content in bundle.items():
        if name.is_absolute() or ".." in name.parts or not name.parts:
            raise OutputError(f"{name}: leaves the output folder")
        path = root / name
        os.makedirs(path.parent, exist_ok=True)
        digest, size = hashlib.sha256(), 0
        with open(path, "wb") as file:
            for piece in content:
                digest.update(piece)
                size += file.write(piece)
        checksums[str(name)] = Checksum(bytes=size, sha256=digest.hexdigest())
    return checksums


def new_root(staging: Path) -> Path:
    """Return a new folder below the folder of staged files, which no other process has."""
    root = staging / secrets.token_hex(4)
    root.mkdir()
    return root


class Store:
    """A folder that this run alone writes into, until it is closed.

    Its journal lists the files that are put into the folder itself. A folder of maps has none: each map has its own.
    """

    def __init__(self, folder: Path, *, sync: bool) -> None:
        self.folder: Path = folder
        self.home: Path = folder / HIDDEN
        self.lock: Lock = Lock(folder, self.home)
        self.staging: Path = self.home / "new"
        self.sync: bool = sync
        self.is_done: bool = False
        self.swaps: Swaps = Swaps(folder)
        self._renamed_in: set[Path] = set()

    @cached_property
    def journal(self) -> OpenJournal:
        """The journal of the folder."""
        return OpenJournal(self.folder, self.staging, sync=self.sync)

    # Whole folders, each with its own journal.

    def put_folder(self, root: Path, name: str, holds: str, *, force: bool) -> None:
        """Give a staged folder its name; an OutputError if that is taken and may not be replaced."""
        place = self.folder / name
        self.lock.check()
        if replaces := os.path.lexists(place):
            if not force:
                raise taken(place)
            refuse_link(place)
            refuse_locked(place)
        with held(), self.swaps.all_or_none() as undo:
            self.swaps.swap(root, place, undo, replaces=replaces)
            if replaces:
                self.swaps.refuse_loss(root, holds, place, undo)
        self._renamed_in.add(self.folder)
        _remove(root)  # where the old one is now

    def put_complete(self, root: Path, files: Mapping[str, Checksum], name: str, holds: str, *, force: bool) -> None:
        """Give a staged folder a journal of its files, and its name, as `put_folder` does; the disk has all of it."""
        stage_all(root, {PurePosixPath(JOURNAL): [journal_text(holds, files)]})
        if self.sync:
            sync_trees(root)
        self.put_folder(root, name, holds, force=force)
        self.sync_names()

    # Files of the folder, which its journal lists.

    def put(
        self, bundle: Mapping[str, Iterable[bytes]], *, force: Collection[str] | bool = False, holds: str = "files"
    ) -> None:
        """Write files of the folder: all of them, or none if that fails.

        force: the names of those that may be replaced, or all of them
        holds: what the folder is, as its journal says; none is begun for single files, `""`, which `force` replaces
        whoever wrote them
        """
        root = new_root(self.staging)
        files = stage_all(root, {PurePosixPath(path): content for path, content in bundle.items()})
        if self.sync:
            sync_trees(root)
        self.put_staged(root, files, force=force, holds=holds)
        self.sync_names()

    def put_staged(
        self,
        root: Path,
        files: Mapping[str, Checksum],
        *,
        below: str = "",
        force: Collection[str] | bool = False,
        whole: Collection[str] = (),
        holds: str = "files",
    ) -> None:
        """Give staged files their names, as `put` does.

        below: a folder that has them, and its own journal; whole: folders that are replaced as one, whose files
        are all among them.
        """
        # 1. What may be replaced? A unit is a file, or a whole folder among them: each is swapped by itself, and
        # swapped back if a later one fails.
        folder = self.folder / below
        journal = OpenJournal(folder, self.staging, sync=self.sync) if below else self.journal
        units = dict.fromkeys(next((top for top in whole if name.startswith(f"{top}/")), name) for name in files)
        existing = {name for name in units if os.path.lexists(folder / name)}
        for name in existing:
            refuse_unit(folder, name, journal.content, force=force, is_folder=name in whole, is_single=not holds)
        before = journal.content.files if journal.content else {}
        gone = {name for name in before if name.partition("/")[0] in whole} - files.keys()
        self.lock.check()
        if below:
            refuse_locked(folder)
        # 2. The journal first, so that after a kill each file, old or new, is known as rsegen's; then the swaps.
        listed = journal.announced(files, holds) if holds or journal.content else nullcontext()
        with held(), listed, self.swaps.all_or_none() as undo:
            for name in units:
                self.swaps.swap(root / name, folder / name, undo, replaces=name in existing)
        # 3. Names that went with a replaced folder leave the journal; until then they are only missing.
        if gone:
            journal.drop(gone)
        if below:
            journal.tidy()
        self._renamed_in |= {(folder / name).parent for name in units}
        _remove(root)

    def tidy(self, names: Iterable[str]) -> None:
        """Tidy the journals of folders that are complete, as a run that was stopped may not have; not of busy ones."""
        for folder in (self.folder / name for name in names):
            with suppress(OutputError):
                refuse_locked(folder)
                OpenJournal(folder, self.staging, sync=self.sync).tidy()

    def announce_files(self, names: Iterable[str], kept: Iterable[str] = ()) -> None:
        """End a dry run here, whose work would be long, with the names of the files to put and to keep."""

    def note(self, result: Mapping[str, Json]) -> None:
        """Append a result to the journal, which has begun."""
        self.lock.check()
        self.journal.note(result)
        self.swaps.changed = True

    def sync_names(self) -> None:
        """Wait until the disk has the names of what was put in place, unless nobody asked for it."""
        for folder in self._renamed_in if self.sync else ():
            sync(folder)
        self._renamed_in.clear()

    def clear(self) -> None:
        """Empty the hidden folder: what belongs to a place is put back, all else is removed."""
        self.swaps.put_back()
        for path in (self.staging, self.home / "old"):
            _remove(path)


def refuse_unit(
    folder: Path,
    name: str,
    journal: Journal | None,
    *,
    force: Collection[str] | bool,
    is_folder: bool = False,
    is_single: bool = False,
) -> None:
    """Raise an OutputError if what has the name of a file or folder must not be replaced.

    That is: a link, something of another kind, without `force` anything, and what rsegen did not write or somebody has
    changed since. A single file is replaced by `force` alone.
    """
    place = folder / name
    if not os.path.lexists(place):
        return
    refuse_link(place)
    if not (place.is_dir() if is_folder else place.is_file()):
        kind = "folder" if is_folder else "file"
        raise OutputError(f"{place}: exists already and is not a {kind}; use another name")
    if not (force if isinstance(force, bool) else name in force):
        raise taken(place)
    if is_folder:
        refuse_loss_below(folder, name, journal)
    elif not is_single:
        is_intact(folder, name, journal)


def refuse_taken_file(path: Path, *, force: bool) -> None:
    """Raise an OutputError if a single file exists, unless it is a file and `force` is given."""
    refuse_unit(path.parent, path.name, None, force=force, is_single=True)


def taken(place: Path) -> OutputError:
    """Return the error of a name that exists already."""
    instead = "another folder or name" if place.is_dir() else "another name"
    return OutputError(f"{place}: exists already; use force=True to replace it, or {instead}")


def _remove(folder: Path) -> None:
    """Remove a folder of the hidden folder; twice, as the first time an error may interrupt it."""
    for _ in range(2):
        if folder.exists():
            shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def open_store(folder: Path, *, sync: bool = True, wait: float = 0.0, output: Path | None = None) -> Iterator[Store]:
    """Open a folder to write into it, which is made if it does not exist.

    sync: wait until the disk has the files, before they get their names and after it; wait: seconds to wait for another
    run; output: the path in messages, by default the folder. Raises an OutputError if another run is writing there, or
    if nothing may be written there; a WriteError if the disk failed after something was written.
    """
    if noted := NOTES.get():
        with noted.store(folder, output=output) as store:
            yield store
        return
    store = Store(folder, sync=sync)
    is_hidden_new = not os.path.lexists(store.home)
    try:
        with ExitStack() as undo:  # removes the folder again if nothing was written into it
            make_folder(folder, undo)
            refuse_link(store.home)
            try:
                store.lock.take(wait)
                store.clear()  # what killed runs have left: put back, or removed
                store.staging.mkdir()
                yield store
                store.is_done = True
            finally:
                _close(store)
                if store.swaps.changed or any(folder.iterdir()):
                    undo.pop_all()
    except (RsegenError, Stopped):
        raise
    except KeyboardInterrupt:
        place = output or folder
        left = f"what is complete in {place} stays" if store.swaps.changed else f"nothing was changed in {place}"
        raise Stopped(left, changed=store.swaps.changed) from None
    except OSError as error:
        raise _write_error(store, output or folder, error, is_hidden_new=is_hidden_new) from error


def _write_error(store: Store, what: Path, error: OSError, *, is_hidden_new: bool) -> RsegenError:
    """Return the error of a system's error, which says what is left; an OutputError if nothing is."""
    problem = f"{what}: cannot be written: {system_reason(error)}"
    if words := store.swaps.words():
        return Stuck(f"{problem}{words}")
    if is_hidden_new and os.path.lexists(store.home):
        return WriteError(f"{problem}; unfinished files lie in {store.home}, and the next run removes them")
    if store.swaps.changed:
        return WriteError(problem)
    return (OutputError if error.errno in REFUSED else WriteError)(f"{problem}; nothing was changed")


def _close(store: Store) -> None:
    """Remove the hidden folder; a kill in the middle of that leaves nothing of weight."""
    try:
        # Also if the run that was stopped had made all of it, and this one nothing.
        if (store.swaps.changed or store.is_done) and "journal" in vars(store):
            store.journal.tidy()
        if store.lock.is_taken and not store.swaps.stuck:
            store.clear()
    finally:
        store.lock.release()
        remove_empty(store.home)


@contextmanager
def unchanged_if_stopped(output: str | Path | None) -> Iterator[None]:
    """Add to a Ctrl-C inside, before anything is written, that the output is as it was; with no output nothing."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        if output is None:
            raise
        done = f"{stopped}; " if isinstance(stopped, Stopped) else ""
        raise Stopped(f"{done}nothing was changed in {output}", changed=False) from None


@contextmanager
def replacing(folder: Path, holds: str, of: Json, *, sync: bool = True) -> Iterator[Store]:
    """Open a store in `folder/.rsegen.next` that replaces the whole folder at the end, in one swap.

    If the run is stopped, the folder is as it was, and the same call goes on with what is there. Whether it may be
    replaced is checked before by `refuse_irreplaceable`, which reads all of it, and once more at the swap.
    """
    if noted := NOTES.get():
        with noted.store(folder, is_whole=True) as store:
            yield store
        return
    above = folder.resolve().parent
    if any(place.name == NEXT for _, place in kept(above)):
        with open_store(above, sync=sync, wait=PATIENCE):
            pass  # it moves back what a run before has made, and could not put in place
    with open_store(folder, sync=sync):  # the old folder is locked too, so that no other run changes it meanwhile
        begun = folder / NEXT
        # What a stopped run has made goes on if it is of the same values; a half result of others is removed.
        if not is_empty(begun):
            refuse_loss(begun, holds)
            journal = read_journal(begun)
            if journal is None or journal.of != of:
                _remove(begun)
        with open_store(begun, sync=sync) as store:
            store.journal.begin(holds, of)
            yield store
    try:
        _replace_whole(folder, holds, sync=sync)
    except Stuck:
        raise
    except (OutputError, WriteError, OSError) as error:
        problem = f"not replaced yet: {error}; the new one is complete, and the same command puts it in place"
        raise WriteError(f"{folder}: {problem}") from error


@contextmanager
def continued(  # what it holds, what of, and what may be done with another one
    folder: Path, holds: str, of: Json, names: Iterable[str], *, force: bool, other: str
) -> Iterator[Store]:
    """Open the folder of a long result, which goes on if it has begun; with `force` the store of what replaces it.

    names: of its files, which must be as rsegen wrote them; other: what a folder has that holds a result of other
    values, and advice. Raises an OutputError for such a folder, for other files, and if another run is writing there.
    """
    # Three cases: replace another result, refuse other files, or go on with what was begun.
    put_back_whole(folder)
    refuse_busy(folder)
    journal = read_journal(folder)
    if force and journal:
        refuse_irreplaceable(folder, holds)
        with replacing(folder, holds, of) as store:
            yield store
        return
    if journal and (journal.holds, journal.of) != (holds, of):
        has = other if journal.holds == holds else "other files of rsegen; use another folder"
        raise OutputError(f"{folder}: has {has}")
    with read_errors(folder):
        for name in names:
            is_intact(folder, name, journal)
    with open_store(folder) as store:
        store.journal.begin(holds, of)
        yield store


def put_back_whole(folder: Path) -> None:
    """Put back a folder that a killed run moved aside to replace it as a whole: else a run would take it for a new one.

    Only a disk that cannot exchange two names has such a folder. Nothing is written in a dry run.
    """
    real = folder.resolve()
    if NOTES.get() or os.path.lexists(real) or all(place != real for _, place in asides(real.parent)):
        return
    with open_store(real.parent, wait=PATIENCE, output=folder):
        pass  # that puts it back


def _replace_whole(folder: Path, holds: str, *, sync: bool) -> None:
    """Exchange a folder for the complete one in its `.rsegen.next`."""
    real = folder.resolve()
    begun = real / NEXT
    with open_store(real.parent, sync=sync, wait=PATIENCE, output=folder) as above:
        root = above.staging / real.name
        os.rename(begun, root)
        try:
            above.put_folder(root, real.name, holds, force=True)
        except BaseException:
            if root.exists() and not (real in above.swaps.stuck and real.exists()):  # else the old one is there
                above.swaps.move_back(root, begun)
            raise
        above.sync_names()


def refuse_irreplaceable(folder: Path, holds: str) -> None:
    """Raise an OutputError if a folder may not be replaced as a whole, or cannot be."""
    refuse_locked(folder)
    real = folder.resolve()
    refuse_loss(real, holds, folder)
    if real.is_mount() or not os.access(real.parent, os.W_OK):
        problem = "cannot be replaced in one step, as it is a separate disk, or the folder above is read-only"
        raise OutputError(f"{folder}: {problem}; use another folder")


# Checks before a run, and single files.


def refuse_busy(folder: Path) -> None:
    """Raise an OutputError if a path is no folder and cannot be one, or if another run writes into it."""
    try:
        is_taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        name = str(folder) if isinstance(error, OSError) else shown(str(folder))
        raise OutputError(f"{name}: {getattr(error, 'strerror', error)}") from None
    if is_taken:
        raise OutputError(f"{folder}: is a file; use a folder")
    refuse_locked(folder)


def refuse_taken(folders: Iterable[str | Path], *, force: bool, holds: str = "map") -> None:
    """Raise an OutputError for the first folder that exists, or that even `force` does not replace."""
    for folder in map(Path, filter(os.path.lexists, folders)):
        if not force:
            raise taken(folder)
        refuse_loss(folder, holds)


def write_folder(
    bundle: Bundle, folder: Path, holds: str = "map", *, force: bool = False, sync: bool = True
) -> tuple[str, ...]:
    """Write every file of a bundle into a new folder, in one swap; return their names in it, sorted as paths are."""
    with open_store(folder.parent, sync=sync, wait=PATIENCE, output=folder) as store:
        root = new_root(store.staging)
        store.put_complete(root, stage_all(root, bundle), folder.name, holds, force=force)
    return sorted_names(bundle)


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False) -> None:
    """Write one file, whole or not at all; an OutputError if it exists already, unless `force`."""
    write_files({path: content}, force=force)


def write_files(contents: Mapping[Path, Iterable[bytes]], *, force: bool = False) -> None:
    """Write single files anywhere: all files of a folder, or none of them."""
    for path in contents:
        refuse_taken_file(path, force=force)
    for folder in dict.fromkeys(path.parent for path in contents):
        paths = [path for path in contents if path.parent == folder]
        with open_store(folder, wait=PATIENCE, output=paths[0]) as store:
            store.put({path.name: contents[path] for path in paths}, force=force, holds="")


def sorted_names(paths: Iterable[PurePosixPath]) -> tuple[str, ...]:
    """Return paths as texts, sorted as paths are."""
    return tuple(map(str, sorted(paths)))
