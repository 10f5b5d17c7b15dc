"""Put a staged file or folder in its place in one step, so that a kill leaves the old or the new.

Linux can exchange two names at once, and rename one without replacing another (renameat2(2), since 3.15). Where system
or disk cannot, a folder lies aside between two renames, and the next run that writes there puts it back (store.py).
Afterwards both ways leave the same: each has the other's name. Cost: one system call, or three. What breaks it: staging
on another disk than the place, so it is below it.

Files are on the disk before they get their names (fsync(2)), else a power failure could leave an empty file of the new
name. Many files are synced with the whole disk at once (syncfs(2)), which is quicker, and waits for others' data too.
"""

from __future__ import annotations

import errno
import os
import shutil
import sys
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


class NotPutBack(OSError):
    """A rename failed, and one before it could not be taken back; the names of both are what they then were."""


def put(new: Path, place: Path) -> None:
    """Give a staged file or folder its name; FileExistsError if that is taken."""
    if not _renamed(new, place, _NOREPLACE):
        if os.path.lexists(place):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(place))
        os.rename(new, place)


def exchange(new: Path, place: Path, aside: Path) -> None:
    """Exchange the names of a staged file or folder and of the one at its place.

    aside: the name of the old one meanwhile, if the system cannot exchange them, and for good if a NotPutBack is raised
    """
    if _renamed(new, place, _EXCHANGE):
        return
    aside.parent.mkdir(parents=True, exist_ok=True)
    is_folder = place.is_dir()
    if is_folder:
        os.rename(place, aside)
    else:  # one rename replaces a file
        try:
            os.link(place, aside)
        except OSError:  # a disk without hard links
            shutil.copyfile(place, aside)
    try:
        os.replace(new, place)
        os.rename(aside, new)
    except OSError as error:
        try:  # both names back: `new` has its content again, and the place the old one
            if is_folder and os.path.lexists(place):
                os.rename(place, new)
            os.replace(aside, place)
        except OSError:
            raise NotPutBack(error.errno, error.strerror) from error
        raise


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
    paths = [
        path
        for folder in folders
        for above, _, names in os.walk(folder)
        for path in (*(os.path.join(above, name) for name in names), above)
    ]
    if len(paths) > _FEW and (sync_disk := _of_libc("syncfs")):
        import ctypes

        descriptor = os.open(paths[0], os.O_RDONLY)
        try:
            if sync_disk(descriptor):
                raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), paths[0])
        finally:
            os.close(descriptor)
        return
    for path in paths:
        sync(path)


def sync(path: str | Path) -> None:
    """Wait until the disk has the content of a file, or the names in a folder; Windows does the latter by itself."""
    if sys.platform == "win32" and os.path.isdir(path):
        return
    descriptor = os.open(path, os.O_RDWR if sys.platform == "win32" else os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
