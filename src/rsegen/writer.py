"""Bundle -> folder: the one place that writes.

A folder appears whole or not at all: its files are written beside it under a hidden name, then it is renamed. A folder
that is there already is left alone unless the caller says otherwise, and even then only one that rsegen made.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from rsegen.errors import REFUSED, OutputError, RsegenError, WriteError, shown
from rsegen.export import Bundle

_MARK = "recipe.json"


def refuse_not_a_folder(folder: Path) -> None:
    """Raise an OutputError where something else than a folder stands there, or none can have that name."""
    try:
        taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        name = str(folder) if isinstance(error, OSError) else shown(str(folder))
        raise OutputError(f"{name}: {getattr(error, 'strerror', error)}") from None
    if taken:
        raise OutputError(f"{folder}: is a file; give a folder")


def refuse_taken(folders: Iterable[Path], *, force: bool) -> None:
    """Raise an OutputError for the first folder that exists, or that with `force` is not rsegen's to replace."""
    for folder in folders:
        if not os.path.lexists(folder):
            continue
        if not force:
            raise OutputError(f"{folder}: is there already; give --force to replace it, or another folder or --name")
        if folder.is_symlink():
            raise OutputError(f"{folder}: is a link, so it is not replaced; give another folder or --name")
        if not (folder / _MARK).is_file():
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


def refuse_taken_file(path: Path, *, force: bool) -> None:
    """Raise an OutputError where something stands there that is not a file, or is not to be replaced."""
    if not os.path.lexists(path):
        return
    if not path.is_file():
        raise OutputError(f"{path}: is there already and is not a file; give another name")
    if not force:
        raise OutputError(f"{path}: is there already; give --force to replace it, or another name")


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False) -> None:
    """Write one file, whole or not at all; an OutputError where it is there already, unless `force`."""
    refuse_taken_file(path, force=force)
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
    """Rename; a folder that stands there goes only when the new one is in its place, wherever it is interrupted."""
    old = folder.with_name(hidden.name + ".old")
    try:
        if folder.exists():
            folder.rename(old)
        hidden.rename(folder)
    finally:
        if old.exists() and not folder.exists():
            old.rename(folder)
        shutil.rmtree(old, ignore_errors=True)


@contextmanager
def _parent_of(folder: Path) -> Iterator[None]:
    """Make the folders above; where that was in vain, take the new ones away again."""
    missing = [above for above in folder.parents if not above.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        with suppress(OSError):  # it was not made, or something else is in it by now
            for above in missing:
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
        kind = OutputError if error.errno in REFUSED else WriteError
        raise kind(f"{folder}: cannot be written: {error.strerror or error}; nothing was left there") from error
