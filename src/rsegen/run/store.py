"""A folder that one run alone writes into: staged in a hidden folder, put in place in one swap, listed in a journal.


    DIR/.rsegen/lease-1      this run has the folder
    DIR/.rsegen/new/0a1b...  what is being written
    DIR/.rsegen/old/         what was replaced, where the disk cannot exchange two names at once
    DIR/.rsegen.next/        a data set or experiment that will replace DIR as a whole, once it is complete

What exists is replaced only if rsegen wrote it and it has not changed since; it is looked at before the swap, and once
more after it, when nobody else has it. If anything fails, what was swapped is swapped back. Cost: each file is read
once to be checked, if it is replaced, and waits for the disk unless --no-sync. What breaks it: a single file that
somebody changes in the milliseconds between check and swap, and a disk that reports as written what is not.
"""

from __future__ import annotations

import errno
import hashlib
import os
import secrets
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property, partial
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import ClassVar

from rsegen.errors import REFUSED, OutputError, RsegenError, Stopped, WriteError, shown
from rsegen.gazebo import Bundle
from rsegen.input_files import JOURNAL, Checksum, checksum_of
from rsegen.params.sorts import Json
from rsegen.run import dry
from rsegen.run.journal import (
    HIDDEN,
    Journal,
    OpenJournal,
    file_lines,
    first_line,
    is_empty,
    is_intact,
    read_journal,
    refuse_link,
    refuse_loss,
    refuse_loss_below,
)
from rsegen.run.lease import Lease, refuse_leased, take, wait_until_free
from rsegen.run.stop import held
from rsegen.run.swap import exchange, put, sync_folder, sync_trees

PATIENCE = 5.0
"""Seconds that the writer of a single file waits for another run in the same folder.

Another writer of single files is done in less; a long run is reported after it.
"""

NEXT = f"{HIDDEN}.next"
"""The folder in a folder in which what will replace it grows."""


def stage(root: Path, name: str | PurePosixPath, content: Iterable[bytes]) -> Checksum:
    """Write one file below a staged folder, and the folders above it; an OutputError if its path leads out of it."""
    relative = PurePosixPath(name)
    if relative.is_absolute() or ".." in relative.parts or not relative.parts:
        raise OutputError(f"{name}: leaves the output folder")
    path = root / relative
    os.makedirs(path.parent, exist_ok=True)
    checksum, size = hashlib.sha256(), 0
    with open(path, "wb") as file:
        for piece in content:
            checksum.update(piece)
            size += file.write(piece)
    return Checksum(bytes=size, sha256=checksum.hexdigest())


def stage_all(root: Path, bundle: Mapping[PurePosixPath, Iterable[bytes]]) -> dict[str, Checksum]:
    """Write the files of a bundle below a staged folder."""
    return {str(path): stage(root, path, content) for path, content in bundle.items()}


def stage_journal(root: Path, files: Mapping[str, Checksum], holds: str) -> None:
    """Write the journal of a staged folder that has these files."""
    stage(root, JOURNAL, [first_line(holds) + file_lines(files)])


def new_root(staging: Path) -> Path:
    """Return a new folder below the folder of staged files, which no other process has."""
    root = staging / secrets.token_hex(4)
    root.mkdir()
    return root


