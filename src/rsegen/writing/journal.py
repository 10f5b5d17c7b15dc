"""The journal of a folder, `.rsegen.jsonl`: what rsegen wrote there. Nothing else is ever replaced.

    {"rsegen_journal": 1, "holds": "data set", "of": {...}, "crc32": "..."}    what the folder holds, made of what
    {"file": "a.npy", "bytes": 8128, "sha256": "...", "crc32": "..."}    appended before the file gets its name
    {"result": {...}, "crc32": "..."}                                    what was measured, as of a trial
    {"gone": "stl/map.stl", "crc32": "..."}                              removed by rsegen

Each line ends with the CRC-32 of what stands before it, which notices every change of up to four bytes in a row. Lines
are only appended, and are on the disk before the file that they speak of is at its place. So whenever a run
ends, every file of rsegen has its checksum in the journal; a last line that was cut off does not count. A file may
have several checksums, of what it was and of what it becomes: while it has any of them, rsegen wrote it.

A folder is compared with its journal before anything in it is replaced, and by `rsegen info --verify`: files are
intact, changed, missing, or foreign, that is not listed. Source: our own (decision 15), like a write-ahead log of
databases. Cost: a line and a wait for the disk per swap; a comparison reads every file whose size is right. What breaks
it: a journal that somebody edits; it is damaged then, and nothing is replaced.
"""

from __future__ import annotations

import json
import os
import stat
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any

from rsegen.errors import FileError, FilesDamaged, OutputError, system_reason
from rsegen.input_files import JOURNAL, Checksum, checksum_of, open_regular
from rsegen.params.sorts import FilePath, Json
from rsegen.writing.swap import NotPutBack, put, sync

HIDDEN = ".rsegen"
"""Start of the names of rsegen's own folders, which no journal lists: staging, and a folder being replaced."""

KEPT = "kept"
"""The file in a hidden folder that says, in lines of JSON, what lies in it, and at which place it belongs (undo.py)."""

_FORMAT = 1
_LARGEST = 256 * 2**20
"""Bytes of a journal that are read at most: some two million files; more memory than this is not risked for a file."""

_KINDS = {
    "map": "a map",
    "package": "a package of maps",
    "drive": "a drive",
    "data set": "a data set",
    "experiment": "an experiment",
    "rating": "a rating",
}
_LOST = "and would be overwritten; move it, or use another folder"


@dataclass(frozen=True, kw_only=True, slots=True)
class Journal:
    """The content of a journal: what the folder holds, of what it was made, and rsegen's files in it by their paths.

    holds: map, drive, data set, experiment, rating, or files: files of rsegen among others
    files: every checksum that a file may have, the last one what it should be   size: bytes of the complete lines
    """

    holds: str
    of: Json = None
    files: dict[str, tuple[Checksum, ...]] = field(default_factory=dict)
    results: tuple[Mapping[str, Any], ...] = ()
    size: int = 0


def journal_text(
    holds: str | None,
    files: Mapping[str, Checksum | tuple[Checksum, ...]],
    of: Json = None,
    *,
    results: Iterable[Mapping[str, Any]] = (),
    gone: Iterable[str] = (),
) -> bytes:
    """Return lines of a journal: the first one, unless `holds` is None, and one for each checksum, result and name."""
    entries: list[Mapping[str, object]] = []
    if holds is not None:
        entries.append({"rsegen_journal": _FORMAT, "holds": holds} | ({} if of is None else {"of": of}))
    for name, checksums in sorted(files.items()):
        several = (checksums,) if isinstance(checksums, Checksum) else checksums
        entries += [{"file": name, "bytes": checksum.bytes, "sha256": checksum.sha256} for checksum in several]
    entries += [{"result": result} for result in results]
    entries += [{"gone": name} for name in sorted(gone)]
    return b"".join(_line(json.dumps(entry).encode()) + b"\n" for entry in entries)


_CHECK = b', "crc32": "'
_KEYS = ({"rsegen_journal", "holds", "of"}, {"file", "bytes", "sha256"}, {"result"}, {"gone"})


