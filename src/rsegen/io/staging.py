"""Files are written in a hidden folder next to their place, then renamed: each appears whole or not at all.

    folder/.rsegen.0123abcd/new/NAME  --rename-->  folder/NAME
    folder/NAME, if it is replaced    --rename-->  folder/.rsegen.0123abcd/old/NAME, removed with the hidden folder

The hidden folder is locked while its run lives. The next run that writes there removes what a killed one left, and
puts back what that one was about to replace.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from rsegen.errors import REFUSED, OutputError, RsegenError, WriteError
from rsegen.io.record import WrittenFile
from rsegen.io.syncing import sync_folder, sync_tree

HIDDEN = re.compile(r"\.rsegen\.[0-9a-f]{8}")
"""The names of hidden folders."""


class Staging:
    """What is about to appear in a folder: files below `new`, what they replace below `old`."""

    def __init__(self, folder: Path, home: Path, *, sync: bool) -> None:
        self.folder: Path = folder
        self.new: Path = home / "new"
        self._old = home / "old"
        self._sync = sync
        for path in (self.new, self._old):
            path.mkdir()

    def write(self, name: str | PurePosixPath, content: Iterable[bytes]) -> WrittenFile:
        """Write one file below `new`, and the folders above it; an OutputError if its path leads out of it."""
        path = self.new / _inside(PurePosixPath(name))
        os.makedirs(path.parent, exist_ok=True)
        checksum = hashlib.sha256()
        with open(path, "wb") as file:
            for piece in content:
                checksum.update(piece)
                file.write(piece)
            return WrittenFile(bytes=file.tell(), sha256=checksum.hexdigest())

    def sync(self) -> None:
        """Wait until the disk has all that was written, unless nobody asked for it."""
        if self._sync:
            sync_tree(self.new)

    def move_in(self, name: str) -> None:
        """Put one file or folder in its place; what it replaces is removed at the end."""
        place = self.folder / name
        if place.is_dir():
            _rename(place, self._old / name)
        _rename(self.new / name, place)

    def keep(self, name: str) -> None:
        """Let `take_back` bring back a file that `move_in` replaces."""
        if (self.folder / name).is_file():
            try:
                os.link(self.folder / name, self._old / name)
            except OSError:  # a disk without hard links
                shutil.copyfile(self.folder / name, self._old / name)

    def take_back(self, name: str) -> None:
        """Undo `move_in`, if it was done: what was replaced is in its place again."""
        if not (self.new / name).exists():
            _rename(self.folder / name, self.new / name)
        if (self._old / name).exists():
            _rename(self._old / name, self.folder / name)

    def sync_names(self) -> None:
        """Wait until the disk has the new names, unless nobody asked for it."""
        if self._sync:
            sync_folder(self.folder)


@contextmanager
def staging(folder: Path, *, sync: bool = True, output: Path | None = None) -> Iterator[Staging]:
    """A hidden folder in `folder`, which is made if it does not exist; both are removed again if this fails.

    sync: wait until the disk has the files, before they get their names and after it; output: the path in messages,
    by default the folder. Raises an OutputError if the system allows no files there, WriteError if the disk fails.
    """
    with as_write_errors(output or folder), parents_made(folder / "any", sync=sync):
        home, lock = _made(folder)
        try:
            yield Staging(folder, home, sync=sync)
        finally:
            try:
                _remove(home, folder)
            except KeyboardInterrupt:  # the first is the last: stop.py ignores those that follow
                _remove(home, folder)
                raise
            finally:
                unlock(lock)


def remove_leftovers(folder: Path) -> None:
    """Remove what killed runs left half written in a folder; what they were about to replace comes back."""
    left: list[Path] = []
    with suppress(OSError), os.scandir(folder) as entries:
        left += [Path(entry) for entry in entries if HIDDEN.fullmatch(entry.name) and _is_folder(entry)]
    for home in left:
        lock = lock_folder(home, wait=False)
        if lock is not None:
            with as_write_errors(folder):
                _remove(home, folder)
            unlock(lock)


@contextmanager
def parents_made(folder: Path, *, sync: bool = True) -> Iterator[None]:
    """Make the folders above; if what is done in them fails, remove the new ones again."""
    if os.path.isdir(folder.parent):
        yield
        return
    missing = [above for above in folder.parents if not above.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        for above in missing if sync else ():
            sync_folder(above.parent)
        yield
    except BaseException:
        with suppress(OSError):  # it was not made, or has something else in it by now
            for above in missing:
                above.rmdir()
        raise


@contextmanager
def as_write_errors(folder: Path) -> Iterator[None]:
    """Turns errors of the system while `folder` is written into an OutputError or a WriteError of one line."""
    try:
        yield
    except RsegenError:
        raise
    except OSError as error:
        kind = OutputError if error.errno in REFUSED else WriteError
        raise kind(f"{folder}: cannot be written: {error.strerror or error}; nothing was left there") from error


def _inside(path: PurePosixPath) -> PurePosixPath:
    if path.is_absolute() or ".." in path.parts or not path.parts:
        raise OutputError(f"{path}: leaves the output folder")
    return path


def _is_folder(entry: os.DirEntry[str]) -> bool:
    return entry.is_dir(follow_symlinks=False)


def _made(folder: Path) -> tuple[Path, int]:
    """A new hidden folder and its lock; another run may take it for a left-over until it is locked."""
    while True:
        home = folder / f".rsegen.{secrets.token_hex(4)}"
        try:
            home.mkdir()
            lock = lock_folder(home, wait=True)
        except BaseException:
            shutil.rmtree(home, ignore_errors=True)
            raise
        if lock is not None and (lock < 0 or home.exists()):
            return home, lock
        unlock(lock)


def lock_folder(folder: Path, *, wait: bool) -> int | None:
    """A lock on a folder, which ends with this process; None if another run has it, -1 if the system has no locks."""
    if sys.platform == "win32":
        return -1
    import fcntl

    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        os.close(descriptor)
        return None
    except OSError:  # a disk of a network, without locks
        os.close(descriptor)
        return -1
    return descriptor


def unlock(lock: int | None) -> None:
    """End a lock of `lock_folder`."""
    if lock is not None and lock >= 0:
        os.close(lock)


def _rename(source: Path, place: Path) -> None:
    os.replace(source, place)


def _remove(home: Path, folder: Path) -> None:
    """Put back what was to be replaced and is missing now, and remove the hidden folder."""
    with suppress(FileNotFoundError):
        for old in (home / "old").iterdir():
            if not os.path.lexists(folder / old.name):
                _rename(old, folder / old.name)
    shutil.rmtree(home, ignore_errors=True)