class Store:
    """A folder that this run alone writes into, until it is closed.

    Its journal lists the files that are put into the folder itself. A folder of maps has none: each map has its own.
    """

    _is_dry: ClassVar[bool] = False

    def __init__(self, folder: Path, *, sync: bool) -> None:
        self.folder: Path = folder
        self.home: Path = folder / HIDDEN
        self.staging: Path = self.home / "new"
        self.sync: bool = sync
        self.changed: bool = False
        self._lease: Lease | None = None

    @cached_property
    def journal(self) -> OpenJournal:
        """The journal of the folder."""
        return OpenJournal(self.folder, self.staging, sync=self.sync, is_dry=self._is_dry)

    def put_folder(self, root: Path, name: str, holds: str, *, force: bool) -> None:
        """Give a staged folder its name; an OutputError if that is taken and may not be replaced."""
        place = self.folder / name
        self._check_lease()
        with held():
            if not os.path.lexists(place):
                put(root, place)
            elif not force:
                raise taken(place)
            else:
                refuse_link(place)
                self._replace(root, place, holds)
            self.changed = True
        _remove(root)  # where the old one is now

    def put_complete(self, root: Path, files: Mapping[str, Checksum], name: str, holds: str, *, force: bool) -> None:
        """Give a staged folder a journal of its files, and its name, as `put_folder` does; the disk has all of it."""
        stage_journal(root, files, holds)
        if self.sync:
            sync_trees(root)
        self.put_folder(root, name, holds, force=force)
        self.sync_names()

    def _replace(self, root: Path, place: Path, holds: str) -> None:
        """Exchange a folder for a staged one; it is exchanged back if it holds anything that would be lost."""
        refuse_leased(place / HIDDEN)
        old = exchange(root, place, partial(self._aside, place))
        try:
            refuse_loss(old, holds, place)
        except BaseException:
            exchange(old, place, lambda: root)
            raise

    def put(
        self, bundle: Mapping[str, Iterable[bytes]], *, force: Collection[str] | bool = False, holds: str = "files"
    ) -> None:
        """Write files of the folder, with a journal: all of them, or none if that fails.

        force: the names of those that may be replaced, or all of them.
        """
        root = new_root(self.staging)
        files = stage_all(root, {PurePosixPath(path): content for path, content in bundle.items()})
        if self.sync:
            sync_trees(root)
        self.put_staged(root, files, force=force, holds=holds)

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

        below: a folder that has them, and a journal of its own; whole: folders that are replaced as one, whose files
        are all among them.
        """
        # A unit is a file, or a whole folder among them: each is swapped by itself, and swapped back if a later one
        # fails.
        folder = self.folder / below
        journal = OpenJournal(folder, self.staging, sync=self.sync) if below else self.journal
        units = dict.fromkeys(next((top for top in whole if name.startswith(f"{top}/")), name) for name in files)
        for name in units:
            if os.path.lexists(folder / name):
                refuse_unit(folder, name, journal.content, force=force, is_folder=name in whole)
        before = journal.content.files if journal.content else {}
        gone = {name for name in before if name.partition("/")[0] in whole} - files.keys()
        self._check_lease()
        if below:
            refuse_leased(folder / HIDDEN)
        with held():
            with journal.announced(files, holds), ExitStack() as undo:
                for name in units:
                    self._put_unit(root / name, folder / name, undo)
                undo.pop_all()
            self.changed = True
        if gone:
            journal.drop(gone)
        if below:
            journal.tidy()
        _remove(root)
        self._sync_folders((folder / name).parent for name in units)

    def _check_lease(self) -> None:
        if self._lease:
            self._lease.check()

    def _put_unit(self, new: Path, place: Path, undo: ExitStack) -> None:
        """Give a file or folder its name, or exchange it for what has it, and let `undo` take that back."""
        _make_folder(place.parent, undo)
        if os.path.lexists(place):
            old = exchange(new, place, partial(self._aside, place))
            undo.callback(exchange, old, place, lambda: new)
        else:
            put(new, place)
            undo.callback(os.rename, place, new)

    def foresee(self, names: Iterable[str], kept: Iterable[str] = ()) -> None:
        """End a dry run here, whose work would be long, with the names of the files to put and to keep."""

    def note(self, result: Mapping[str, Json]) -> None:
        """Append a result to the journal, which has begun."""
        self._check_lease()
        self.journal.note(result)
        self.changed = True

    def adopt(self, names: Iterable[str]) -> None:
        """List files that exist as if rsegen had written them: a person was asked whether they may be replaced."""
        checksums = {name: checksum_of(self.folder / name) for name in names}
        files = {name: checksum for name, checksum in checksums.items() if checksum}
        if files:
            with self.journal.announced(files):
                pass

    def sync_names(self) -> None:
        """Wait until the disk has the names of what was put in place, unless nobody asked for it."""
        self._sync_folders([self.folder])

    def _sync_folders(self, folders: Iterable[Path]) -> None:
        if self.sync:
            for folder in set(folders):
                sync_folder(folder)

    def _aside(self, place: Path) -> Path:
        """Return where something that is replaced lies meanwhile, on a disk that cannot exchange two names."""
        aside = self.home / "old" / secrets.token_hex(4) / place.relative_to(self.folder)
        aside.parent.mkdir(parents=True)
        return aside

    # Opening and closing.

    def _open(self, wait: float) -> None:
        refuse_link(self.home)
        while self._lease is None:
            self.home.mkdir(exist_ok=True)
            wait_until_free(self.home, wait)
            with held(), suppress(FileNotFoundError):  # the run that had it has just removed the hidden folder
                self._lease = take(self.home)
        # What a killed run had moved aside and not yet replaced is put back, and what it had staged is removed.
        for aside in (self.home / "old").glob("*"):
            _put_back(aside, self.folder)
        for path in (self.staging, self.home / "old"):
            _remove(path)
            if path.exists():
                raise WriteError(f"{self.home}: what a killed run left there cannot be removed")
        self.staging.mkdir()

    def _close(self) -> None:
        """Remove the hidden folder; a kill in the middle of that leaves nothing of weight."""
        try:
            if "journal" in vars(self):
                (self.journal.tidy if self.changed else self.journal.forget)()
            for path in (self.staging, self.home / "old") if self._lease else ():
                _remove(path)
        finally:
            if self._lease:
                self._lease.release()
            _remove_empty(self.home)


class _DryStore(Store):
    """A store of a dry run: it notes the names of files, and stages in a temporary folder what is made before it.

    is_whole: whether its files take the place of all that is in the folder
    """

    _is_dry: ClassVar[bool] = True

    def __init__(self, folder: Path, noted: dry.Notes, staging: Path, *, is_whole: bool = False) -> None:
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
        for name in bundle if not self._is_whole else ():
            if os.path.lexists(self.folder / name):
                refuse_unit(self.folder, name, self.journal.content, force=force, is_folder=False)
        (self._noted.put_whole if self._is_whole else self._noted.put)(self.folder, bundle)

    def foresee(self, names: Iterable[str], kept: Iterable[str] = ()) -> None:
        """Note these files, and end the dry run."""
        dry.foresee(self.folder, names, kept=kept, is_whole=self._is_whole)


@contextmanager
def _dry_store(
    folder: Path, noted: dry.Notes, *, output: Path | None = None, is_whole: bool = False
) -> Iterator[Store]:
    above = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        problem = f"{above} is {'read-only' if above.is_dir() else 'a file'}"
        raise OutputError(f"{output or folder}: cannot be written: {problem}")
    with TemporaryDirectory(prefix="rsegen-") as staging:
        yield _DryStore(folder, noted, Path(staging), is_whole=is_whole)


def _put_back(aside: Path, place: Path) -> None:
    """Move everything below a folder to the same path below another, unless it is there."""
    for path in aside.iterdir():
        if not os.path.lexists(place / path.name):
            os.rename(path, place / path.name)
        elif path.is_dir() and not path.is_symlink() and (place / path.name).is_dir():
            _put_back(path, place / path.name)


def refuse_unit(
    folder: Path, name: str, journal: Journal | None, *, force: Collection[str] | bool, is_folder: bool
) -> None:
    """Raise an OutputError if a file or folder that exists must not be replaced."""
    _refuse_kept(folder / name, force=force if isinstance(force, bool) else name in force, is_folder=is_folder)
    if is_folder:
        refuse_loss_below(folder, name, journal)
    else:
        is_intact(folder, name, journal)


def _refuse_kept(place: Path, *, force: bool, is_folder: bool = False) -> None:
    """Raise an OutputError if what exists at a path is a link, of another kind, or not to be replaced."""
    refuse_link(place)
    if not (place.is_dir() if is_folder else place.is_file()):
        kind = "folder" if is_folder else "file"
        raise OutputError(f"{place}: exists already and is not a {kind}; give another name")
    if not force:
        raise taken(place)


def taken(place: Path) -> OutputError:
    """Return the error of a name that exists already."""
    what = "another folder or name" if place.is_dir() else "another name"
    return OutputError(f"{place}: exists already; give force=True to replace it, or {what}")


def _make_folder(folder: Path, undo: ExitStack) -> None:
    if not folder.is_dir():
        if os.path.lexists(folder):
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
        _make_folder(folder.parent, undo)
        folder.mkdir()
        undo.callback(_remove_empty, folder)


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):  # somebody has put something into it
        folder.rmdir()


def _remove(path: Path) -> None:
    """Remove a file or folder of the hidden folder; twice, as the first time an error may interrupt it."""
    for _ in range(2):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        elif path.exists():
            with suppress(OSError):
                path.unlink()


@contextmanager
def open_store(folder: Path, *, sync: bool = True, wait: float = 0.0, output: Path | None = None) -> Iterator[Store]:
    """Open a folder to write into it, which is made if it does not exist.

    sync: wait until the disk has the files, before they get their names and after it; wait: seconds to wait for another
    run; output: the path in messages, by default the folder. Raises an OutputError if another run is writing there, or
    if nothing may be written there; a WriteError if the disk failed after something was written.
    """
    if noted := dry.notes():
        with _dry_store(folder, noted, output=output) as store:
            yield store
        return
    store = Store(folder, sync=sync)
    with _as_our_errors(store, output or folder), ExitStack() as undo:
        _make_folder(folder, undo)
        try:
            store._open(wait)
            yield store
        finally:
            store._close()
            if store.changed or (folder.is_dir() and any(folder.iterdir())):
                undo.pop_all()


@contextmanager
def _as_our_errors(store: Store, output: Path) -> Iterator[None]:
    """Turn errors of the system into an OutputError, or into a WriteError if anything was written before."""
    try:
        yield
    except (RsegenError, Stopped):
        raise
    except KeyboardInterrupt:
        left = f"what is complete in {output} stays" if store.changed else f"nothing was changed in {output}"
        raise Stopped(left, changed=store.changed) from None
    except OSError as error:
        refused = error.errno in REFUSED and not store.changed
        kind, left = (OutputError if refused else WriteError), "" if store.changed else "; nothing was changed"
        raise kind(f"{output}: cannot be written: {error.strerror or error}{left}") from error


@contextmanager
def unchanged_if_stopped(output: str | Path | None) -> Iterator[None]:
    """Add to a Ctrl-C inside, before anything is written, that the output is as it was; with no output nothing."""
    try:
        yield
    except KeyboardInterrupt:
        if output is None:
            raise
        raise Stopped(f"nothing was changed in {output}", changed=False) from None


@contextmanager
def replacing(folder: Path, holds: str, of: Json, *, sync: bool = True) -> Iterator[Store]:
    """Open a store in `folder/.rsegen.next` that replaces the whole folder at the end, in one swap.

    If the run is stopped, the folder is as it was, and the same call goes on with what is there. Whether it may be
    replaced is checked before by `refuse_irreplaceable`, which reads all of it, and once more at the swap.
    """
    if noted := dry.notes():
        with _dry_store(folder, noted, is_whole=True) as store:
            yield store
        return
    with open_store(folder, sync=sync):  # the old folder is leased too, so that no other run changes it meanwhile
        begun = folder / NEXT
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
    except (OutputError, WriteError, OSError) as error:
        problem = f"not replaced yet: {error}; the new one is complete, and the same command puts it in place"
        raise WriteError(f"{folder}: {problem}") from error


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
            if not begun.exists() and root.exists():
                os.rename(root, begun)
            raise
        above.sync_names()


def refuse_irreplaceable(folder: Path, holds: str) -> None:
    """Raise an OutputError if a folder may not be replaced as a whole, or cannot be."""
    refuse_leased(folder / HIDDEN)
    real = folder.resolve()
    refuse_loss(real, holds, folder)
    if real.is_mount() or not os.access(real.parent, os.W_OK):
        problem = "cannot be replaced in one step, as it is a disk of its own, or the folder above is read-only"
        raise OutputError(f"{folder}: {problem}; give another folder")


# Checks before a run, and single files.


def refuse_not_a_folder(folder: Path) -> None:
    """Raise an OutputError if the path is something else than a folder, or if no folder can have that name."""
    try:
        is_taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        name = str(folder) if isinstance(error, OSError) else shown(str(folder))
        raise OutputError(f"{name}: {getattr(error, 'strerror', error)}") from None
    if is_taken:
        raise OutputError(f"{folder}: is a file; give a folder")


def refuse_busy(folder: Path) -> None:
    """Raise an OutputError if the path is no folder, or another run is writing into it."""
    refuse_not_a_folder(folder)
    refuse_leased(folder / HIDDEN)


def refuse_taken(folders: Iterable[str | Path], *, force: bool, holds: str = "map") -> None:
    """Raise an OutputError for the first folder that exists, or that even `force` does not replace."""
    for folder in map(Path, filter(os.path.lexists, folders)):
        if not force:
            raise taken(folder)
        refuse_loss(folder, holds)


def refuse_taken_file(path: Path, *, force: bool) -> None:
    """Raise an OutputError if a path exists, unless it is a file that rsegen wrote and `force` is given."""
    if os.path.lexists(path):
        _refuse_kept(path, force=force)
        is_intact(path.parent, path.name, read_journal(path.parent))


def write_folder(
    bundle: Bundle, folder: Path, holds: str = "map", *, force: bool = False, sync: bool = True
) -> tuple[str, ...]:
    """Write every file of a bundle into a new folder, in one swap; return their names in it, sorted as paths are."""
    with open_store(folder.parent, sync=sync, wait=PATIENCE, output=folder) as store:
        root = new_root(store.staging)
        store.put_complete(root, stage_all(root, bundle), folder.name, holds, force=force)
    return sorted_names(bundle)


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False, confirmed: bool = False) -> None:
    """Write one file, whole or not at all; an OutputError if it exists already.

    force: replace it if rsegen wrote it and it is unchanged; confirmed: whoever wrote it, as a person has just been
    asked about this very file.
    """
    with open_store(path.parent, wait=PATIENCE, output=path) as store:
        if confirmed:
            store.adopt([path.name])
        store.put({path.name: content}, force=force or confirmed)


def write_paths(contents: Mapping[Path, bytes], *, force: bool = False) -> None:
    """Write files anywhere: all files of a folder, or none of them."""
    for path in contents:
        refuse_taken_file(path, force=force)
    for folder in dict.fromkeys(path.parent for path in contents):
        paths = [path for path in contents if path.parent == folder]
        with open_store(folder, wait=PATIENCE, output=paths[0]) as store:
            store.put({path.name: [contents[path]] for path in paths}, force=force)


def sorted_names(paths: Iterable[PurePosixPath]) -> tuple[str, ...]:
    """Return paths as texts, sorted as paths are."""
    return tuple(map(str, sorted(paths)))
