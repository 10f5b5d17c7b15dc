"""Waits until the disk has what was written: a cut of power after that loses nothing."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

_FEW = 16
"""Files that are synced one by one; more of them are quicker with the whole disk at once, where the system can."""


def sync_tree(folder: Path) -> None:
    """Wait until the disk has all files and folders below a folder, and the folder itself."""
    found = list(_below(folder))
    if len(found) > _FEW and _syncfs():
        _sync_disk(folder)
        return
    for path, is_folder in found:
        (sync_folder if is_folder else _sync_file)(path)
    sync_folder(folder)


def sync_folder(folder: str | Path) -> None:
    """Wait until the disk has the names in a folder; Windows does that by itself."""
    if sys.platform == "win32":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _sync_file(path: str | Path) -> None:
    with open(path, "r+b") as file:
        os.fsync(file.fileno())


def _below(folder: str | Path) -> Iterator[tuple[str, bool]]:
    """Every file and folder below a folder, and whether it is a folder."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if is_folder := entry.is_dir(follow_symlinks=False):
                yield from _below(entry.path)
            yield entry.path, is_folder


@cache
def _syncfs() -> Any:
    """Linux's `syncfs`, None elsewhere."""
    if sys.platform != "linux":
        return None
    import ctypes  # slow to import

    return getattr(ctypes.CDLL(None, use_errno=True), "syncfs", None)


def _sync_disk(folder: Path) -> None:
    """Wait until the disk has everything that was written to it."""
    import ctypes

    descriptor = os.open(folder, os.O_RDONLY)
    try:
        if _syncfs()(descriptor):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), str(folder))
    finally:
        os.close(descriptor)
