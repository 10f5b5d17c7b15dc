"""The size and SHA-256 checksum of a file, by which rsegen knows the files that it wrote."""

from __future__ import annotations

import builtins
import hashlib
from dataclasses import dataclass
from pathlib import Path

from rsegen.io.input_files import open_regular

JOURNAL = ".rsegen.jsonl"
"""The file of a folder that lists what rsegen wrote there, with sizes and checksums (rsegen.run.journal)."""

_AT_ONCE = 2**20


@dataclass(frozen=True, kw_only=True, slots=True)
class Checksum:
    """The size and SHA-256 checksum of one file."""

    bytes: int
    sha256: str

    @classmethod
    def of(cls, content: builtins.bytes) -> Checksum:
        """Return the checksum of a file with this content."""
        return cls(bytes=len(content), sha256=hashlib.sha256(content).hexdigest())


def checksum_of(path: Path) -> Checksum | None:
    """Return the checksum of a file, None if it does not exist; OSError if it is no regular file."""
    try:
        with open_regular(path) as file:
            found = hashlib.sha256()
            while piece := file.read(_AT_ONCE):
                found.update(piece)
            return Checksum(bytes=file.tell(), sha256=found.hexdigest())
    except (FileNotFoundError, NotADirectoryError):
        return None