def _line(entry: bytes) -> bytes:
    """Return a line of a journal: a JSON object, with its checksum as its last value."""
    return entry.removesuffix(b"}") + _CHECK + b'%08x"}' % zlib.crc32(entry)


def _entry(line: bytes) -> dict[str, Any]:
    """Return the entry of a line; ValueError or AttributeError if it is not as it was written.

    A line without a checksum was written by hand, or by a version before 1.0.
    """
    before, check, _ = line.rpartition(_CHECK)
    if check and line != _line(before + b"}"):
        raise ValueError(line)
    entry: dict[str, Any] = json.loads(before + b"}" if check else line)
    if not any(entry.keys() <= keys for keys in _KEYS):
        raise ValueError(line)
    return entry


def read_journal(folder: Path) -> Journal | None:
    """Return the journal of a folder, None if it has no journal; FileError if that is damaged or not rsegen's."""
    path = folder / JOURNAL
    if path.is_symlink():
        raise FileError(f"{path}: is a link, so nothing in this folder is replaced; use another folder")
    try:
        with open_regular(path) as file:
            text = file.read(_LARGEST + 1)
        return _decoded(text)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise FileError(f"{path}: {system_reason(error)}") from None
    except (ValueError, TypeError, KeyError, RecursionError, AttributeError):
        raise FileError(
            f"{path}: is not a journal of rsegen, or is damaged, so nothing in this folder is replaced; move the "
            "folder away, or use another one"
        ) from None


def _decoded(text: bytes) -> Journal:
    """Return the journal of these lines; ValueError, TypeError, KeyError or AttributeError if they are none."""
    *lines, last = text.split(b"\n")  # a last line that was cut off does not count
    first, *entries = map(_entry, lines)
    if last[:-1].endswith(b'"}') and _CHECK in last:  # not cut off by a kill: its end was changed
        raise ValueError(last)
    if first["rsegen_journal"] != _FORMAT or len(text) > _LARGEST:
        raise ValueError(first)
    files: dict[str, tuple[Checksum, ...]] = {}
    results = []
    for entry in entries:  # in their order: a later checksum comes last, and a file that is gone may come again
        if "file" in entry:
            name = inside(entry["file"])
            if not isinstance(entry["bytes"], int):
                raise TypeError(entry["bytes"])
            checksum = Checksum(bytes=entry["bytes"], sha256=str(entry["sha256"]))
            files[name] = (*(known for known in files.get(name, ()) if known != checksum), checksum)
        elif "gone" in entry:
            files.pop(entry["gone"], None)
        else:
            results.append(dict(entry["result"]))
    whole = len(text) - len(last)
    return Journal(holds=str(first["holds"]), of=first.get("of"), files=files, results=tuple(results), size=whole)


