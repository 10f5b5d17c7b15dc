"""Swaps that belong together: all are made, or all are taken back; what cannot be taken back is named.

A disk whose rename fails may fail again when the renames before it are taken back. Then some places have the new file
or folder already, or, on a disk that cannot exchange two names, nothing: the old one lies aside. Nothing is removed
then. The journal keeps the lines of the new files, so the next run knows them as rsegen's, replaces or completes them,
and puts back what lies aside. Only two things could be lost by that, and DIR/.rsegen/kept says where they lie:

    a folder that somebody changed in the moment of the swap    the next run is refused until it is moved away
    a data set that is complete, but not in its place           the next run moves it there

What breaks it: a disk that does not even take this file, in these two cases.
"""

from __future__ import annotations

import errno
import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.writing.journal import HIDDEN, KEPT, asides, kept, refuse_loss
from rsegen.writing.swap import NotPutBack, exchange, put


class Swaps:
    """The swaps of a folder; `changed`: whether any stays; `stuck`: the places at which one could not be taken back."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._home = folder, folder / HIDDEN
        self.changed = False
        self.stuck: dict[Path, str] = {}

    @contextmanager
    def all_or_none(self) -> Iterator[ExitStack]:
        """Take back the swaps made inside if anything fails there; a NotPutBack if that fails too."""
        before = len(self.stuck)
        try:
            with ExitStack() as undo:
                yield undo
                undo.pop_all()
        except Exception as error:
            if len(self.stuck) == before:
                raise
            self.changed = True
            code, why = (error.errno, error.strerror) if isinstance(error, OSError) else (errno.EIO, str(error))
            raise NotPutBack(code, why) from error
        self.changed = True

    def swap(self, new: Path, place: Path, undo: ExitStack, *, replaces: bool) -> None:
        """Give a file or folder its name, or exchange it for what has it, and let `undo` take that back."""
        make_folder(place.parent, undo)
        if replaces:
            self._exchange(new, place)
            undo.callback(self._take_back, self._exchange, new, place)
        else:
            put(new, place)
            undo.callback(self._take_back, lambda new, place: os.rename(place, new), new, place)

    def refuse_loss(self, old: Path, holds: str, place: Path, undo: ExitStack) -> None:
        """Look at a replaced folder once more, as nobody else has it now; as `refuse_loss` of the journal.

        If somebody has changed it, and it cannot be put back, it is kept.
        """
        try:
            refuse_loss(old, holds, place)
        except BaseException:
            undo.close()
            if place in self.stuck:
                self.keep(old, place, f"the one that was changed lies in {old}; move it away")
            raise

    def keep(self, lies: Path, place: Path, words: str) -> None:
        """Say, in messages and to the next run, that something in the hidden folder belongs to a place."""
        self.stuck[place] = words
        line = json.dumps([path.relative_to(self._folder).as_posix() for path in (lies, place)])
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
        with suppress(OSError), open(os.open(self._home / KEPT, flags, 0o666), "ab") as file:
            file.write(f"{line}\n".encode())

    def move_back(self, lies: Path, place: Path) -> None:
        """Move something that is complete back to its place; if that fails, it is kept, and the next run does it."""
        try:
            os.rename(lies, place)
        except OSError:
            self.keep(lies, place, f"lies in {lies}, the next run moves it back")

    def words(self) -> str:
        """Return what could not be put back, and what to do about it; an empty text if all was."""
        if not self.stuck:
            return ""
        # What lies elsewhere first, as somebody may have to move it; new files are made again anyway.
        lost_first = sorted(self.stuck.items(), key=lambda item: item[1] == _NEW)
        named = [f"{place} ({words})" for place, words in lost_first]
        more = f" and {len(named) - _MOST} more new files" if len(named) > _MOST else ""
        return f"; could not be put back: {', '.join(named[:_MOST])}{more}; force=True makes all of it again"

    def put_back(self) -> None:
        """Put back what a run before has left: what lies aside and has no successor yet, and what is kept.

        An OutputError if somebody has to move a kept folder away.
        """
        for aside, place in asides(self._folder):
            if not os.path.lexists(place):
                os.rename(aside, place)
        for lies, place in kept(self._folder):
            if os.path.lexists(place):
                raise OutputError(f"{place}: {_CHANGED} {lies}; move that folder away")
            os.rename(lies, place)
        if os.path.lexists(self._home / KEPT):
            (self._home / KEPT).unlink()

    def _exchange(self, new: Path, place: Path) -> None:
        parts = place.relative_to(self._folder).parts
        aside = self._home.joinpath("old", str(len(parts)), *parts)
        try:
            exchange(new, place, aside)
        except NotPutBack:
            self.stuck[place] = _NEW if os.path.lexists(place) else f"lies in {aside}, the next run moves it back"
            raise

    def _take_back(self, rename: Callable[[Path, Path], object], new: Path, place: Path) -> None:
        try:
            rename(new, place)
        except OSError:
            self.stuck.setdefault(place, _NEW)


_NEW = "is new"
_MOST = 8
"""Places that a message names, so that it stays readable: more than there are files of one map."""
_CHANGED = "was changed while a run replaced it, which could not put it back; the changed one lies in"


def refuse_dangling(place: Path) -> None:
    """Raise an OutputError for a link that leads nowhere: no folder is made where it leads."""
    if place.is_symlink() and not place.exists():
        raise OutputError(f"{place}: is a link to {os.readlink(place)}, which does not exist; make that folder first")


def make_folder(folder: Path, undo: ExitStack) -> None:
    """Make a folder, and those above it, and let `undo` remove those that are still empty."""
    missing = []
    for place in (folder, *folder.parents):
        if place.is_dir():
            break
        try:
            place.lstat()
        except (FileNotFoundError, NotADirectoryError):
            missing.append(place)
        else:
            refuse_dangling(place)
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(place))
    for place in reversed(missing):
        if _is_made(place):
            undo.callback(remove_empty, place)


def _is_made(folder: Path) -> bool:
    """Make a folder, and return whether it is this run that made it: another one may have done so meanwhile.

    The lock then says which of them writes.
    """
    try:
        folder.mkdir()
    except FileExistsError:
        if not folder.is_dir():
            raise
        return False
    return True


_OF_DISKS = (".fuse_hidden", ".nfs")
"""Start of the names that FUSE and NFS give a file that is removed while it is open, until they know that it is closed.

They hear of that later than the program that closed it, as with the file of a lock (fuse.c of libfuse, nfs/unlink.c of
Linux).
"""

_TRIES, _PAUSE = 20, 0.01
"""Number of tries to remove an empty folder on such disks, and seconds between: on sshfs the second succeeds."""


def remove_empty(folder: Path) -> None:
    """Remove a folder unless somebody has put something into it."""
    for _ in range(_TRIES):
        with suppress(OSError):
            folder.rmdir()
            return
        # Not empty, perhaps: only files that the disk itself still has to remove are worth waiting for.
        names: list[str] | None = None
        with suppress(OSError):
            names = os.listdir(folder)
        if names is None or not all(name.startswith(_OF_DISKS) for name in names):
            return
        time.sleep(_PAUSE)
