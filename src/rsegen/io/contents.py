"""What lies in a folder, compared with the record of what rsegen wrote there: nothing else is ever replaced.

folder, record --compare--> Comparison: foreign, changed and damaged files
"""

from __future__ import annotations

import os
import stat
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.io.former import former_files
from rsegen.io.record import RECORD, Content, Record, WrittenFile, read_record, written_file
from rsegen.io.staging import HIDDEN

_NAMES = {"map": "a map", "drive": "a drive", "files": "a series or an experiment"}
_LOST = "and would be lost; move it away, or give another folder"


class State(Enum):
    """A file compared with its entries in a record."""

    INTACT = "as it was written"
    CHANGED = "changed since"
    DAMAGED = "missing, or empty as after a power failure"


@dataclass(frozen=True, kw_only=True, slots=True)
class Comparison:
    """Paths in a folder, sorted: files that rsegen did not write, that were changed since, that are missing or empty.

    A link, and anything else that is no regular file, is foreign or changed.
    """

    foreign: tuple[str, ...]
    changed: tuple[str, ...]
    damaged: tuple[str, ...]

    @property
    def is_intact(self) -> bool:
        """Whether every file of the record is as it was written; there may be others."""
        return not self.changed and not self.damaged


def compare(folder: Path, record: Record, below: str = "") -> Comparison:
    """The files in a folder, or only those `below` a folder of it, compared with its record; OSError if unreadable."""
    start = f"{below}/" if below else ""
    found = dict(_files(folder / below, start))
    states = {
        name: _state(folder / name, found.get(name), files)
        for name, files in record.files.items()
        if name.startswith(start)
    }
    return Comparison(
        foreign=tuple(sorted(found.keys() - record.files.keys() - {RECORD})),
        changed=_in_state(states, State.CHANGED),
        damaged=_in_state(states, State.DAMAGED),
    )


def state_of(folder: Path, name: str, record: Record) -> State:
    """The state of one file of a record; OSError if it is unreadable."""
    path = folder / name
    status = os.lstat(path) if os.path.lexists(path) else None
    return _state(path, status, record.files[name])


def refuse_loss(folder: Path, content: Content) -> None:
    """Raise an OutputError if a folder that exists may not be replaced as a whole by other `content`.

    It may not if it is a link, holds something else, or has files that rsegen did not write or that were changed since.
    """
    refuse_link(folder)
    if not folder.is_dir():
        raise OutputError(f"{folder}: is a file; give another folder or --name")
    with _read_errors(folder):
        record = read_record(folder)
        if record is None:
            _refuse_foreign(folder, _unknown_files(folder, content))
            return
        if record.content != content:
            raise OutputError(f"{folder}: holds {_NAMES[record.content]}, not {_NAMES[content]}; give another folder")
        found = compare(folder, record)
    _refuse_foreign(folder, found.foreign)
    for name in found.changed:
        raise OutputError(f"{folder / name}: was changed after rsegen wrote it, {_LOST}")


def refuse_loss_of_files(folder: Path, names: Iterable[str]) -> None:
    """Raise an OutputError for the first file of these names in a folder that is not as rsegen wrote it."""
    present = [name for name in names if os.path.lexists(folder / name)]
    with _read_errors(folder):
        record = read_record(folder) if present else None
        is_former = former_files(folder, "files")
        for name in present:
            refuse_link(folder / name)
            if record and name in record.files:
                ours = state_of(folder, name, record) is not State.CHANGED
            else:
                ours = is_former(name)
            if not ours:
                raise OutputError(f"{folder / name}: was not written by rsegen, or changed since, {_LOST}")


def refuse_link(path: Path) -> None:
    """Raise an OutputError if a path is a link: neither it nor what it leads to is replaced."""
    if path.is_symlink():
        raise OutputError(f"{path}: is a link, so it is not replaced; give another folder or name")


def _refuse_foreign(folder: Path, names: Iterable[str]) -> None:
    for name in names:
        raise OutputError(f"{folder / name}: was not written by rsegen, {_LOST}")


def _unknown_files(folder: Path, content: Content) -> list[str]:
    """The files of a folder without a record that rsegen 0.1 did not write.

    An empty record is what a power failure leaves: then empty files are of that run too.
    """
    is_former, found = former_files(folder, content), dict(_files(folder))
    failed = found.pop(RECORD, None)
    may_be_empty = failed is not None and stat.S_ISREG(failed.st_mode)
    return sorted(
        name
        for name, status in found.items()
        if not stat.S_ISREG(status.st_mode) or not (is_former(name) or (may_be_empty and not status.st_size))
    )


def _in_state(states: Mapping[str, State], wanted: State) -> tuple[str, ...]:
    return tuple(sorted(name for name, state in states.items() if state is wanted))


def _state(path: Path, status: os.stat_result | None, written: Collection[WrittenFile | None]) -> State:
    sizes = {one.bytes for one in written if one}
    if status is None:
        return State.DAMAGED
    if not stat.S_ISREG(status.st_mode):
        return State.CHANGED
    if status.st_size == 0 and 0 not in sizes:
        return State.DAMAGED
    if status.st_size not in sizes or written_file(path) not in written:
        return State.CHANGED
    return State.INTACT


def _files(folder: Path, above: str = "") -> Iterator[tuple[str, os.stat_result]]:
    """Every file, link and the like below a folder by its path in it; no link is followed.

    Hidden folders that a killed run left are passed over.
    """
    waiting = [(str(folder), above)] if folder.is_dir() and not folder.is_symlink() else []
    while waiting:
        path, start = waiting.pop()
        with os.scandir(path) as entries:
            for entry in entries:
                if not entry.is_dir(follow_symlinks=False):
                    yield f"{start}{entry.name}", entry.stat(follow_symlinks=False)
                elif not HIDDEN.fullmatch(entry.name):
                    waiting.append((entry.path, f"{start}{entry.name}/"))


@contextmanager
def _read_errors(folder: Path) -> Iterator[None]:
    """Turns errors of the system while a folder is read into an OutputError of one line."""
    try:
        yield
    except OSError as error:
        where = error.filename or folder
        raise OutputError(f"{where}: cannot be read: {error.strerror or error}") from None