def inside(name: str) -> str:
    """Return the path of a file in the folder; ValueError if it leads out of it."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or not path.parts or str(path) != name:
        raise ValueError(name)
    return name


class OpenJournal:
    """The journal of a folder that this run alone appends to; `content`: as on disk, None before the first line."""

    def __init__(self, folder: Path, staging: Path, *, sync: bool) -> None:
        self.content: Journal | None = read_journal(folder)
        self._path, self._staged, self._sync = folder / JOURNAL, staging / JOURNAL, sync
        self._size = self.content.size if self.content else 0

    def begin(self, holds: str, of: Json = None) -> Journal:
        """Say what the folder holds, if it has no journal; the first line is written with the first file or result."""
        self.content = self.content or Journal(holds=holds, of=of)
        return self.content

    @contextmanager
    def announced(self, files: Mapping[str, Checksum], holds: str) -> Iterator[None]:
        """Append a line for each of these files first; if what is done inside fails, they are cut off again.

        They stay if files could not be put back: each may then be old or new, and is known as rsegen's.
        """
        size, content = self._size, self.begin(holds)
        self._append(files)
        try:
            yield
        except NotPutBack:
            for name, checksum in files.items():
                known = (old for old in content.files.get(name, ()) if old != checksum)
                content.files[name] = (*known, checksum)
            raise
        except BaseException:
            self._cut(size)
            raise
        content.files.update((name, (checksum,)) for name, checksum in files.items())

    def tidy(self) -> None:
        """Write the journal anew with one line per file, sorted: a run that was stopped and went on leaves the same.

        If that fails, it says the same as it is.
        """
        content = self.content
        if content is None or not self._size:
            return
        text = journal_text(content.holds, content.files, content.of, results=content.results)
        with suppress(OSError):
            if len(text) != self._size or self._path.read_bytes() != text:
                self._write(self._staged, text, 0)
                os.replace(self._staged, self._path)
                self._size = len(text)

    def note(self, result: Mapping[str, Json]) -> None:
        """Append a result to a journal that has begun."""
        content = self.begin("files")
        self._append(results=[result])
        self.content = replace(content, results=(*content.results, result))

    def drop(self, names: Collection[str]) -> None:
        """List files as gone, which rsegen has removed."""
        self._append(gone=names)
        for name in names:
            self.begin("files").files.pop(name, None)

    def _append(self, files: Mapping[str, Checksum] | None = None, **more: Any) -> None:
        """Append lines, and wait until the disk has them; half a line, of a run that was killed, is cut off before.

        A new journal is staged, and gets its name with its lines, so that none has half a first line.
        """
        size, content = self._size, self.begin("files")
        lines = journal_text(None if size else content.holds, files or {}, content.of, **more)
        try:
            if size:
                self._write(self._path, lines, size)
            else:
                self._write(self._staged, lines, 0)
                put(self._staged, self._path)
                if self._sync:
                    sync(self._path.parent)
        except FileExistsError:  # somebody else's
            raise
        except BaseException:
            self._cut(size)
            raise
        self._size += len(lines)

    def _write(self, path: Path, lines: bytes, size: int) -> None:
        """Write lines behind the first `size` bytes of a file; never into what a link leads to."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
        with open(path, "ab", opener=lambda name, _: os.open(name, flags, 0o666)) as file:
            if file.tell() != size:
                file.truncate(size)
            file.write(lines)
            file.flush()
            if self._sync:
                os.fsync(file.fileno())

    def _cut(self, size: int) -> None:
        """Undo what was appended beyond a size; a journal that had nothing before is removed."""
        with suppress(OSError):
            if size:
                os.truncate(self._path, size)
            else:
                self._path.unlink()
        self._size = size


@dataclass(frozen=True, kw_only=True, slots=True)
class FolderComparison:
    """Paths in a folder, sorted: files that rsegen did not write, files changed since, and missing or empty files.

    A link, and anything else that is no regular file, is foreign or changed. An empty file has nothing to lose: it is
    what a power failure may leave of a run with --no-sync.
    """

    foreign: tuple[str, ...]
    changed: tuple[str, ...]
    missing: tuple[str, ...]


def compare(folder: Path, journal: Journal, below: str = "") -> FolderComparison:
    """Compare a folder, or only what is `below` a folder of it, with its journal; OSError if it is unreadable."""
    start = f"{below}/" if below else ""
    present = dict(_files(folder / below, start))
    named: dict[str, list[str]] = {"intact": [], "changed": [], "missing": []}
    for name in sorted(name for name in journal.files if name.startswith(start)):
        named[_state(folder / name, present.get(name), journal.files[name])].append(name)
    return FolderComparison(
        foreign=tuple(sorted(present.keys() - journal.files.keys() - {JOURNAL})),
        changed=tuple(named["changed"]),
        missing=tuple(named["missing"]),
    )


def is_intact(folder: Path, name: str, journal: Journal | None) -> bool:
    """Return whether a file exists as rsegen wrote it; OutputError if it was changed, or written by somebody else."""
    path = folder / name
    with read_errors(folder):
        status = os.lstat(path) if os.path.lexists(path) else None
        if status is None:
            return False
        checksums = journal.files.get(name) if journal else None
        if checksums is None:
            refuse_link(path)
            raise OutputError(f"{path}: was not written by rsegen, so it is not replaced; move it, or use another name")
        state = _state(path, status, checksums)
    if state == "changed":
        raise OutputError(
            f"{path}: was changed after rsegen wrote it, so it is not replaced; move or delete it, or use another name"
        )
    return state == "intact"


