"""Paths that pages give, and what folders hold: all lead into the folder of the host, or to a file that a page sent."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

from rsegen.errors import FileError, ParameterError, shown, system_reason
from rsegen.page.model.document import SUFFIXES

HOLDS: Mapping[str, Literal["drive", "dataset", "recipe"]] = {
    "drive.json": "drive",
    "manifest.json": "dataset",
    "recipe.json": "recipe",
}
"""The files by which a page knows what a folder holds."""

MOST = 1000
"""Entries of a folder that are listed: a page shows a list of some hundred."""

_MADE = ("drive.json", "manifest.json", "summary.json")
"""Files of ours that are no recipes though their names end as those of recipes do."""


class Places(NamedTuple):
    """The folder in which pages read and write, and the folder of files that they sent, if any."""

    folder: Path
    sent: Path | None = None

    def inside(self, text: str) -> Path:
        """Return a path that a page gives, with no link in it; a FileError if it leads elsewhere or is hidden."""
        if "\0" in text:
            raise FileError("a path must not contain a NUL character")
        try:
            path = (self.folder / text).resolve()
            path.exists()  # so that a name that no disk can have is refused here
        except RuntimeError as error:  # a loop of links
            raise FileError(f"{shown(text)}: {error}") from None
        except OSError as error:
            raise FileError(f"{shown(text)}: {system_reason(error)}") from None
        for folder in (self.folder.resolve(), *([self.sent.resolve()] if self.sent else [])):
            if path.is_relative_to(folder):
                if any(part.startswith(".") for part in path.relative_to(folder).parts):
                    raise FileError(f"{text}: is hidden; this page reads and writes only files that are not hidden")
                return path
        raise FileError(f"{text}: is outside {self.folder}, the folder that this page reads and writes")

    def relative(self, path: Path) -> Path:
        """Return a path as it is seen from the folder: relative if it is in it."""
        folder = self.folder.resolve()
        return path.relative_to(folder) if path.is_relative_to(folder) else path

    def refuse_outside(self, name: str, text: str) -> str:
        """Return what may be a word, numbers, or a file with arguments; a ParameterError for a file elsewhere."""
        if re.fullmatch(r"[0-9.,]*", text):
            return text
        try:
            path, *arguments = shlex.split(text) or [""]
            if not all(":=" in argument for argument in arguments):
                path, arguments = text, []  # a name with blanks
            if "/" not in path and "." not in Path(path).name[1:]:
                return text
            place = str(self.inside(path))
        except (FileError, ValueError) as error:  # a quotation mark that is not closed
            raise ParameterError(name, str(error)) from None
        return shlex.join([place, *arguments]) if arguments else place


def names_in(folder: Path) -> Iterator[str]:
    """Yield up to `MOST` names in a folder, sorted, hidden ones and those that lead outside it left out."""

    def stays(entry: os.DirEntry[str]) -> bool:
        try:
            return not entry.is_symlink() or bool(Places(folder).inside(entry.name))
        except FileError:
            return False

    try:
        with os.scandir(folder) as entries:
            shown = sorted(entry.name for entry in entries if not entry.name.startswith(".") and stays(entry))
    except OSError as error:
        raise FileError(f"{folder}: {system_reason(error)}") from None
    yield from shown[:MOST]


Kind = Literal["recipe", "folder", "dataset", "drive", "other"]
"""Kind of a file or folder, as the page treats it."""


def kind_of(path: Path) -> Kind:
    """Return what a file or folder is for a page: a recipe, a data set, a drive, another folder, or anything else."""
    if not path.is_dir():
        return "recipe" if path.suffix.lower() in SUFFIXES and path.name not in _MADE else "other"
    return next((kind for name, kind in HOLDS.items() if os.path.isfile(path / name)), "folder")
