"""Put a staged file or folder in its place in one step: at no moment is there neither the old nor the new.

Linux can exchange two names at once, and rename one without replacing another (renameat2(2), since 3.15). If system or
disk cannot, a folder is moved aside first: if the run is killed in that moment, the next one that writes there puts it
back (store.py). Cost: one system call. What breaks it: staging on another disk than the place, so it is below it.

Files are on the disk before they get their names (fsync(2)), else a power failure could leave an empty file of the new
name. Many files are synced with the whole disk at once (syncfs(2)), which is quicker, and waits for others' data too.
"""

from __future__ import annotations

import errno
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

_NOREPLACE, _EXCHANGE = 1, 2  # of renameat2(2), in linux/fs.h
_AT_FDCWD = -100  # relative to the current folder, in linux/fcntl.h
_UNABLE = frozenset({errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP, errno.EXDEV, errno.EPERM})
"""Errors of systems and disks that cannot do it; EXDEV also of overlays, whose folders are moved by copying."""

_FEW = 16
"""Files that are synced one by one; more of them are quicker with the whole disk at once, if the system can.

A map has three to six. With a smaller number, a few maps would wait for whatever other programs write.
"""


def put(new: Path, place: Path) -> None:
    """Give a staged file or folder its name; FileExistsError if that is taken."""
    if not _renamed(new, place, _NOREPLACE):
        if os.path.lexists(place):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(place))
        os.rename(new, place)


def exchange(new: Path, place: Path, make_aside: Callable[[], Path]) -> Path:
    """Exchange a staged file or folder with the one at its place; return where the old one is now.

    make_aside: gives a path for the old one, if the system cannot exchange them
    """
    if _renamed(new, place, _EXCHANGE):
        return new
    aside = make_aside()
    if place.is_file():  # one rename is enough
        try:
            os.link(place, aside)
        except OSError:  # a disk without hard links
            shutil.copyfile(place, aside)
        os.replace(new, place)
        return aside
    os.rename(place, aside)
    try:
        os.rename(new, place)
    except BaseException:
        os.rename(aside, place)
        raise
    return aside


def _renamed(source: Path, place: Path, flags: int) -> bool:
    """Rename by renameat2; False if system or disk cannot do that, OSError if it failed."""
    rename = _of_libc("renameat2")
    if rename is None:
        return False
    if rename(_AT_FDCWD, os.fsencode(source), _AT_FDCWD, os.fsencode(place), flags) == 0:
        return True
    import ctypes

    code = ctypes.get_errno()
    if code in _UNABLE:
        return False
    raise OSError(code, os.strerror(code), str(place))


@cache
def _of_libc(name: str) -> Any:
    """Return a function of Linux's C library, None elsewhere."""
    if sys.platform != "linux":
        return None
    import ctypes  # which numpy has imported already

    return getattr(ctypes.CDLL(None, use_errno=True), name, None)


def sync_trees(*folders: Path) -> None:
    """Wait until the disk has all that is below some folders of one disk, and these folders themselves."""
    below = [(path, is_folder) for folder in folders for path, is_folder in [*_below(folder), (str(folder), True)]]
    if len(below) > _FEW and (sync_disk := _of_libc("syncfs")):
        import ctypes

        descriptor = os.open(below[-1][0], os.O_RDONLY)
        try:
            if sync_disk(descriptor):
                raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), below[-1][0])
        finally:
            os.close(descriptor)
        return
    for path, is_folder in below:
        (sync_folder if is_folder else sync_file)(path)


def sync_folder(folder: str | Path) -> None:
    """Wait until the disk has the names in a folder; Windows does that by itself."""
    if sys.platform == "win32":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_file(path: str | Path) -> None:
    """Wait until the disk has the content of a file."""
    with open(path, "r+b") as file:
        os.fsync(file.fileno())


def _below(folder: str | Path) -> Iterator[tuple[str, bool]]:
    """Yield every file and folder below a folder, and whether it is a folder."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if is_folder := entry.is_dir(follow_symlinks=False):
                yield from _below(entry.path)
            yield entry.path, is_folder