def refuse_loss(folder: Path, holds: str, at: Path | None = None) -> None:
    """Raise an OutputError unless everything in a folder was written by rsegen as `holds`, and is unchanged.

    Such a folder may be replaced as a whole. at: its path in messages, if it was moved.
    """
    # First what the folder is, then each file in it: foreign ones before changed ones, as they are somebody else's.
    shown = at or folder
    refuse_link(folder)
    if not folder.is_dir():
        raise OutputError(f"{shown}: is a file; use another folder or name")
    with read_errors(folder):
        journal = read_journal(folder)
        if journal is None:
            for name, _ in _files(folder):
                top = name.partition("/")[0]
                if inner := read_journal(folder / top) if (folder / top).is_dir() else None:
                    kind = _KINDS.get(inner.holds, "files of rsegen")
                    raise OutputError(f"{shown}: contains {kind} in {top}; use another folder")
                raise OutputError(f"{shown / name}: was not written by rsegen, {_LOST}")
            return
        if journal.holds != holds:
            kind, expected = _KINDS.get(journal.holds, "files of rsegen"), _KINDS.get(holds, holds)
            raise OutputError(f"{shown}: contains {kind}, not {expected}; use another folder")
        comparison = compare(folder, journal)
    _refuse_lost(comparison, shown)


def refuse_loss_below(folder: Path, name: str, journal: Journal | None) -> None:
    """Raise an OutputError unless everything in a folder of a folder is as its journal lists it."""
    _refuse_lost(compare(folder, journal or Journal(holds="files"), name), folder)


def _refuse_lost(comparison: FolderComparison, folder: Path) -> None:
    for name in comparison.foreign:
        raise OutputError(f"{folder / name}: was not written by rsegen, {_LOST}")
    for name in comparison.changed:
        raise OutputError(f"{folder / name}: was changed after rsegen wrote it, {_LOST}")


def refuse_link(path: Path) -> None:
    """Raise an OutputError if a path is a link: neither it nor what it leads to is replaced."""
    if path.is_symlink():
        raise OutputError(f"{path}: is a link, so it is not replaced; use another folder or name")


def is_empty(folder: Path) -> bool:
    """Return whether a folder does not exist, or has only what a killed run of rsegen leaves."""
    return not folder.is_dir() or next(_files(folder), None) is None


