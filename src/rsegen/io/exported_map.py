"""What is known of a map once it is exported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportedMap:
    """One map in other formats on disk: its folder, and the names of the files that were written into it."""

    folder: Path
    names: tuple[str, ...]
