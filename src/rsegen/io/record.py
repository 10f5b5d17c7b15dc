"""The record of what rsegen wrote into a folder: `rsegen-files.json`, with the size and checksum of every file.

Only files that a record lists, and that have not changed since, are ever replaced.
"""

from __future__ import annotations

import builtins
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import BinaryIO, Literal, get_args

from rsegen.errors import FileError
from rsegen.io.input_files import open_regular

RECORD = "rsegen-files.json"

Content = Literal["map", "drive", "files"]
"""What a folder holds: one map, one drive, or files of rsegen among others."""

_CONTENTS: tuple[Content, ...] = get_args(Content)
_FORMAT = 1
_LARGEST = 256 * 2**20
_AT_ONCE = 2**20


@dataclass(frozen=True, kw_only=True, slots=True)
class WrittenFile:
    """The size and SHA-256 checksum of one file."""

    bytes: int
    sha256: str

    @classmethod
    def of(cls, content: builtins.bytes) -> WrittenFile:
        """Those of a file with this content."""
        return cls(bytes=len(content), sha256=hashlib.sha256(content).hexdigest())


@dataclass(frozen=True, kw_only=True, slots=True)
class Record:
    """The files of a folder by their paths in it, `/` between folders.

    A file has two entries, the old one and the new one, while it is being replaced.
    """

    content: Content
    files: Mapping[str, tuple[WrittenFile, ...]]

    def with_files(self, added: Mapping[str, WrittenFile]) -> Record:
        """The record while files are added or replaced: both entries of those that are replaced."""
        both = {name: tuple(dict.fromkeys((*self.files.get(name, ()), file))) for name, file in added.items()}
        return Record(content=self.content, files={**self.files, **both})

    def after(self, added: Mapping[str, WrittenFile], removed: Iterable[str] = ()) -> Record:
        """The record once files have been added, and others removed."""
        gone = frozenset(removed)
        kept = {name: files for name, files in self.files.items() if name not in gone}
        return Record(content=self.content, files=kept | {name: (file,) for name, file in added.items()})

    def text(self) -> bytes:
        """The content of rsegen-files.json: one line per file, sorted."""
        lines = [
            json.dumps({"file": name, "bytes": one.bytes, "sha256": one.sha256})
            for name, files in sorted(self.files.items())
            for one in files
        ]
        head = f'{{\n  "rsegen_files": {_FORMAT},\n  "content": {json.dumps(self.content)},\n  "files": ['
        return (head + ",".join(f"\n    {line}" for line in lines) + "\n  ]\n}\n").encode()


def read_record(folder: Path) -> Record | None:
    """The record of a folder, None if it has none or an empty one; FileError if it is damaged or not rsegen's."""
    path = folder / RECORD
    try:
        with open_regular(path) as file:
            text = file.read(_LARGEST)
        return _decoded(json.loads(text)) if text else None
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    except (ValueError, TypeError, KeyError, RecursionError, AttributeError):
        raise FileError(f"{path}: is not a record of rsegen, or is damaged") from None


def recorded(folder: Path) -> Record | None:
    """The record of a folder, None if it has none or a damaged one."""
    try:
        return read_record(folder)
    except FileError:
        return None


def written_file(path: Path) -> WrittenFile | None:
    """The size and checksum of a file; None if it does not exist. OSError if it is no regular file."""
    try:
        with open_regular(path) as file:
            return _measured(file)
    except (FileNotFoundError, NotADirectoryError):
        return None


def _measured(file: BinaryIO) -> WrittenFile:
    checksum = hashlib.sha256()
    while piece := file.read(_AT_ONCE):
        checksum.update(piece)
    return WrittenFile(bytes=file.tell(), sha256=checksum.hexdigest())


def _decoded(found: Mapping[str, object]) -> Record:
    """The record of a JSON text; ValueError, TypeError, KeyError or AttributeError if it is not one."""
    entries = found["files"]
    content = next((one for one in _CONTENTS if one == found["content"]), None)
    if found["rsegen_files"] != _FORMAT or content is None or not isinstance(entries, list):
        raise ValueError(found)
    files: dict[str, tuple[WrittenFile, ...]] = {}
    for entry in entries:
        name, size = _inside(entry["file"]), entry["bytes"]
        if not isinstance(size, int):
            raise ValueError(entry)
        files[name] = (*files.get(name, ()), WrittenFile(bytes=size, sha256=str(entry["sha256"])))
    return Record(content=content, files=files)


def _inside(name: str) -> str:
    """The path of a file in the folder; ValueError if it leads out of it."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or not path.parts or str(path) != name:
        raise ValueError(name)
    return name
