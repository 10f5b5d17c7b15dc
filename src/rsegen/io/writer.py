"""Writes folders and files: the only module that does.

Bundle --write--> folder

A folder appears whole or not at all: its files are written next to it under a hidden name, then it is renamed. A folder
that exists already is left alone unless the caller says otherwise, and even then only one that rsegen made is replaced.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath

from rsegen.errors import REFUSED, OutputError, RsegenError, WriteError, shown
from rsegen.exporters.gazebo import Bundle

_MARK = "recipe.json"
_OLD = ".old"
_HIDDEN = re.compile(rf"\.(?P<name>.+)\.[0-9a-f]{{8}}(?P<old>{re.escape(_OLD)})?")


def refuse_not_a_folder(folder: Path) -> None:
    """Raise an OutputError if the path is something else than a folder, or if no folder can have that name."""
    try:
        taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        name = str(folder) if isinstance(error, OSError) else shown(str(folder))
        raise OutputError(f"{name}: {getattr(error, 'strerror', error)}") from None
    if taken:
        raise OutputError(f"{folder}: is a file; give a folder")


def refuse_taken(folders: Iterable[str | Path], *, force: bool) -> None:
    """Raise an OutputError for the first folder that exists, or that even `force` does not replace."""
    for folder in map(Path, filter(os.path.lexists, folders)):
        if not force:
            raise OutputError(f"{folder}: is there already; give --force to replace it, or another folder or --name")
        refuse_not_ours(folder)


def refuse_not_ours(folder: Path) -> None:
    """Raise an OutputError if a folder that exists was not made by rsegen, or is a link."""
    if folder.is_symlink():
        raise OutputError(f"{folder}: is a link, so it is not replaced; give another folder or --name")
    if not (folder / _MARK).is_file():
        raise OutputError(f"{folder}: was not made by rsegen (it has no {_MARK}), so it is not replaced")


def write(bundle: Bundle, folder: Path, *, force: bool = False) -> tuple[str, ...]:
    """Write every file of a bundle into a new folder; gives their names inside it, sorted as paths are.

    OutputError if the folder exists (with `force`: and may not be replaced) or may not be written; WriteError if the
    disk fails in the middle.
    """
    with _staged(bundle, folder) as hidden:
        _put_in_place(hidden, folder, force=force)
    return tuple(map(str, sorted(bundle)))


def add(bundle: Bundle, folder: Path) -> tuple[str, ...]:
    """Add the folders and files of a bundle to a folder that exists; gives the names of all files, as `write` does.

    Whole folders of the same name are replaced, then files; everything else stays. If it fails, all is as before.
    OutputError if it may not be written; WriteError if the disk fails in the middle.
    """
    remove_leftovers(folder, {path.parts[0] for path in bundle}.__contains__)
    with _staged(bundle, folder) as hidden:
        _move_into(hidden, folder)
    return tuple(map(str, sorted(bundle)))


def remove_leftovers(folder: Path, names: Callable[[str], bool]) -> None:
    """Remove what a killed run left of maps whose names `names` accepts; one that was being replaced comes back.

    Only real folders with a hidden name exactly as `write` gives them are removed.
    """
    with as_write_errors(folder), suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            match = _HIDDEN.fullmatch(entry.name)
            if match and names(match["name"]) and entry.is_dir(follow_symlinks=False):
                _remove(Path(entry.path), folder / match["name"], replaced=bool(match["old"]))


def refuse_taken_file(path: Path, *, force: bool) -> None:
    """Raise an OutputError if the path exists and is not a file, or exists without `force`."""
    if not os.path.lexists(path):
        return
    if not path.is_file():
        raise OutputError(f"{path}: is there already and is not a file; give another name")
    if not force:
        raise OutputError(f"{path}: is there already; give --force to replace it, or another name")


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False) -> None:
    """Write one file, whole or not at all; an OutputError if it exists already, unless `force`."""
    refuse_taken_file(path, force=force)
    with as_write_errors(path), parents_made(path):
        hidden = _hidden(path)
        try:
            _fill(hidden, content)
            hidden.replace(path)
        finally:
            hidden.unlink(missing_ok=True)


def _inside(path: PurePosixPath) -> PurePosixPath:
    if path.is_absolute() or ".." in path.parts or not path.parts:
        raise OutputError(f"{path}: leaves the output folder")
    return path


def _fill(path: str | Path, content: Iterable[bytes]) -> None:
    with open(path, "wb") as file:
        file.writelines(content)


def _fill_folder(folder: Path, bundle: Bundle) -> None:
    made = {PurePosixPath()}
    for path, content in bundle.items():
        above = _inside(path).parent
        if above not in made:
            os.makedirs(folder / above, exist_ok=True)
            made.add(above)
        _fill(os.path.join(folder, path), content)


def _hidden(path: Path) -> Path:
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}")


@contextmanager
def _staged(bundle: Bundle, folder: Path) -> Iterator[Path]:
    """A hidden folder next to `folder` with all files of a bundle, to be renamed; removed if that fails."""
    with as_write_errors(folder), parents_made(folder):
        hidden = _hidden(folder)
        try:
            os.mkdir(hidden)
            _fill_folder(hidden, bundle)
            yield hidden
        except BaseException:
            shutil.rmtree(hidden, ignore_errors=True)
            raise


def _put_in_place(hidden: Path, folder: Path, *, force: bool) -> None:
    """Rename; a folder that exists is removed only when the new one is in its place, wherever it is interrupted."""
    if not os.path.lexists(folder):
        os.rename(hidden, folder)
        return
    refuse_taken([folder], force=force)
    old = folder.with_name(hidden.name + _OLD)
    try:
        folder.rename(old)
        hidden.rename(folder)
    finally:
        _remove(old, folder, replaced=True)


def _move_into(hidden: Path, folder: Path) -> None:
    """Move what is in `hidden` into `folder`, files last; if it is interrupted before these, all is as before."""
    entries = sorted(hidden.iterdir())
    folders, files = [path for path in entries if path.is_dir()], [path for path in entries if path.is_file()]
    replaced: dict[Path, Path] = {}
    try:
        for source in folders:
            place = folder / source.name
            if place.exists():
                replaced[place] = folder / f".{source.name}{hidden.name[-9:]}{_OLD}"
                place.rename(replaced[place])
            source.rename(place)
        for source in files:
            source.replace(folder / source.name)
    except BaseException:
        if any(source.exists() for source in files):
            for source in (source for source in folders if not source.exists()):
                (folder / source.name).rename(source)
        raise
    finally:
        for place, old in replaced.items():
            _remove(old, place, replaced=True)
        shutil.rmtree(hidden, ignore_errors=True)


def _remove(hidden: Path, folder: Path, *, replaced: bool) -> None:
    if replaced and hidden.exists() and not folder.exists():
        hidden.rename(folder)
    shutil.rmtree(hidden, ignore_errors=True)


@contextmanager
def parents_made(folder: Path) -> Iterator[None]:
    """Make the folders above; if what is done in them fails, remove the new ones again."""
    if os.path.isdir(folder.parent):
        yield
        return
    missing = [above for above in folder.parents if not above.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
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
