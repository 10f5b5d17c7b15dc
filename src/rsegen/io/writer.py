"""Writes folders and files, with a record of them: the only module that does, with the hidden folders that it uses.

Bundle --write--> folder

A folder appears whole or not at all. One that exists already is left alone unless the caller says otherwise, and even
then only what rsegen wrote there is replaced.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from rsegen.errors import OutputError, shown
from rsegen.exporters.gazebo import Bundle
from rsegen.io.contents import refuse_link, refuse_loss
from rsegen.io.record import RECORD, Content, Record, WrittenFile, recorded
from rsegen.io.staging import Staging, as_write_errors, remove_leftovers, staging


def refuse_not_a_folder(folder: Path) -> None:
    """Raise an OutputError if the path is something else than a folder, or if no folder can have that name."""
    try:
        taken = folder.exists() and not folder.is_dir()
    except (OSError, ValueError) as error:
        name = str(folder) if isinstance(error, OSError) else shown(str(folder))
        raise OutputError(f"{name}: {getattr(error, 'strerror', error)}") from None
    if taken:
        raise OutputError(f"{folder}: is a file; give a folder")


def refuse_taken(folders: Iterable[str | Path], *, force: bool, content: Content = "map") -> None:
    """Raise an OutputError for the first folder that exists, or that even `force` does not replace by `content`."""
    for folder in map(Path, filter(os.path.lexists, folders)):
        if not force:
            raise OutputError(f"{folder}: exists already; give --force to replace it, or another folder or --name")
        refuse_loss(folder, content)


def refuse_taken_file(path: Path, *, force: bool) -> None:
    """Raise an OutputError if the path exists and is not a file, is a link, or exists without `force`."""
    if not os.path.lexists(path):
        return
    refuse_link(path)
    if not path.is_file():
        raise OutputError(f"{path}: exists already and is not a file; give another name")
    if not force:
        raise OutputError(f"{path}: exists already; give --force to replace it, or another name")


class FolderWriter:
    """Writes folders that appear together, each with its record."""

    def __init__(self, staged: Staging, content: Content, *, force: bool) -> None:
        self._staged = staged
        self._content = content
        self._force = force
        self._names: list[str] = []

    def write(self, name: str, bundle: Bundle) -> tuple[str, ...]:
        """Write the files of one folder, not yet at its place; gives their names inside it, sorted as paths are."""
        self.write_together(name, [bundle])
        return _sorted([*bundle, PurePosixPath(RECORD)])

    def write_together(
        self, name: str, bundles: Iterable[Bundle], done: Callable[[tuple[str, ...]], None] | None = None
    ) -> None:
        """Write the files of several bundles into one folder, as `write` does; those that an earlier one has, once.

        `done` is called with the names that each bundle adds, when they are written.
        """
        files: dict[str, tuple[WrittenFile, ...]] = {}
        with as_write_errors(self._staged.folder / name):
            for bundle in bundles:
                new = {path: pieces for path, pieces in bundle.items() if str(path) not in files}
                files |= {str(path): (self._staged.write(name / path, pieces),) for path, pieces in new.items()}
                if done:
                    done(_sorted(new))
            self._staged.write(f"{name}/{RECORD}", [Record(content=self._content, files=files).text()])
            self._names.append(name)

    def finish(self) -> None:
        """Put all of them in their places; an OutputError if one exists and may not be replaced."""
        if not self._names:
            return
        self._staged.sync()
        for name in self._names:
            place = self._staged.folder / name
            with as_write_errors(place):
                if os.path.lexists(place):
                    refuse_taken([place], force=self._force, content=self._content)
                self._staged.move_in(name)
        self._staged.sync_names()


@contextmanager
def folder_writer(
    folder: Path, content: Content = "map", *, force: bool = False, sync: bool = True
) -> Iterator[FolderWriter]:
    """Writes folders into `folder`: they appear at the end, and if something fails, those that are whole by then.

    force: replace those that exist already, if they hold nothing but `content` that rsegen wrote; sync: wait until
    the disk has them. Raises an OutputError if it may not be written there, WriteError if the disk fails.
    """
    with staging(folder, sync=sync) as staged:
        writer = FolderWriter(staged, content, force=force)
        try:
            yield writer
        finally:
            writer.finish()


def write(
    bundle: Bundle, folder: Path, content: Content = "map", *, force: bool = False, sync: bool = True
) -> tuple[str, ...]:
    """Write every file of a bundle into a new folder; gives their names inside it, sorted as paths are.

    The folder above is cleared of what killed runs left. Raises as `folder_writer` does.
    """
    remove_leftovers(folder.parent)
    with as_write_errors(folder), folder_writer(folder.parent, content, force=force, sync=sync) as writer:
        return writer.write(folder.name, bundle)


def add(bundle: Bundle, folder: Path, *, sync: bool = True) -> tuple[str, ...]:
    """Add the folders and files of a bundle to a folder that exists; gives the names of all files, as `write` does.

    Whole folders of the same name are replaced, then files; everything else stays. If it fails, all is as before.
    OutputError if it may not be written; WriteError if the disk fails in the middle.
    """
    remove_leftovers(folder)
    record = recorded(folder)
    tops = sorted({path.parts[0] for path in bundle}, key=lambda top: (PurePosixPath(top) in bundle, top))
    with staging(folder, sync=sync) as staged:
        files = {str(path): staged.write(path, pieces) for path, pieces in bundle.items()}
        _move_in_together(staged, tops, record, files)
    return _sorted([*bundle, *([PurePosixPath(RECORD)] if record else [])])


def write_file(content: Iterable[bytes], path: Path, *, force: bool = False, sync: bool = True) -> None:
    """Write one file, whole or not at all; an OutputError if it exists already, unless `force`.

    If its folder has a record, that lists the file from then on.
    """
    refuse_taken_file(path, force=force)
    write_files({path.name: content}, path.parent, record=recorded(path.parent), sync=sync, output=path)


def write_files(
    contents: Mapping[str, Iterable[bytes]],
    folder: Path,
    *,
    record: Record | None,
    sync: bool = True,
    output: Path | None = None,
) -> None:
    """Write or replace files of a folder, each whole or not at all; its record lists them, if it is to have one.

    output: the path in messages, by default the folder.
    """
    remove_leftovers(folder)
    with staging(folder, sync=sync, output=output) as staged:
        files = {name: staged.write(name, pieces) for name, pieces in contents.items()}
        _move_in_together(staged, contents, record, files)


def _move_in_together(
    staged: Staging, names: Collection[str], record: Record | None, files: Mapping[str, WrittenFile]
) -> None:
    """Put folders and files in their places, and list them in the record; all are taken back if one cannot be moved.

    While they are moved the record lists old and new files: whenever a run is killed, it lists every one that exists.
    """
    staged.sync()
    replaced = {name for name in record.files if name.partition("/")[0] in names} if record else ()
    moved: list[str] = []
    try:
        _put_record(staged, record and record.with_files(files))
        for name in names:
            staged.keep(name)
            moved.append(name)
            staged.move_in(name)
        _put_record(staged, record and record.after(files, replaced))
    except BaseException:
        for name in reversed(moved):
            staged.take_back(name)
        _put_record(staged, record)
        raise
    staged.sync_names()


def _put_record(staged: Staging, record: Record | None) -> None:
    """Put a record in its place, if the folder is to have one."""
    if record is not None:
        staged.write(RECORD, [record.text()])
        staged.sync()
        staged.move_in(RECORD)


def _sorted(paths: Iterable[PurePosixPath]) -> tuple[str, ...]:
    return tuple(map(str, sorted(paths)))
