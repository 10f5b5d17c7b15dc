"""Bundle -> folder: the one place that writes.

A folder appears whole or not at all: its files are written beside it under a hidden name, then it is renamed. A folder
that is there already is left alone unless the caller says otherwise, and even then only one that rsegen made.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from rsegen.errors import OutputError, RsegenError, WriteError
from rsegen.export import Bundle

_MARK = "recipe.json"
_REFUSED = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EEXIST, errno.ENAMETOOLONG}


def refuse_taken(folders: Iterable[Path], *, force: bool) -> None:
    """Raise an OutputError for the first folder that exists, or that with `force` is not rsegen's to replace."""
    for folder in folders:
        if not os.path.lexists(folder):
            continue
        if not force:
            raise OutputError(f"{folder}: is there already; give --force to replace it, or another folder or --name")
        if folder.is_symlink() or not (folder / _MARK).is_file():
            raise OutputError(f"{folder}: was not made by rsegen (it has no {_MARK}), so it is not replaced")


def write(bundle: Bundle, folder: Path, *, force: bool = False) -> list[Path]:
    """Write every file of a bundle into a new folder; gives their paths, sorted.

    OutputError where the folder is taken or may not be written; WriteError where the disk fails in the middle.
    """
    refuse_taken([folder], force=force)
    with _told(folder), _parent_of(folder):
        hidden = folder.with_name(f".{folder.name}.{secrets.token_hex(4)}")
        try:
            hidden.mkdir()
            for path, content in bundle.items():
                _fill(hidden / _inside(path), content)
            _put_in_place(hidden, folder)
        finally:
            shutil.rmtree(hidden, ignore_errors=True)
    return sorted(folder / path for path in bundle)


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False) -> None:
    """Write one file, whole or not at all; an OutputError where it is there already, unless `force`."""
    if os.path.lexists(path) and not (force and path.is_file()):
        raise OutputError(f"{path}: is there already; give --force to replace it, or another name")
    with _told(path), _parent_of(path):
        hidden = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
        try:
            _fill(hidden, content)
            hidden.replace(path)
        finally:
            hidden.unlink(missing_ok=True)


def _inside(path: PurePosixPath) -> PurePosixPath:
    if path.is_absolute() or ".." in path.parts or not path.parts:
        raise OutputError(f"{path}: leaves the output folder")
    return path


def _fill(path: Path, content: Iterable[bytes]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.writelines(content)


def _put_in_place(hidden: Path, folder: Path) -> None:
    """Rename; a folder that stands there goes only when the new one is in its place."""
    if not folder.exists():
        hidden.rename(folder)
        return
    old = folder.with_name(hidden.name + ".old")
    folder.rename(old)
    try:
        hidden.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    shutil.rmtree(old)


@contextmanager
def _parent_of(folder: Path) -> Iterator[None]:
    """Make the folders above; where that was in vain, take the new ones away again."""
    missing = [above for above in folder.parents if not above.exists()]
    folder.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        for above in missing:
            if not any(above.iterdir()):
                above.rmdir()
        raise


@contextmanager
def _told(folder: Path) -> Iterator[None]:
    """What the system says, as one line of ours."""
    try:
        yield
    except RsegenError:
        raise
    except OSError as error:
        kind = OutputError if error.errno in _REFUSED else WriteError
        raise kind(f"{folder}: cannot be written: {error.strerror or error}; nothing was left there") from error