def asides(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield what a killed run has moved aside in a folder, to replace it, and its place."""
    # Nothing else is removed of a map that is replaced than one folder in it, so no path is deeper (swap.exchange).
    for depth in (1, 2):
        above = folder / HIDDEN / "old" / str(depth)
        yield from ((aside, folder / aside.relative_to(above)) for aside in above.glob("/".join("*" * depth)))


def kept(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield what lies in the hidden folder of a folder, and is not to be removed, and its place."""
    lines: list[bytes] = []
    with suppress(OSError), open_regular(folder / HIDDEN / KEPT) as file:
        lines = file.read(_LARGEST).splitlines()
    for line in lines:
        with suppress(ValueError, TypeError, AttributeError, RecursionError):
            lies, place = (folder / inside(name) for name in json.loads(line))
            if os.path.lexists(lies) and (folder / HIDDEN) in lies.parents and not place.parent.is_symlink():
                yield lies, place


def _is_own(name: str, path: str) -> bool:
    """Return whether a folder is a hidden one of a run, and does not only have such a name."""
    if name == f"{HIDDEN}.next":  # without a journal, if the run was killed before it wrote the first one
        return os.path.lexists(os.path.join(path, JOURNAL)) or is_empty(Path(path))
    return name in (f"{HIDDEN}/new", f"{HIDDEN}/old") or (name == HIDDEN and not os.listdir(path))


def _state(path: Path, status: os.stat_result | None, checksums: Collection[Checksum]) -> str:
    """Return intact, changed, or missing: that is gone, or empty where it should not be."""
    sizes = {checksum.bytes for checksum in checksums}
    if status is None or (stat.S_ISREG(status.st_mode) and status.st_size == 0 and 0 not in sizes):
        return "missing"
    is_right = stat.S_ISREG(status.st_mode) and status.st_size in sizes and checksum_of(path) in checksums
    return "intact" if is_right else "changed"


def _files(folder: Path, above: str = "") -> Iterator[tuple[str, os.stat_result]]:
    """Yield every file, link and the like below a folder by its path in it, and empty folders; follow no link."""
    waiting = [(str(folder), above)] if folder.is_dir() and not folder.is_symlink() else []
    while waiting:
        path, start = waiting.pop()
        with os.scandir(path) as scanned:
            entries = list(scanned)
        if start and not entries:
            yield start.removesuffix("/"), os.lstat(path)
        for entry in entries:
            if not entry.is_dir(follow_symlinks=False):
                if f"{start}{entry.name}" != f"{HIDDEN}/lock":
                    yield f"{start}{entry.name}", entry.stat(follow_symlinks=False)
            elif not _is_own(f"{start}{entry.name}", entry.path):
                waiting.append((entry.path, f"{start}{entry.name}/"))


@contextmanager
def read_errors(folder: Path) -> Iterator[None]:
    """Turn errors of the system while a folder is read into an OutputError of one line."""
    try:
        yield
    except OSError as error:
        where = error.filename or folder
        raise OutputError(f"{where}: cannot be read: {system_reason(error)}") from None


@dataclass(frozen=True, kw_only=True, slots=True)
class Verified:
    """The result of `verify`.

    Attributes
    ----------
    folders, files : int
        Numbers of folders and files that were compared.
    unlisted : tuple of Path
        The files that no journal lists.
    """

    folders: int
    files: int
    unlisted: tuple[Path, ...]


def verify(folder: str | Path) -> Verified:
    """Compare a folder, and the folders in it, with their journals.

    Nothing is built again; `Dataset.verify` does that too.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Returns
    -------
    Verified
        What was compared.

    Raises
    ------
    FilesDamaged
        If a file is missing, empty or changed.
    FileError
        If there is no journal.
    """
    folder = FilePath().check("folder", folder)
    if not folder.is_dir():
        raise FileError(f"{folder}: there is no such folder")
    with read_errors(folder):
        inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
        journals = {path: journal for path in (folder, *inside) if (journal := read_journal(path))}
    _refuse_hidden(folder)
    if not journals:
        raise FileError(f"{folder}: no {JOURNAL} in it, nor in its folders, so its files cannot be compared")
    unlisted: list[Path] = []
    for home, journal in journals.items():
        with read_errors(home):
            comparison = compare(home, journal)
        wrong = [f"{home / name}: was changed after rsegen wrote it" for name in comparison.changed]
        wrong += [f"{home / name}: is missing or empty" for name in comparison.missing]
        if wrong:
            more, are = len(wrong) - 1, "files in this folder are" if wrong[2:] else "file in this folder is"
            raise FilesDamaged(wrong[0] + (f"; {more} more {are} changed, missing or empty" if more else ""))
        if journal.holds not in ("files", "experiment"):  # which have others beside them
            unlisted += [home / name for name in comparison.foreign]
    files = sum(len(journal.files) for journal in journals.values())
    return Verified(folders=len(journals), files=files, unlisted=tuple(unlisted))


def _refuse_hidden(folder: Path) -> None:
    """Raise a FilesDamaged if something that belongs into a folder lies in its hidden folder."""
    for aside, place in asides(folder):
        if not os.path.lexists(place):
            problem = f"lies in {aside}, as a run that replaced it did not get to its end"
            raise FilesDamaged(f"{place}: {problem}; the next one that writes into {folder} puts it back")
    for lies, place in kept(folder):
        raise FilesDamaged(f"{place}: could not be put in its place by a run, and lies in {lies}")
