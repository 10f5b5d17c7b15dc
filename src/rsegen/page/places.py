"""Paths that pages give: all of them lead into one folder, however they are written."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from rsegen.errors import FileError, ParameterError


def inside(folder: Path, text: str) -> Path:
    """Return a path below a folder, seen from there; a FileError if it leads elsewhere, also by a link."""
    if not isinstance(text, str) or "\0" in text:
        raise FileError("a path is a text without zero bytes")
    root = folder.resolve()
    try:
        return (root / text).resolve().relative_to(root)
    except (OSError, RuntimeError, ValueError):  # a loop of links; not below
        raise FileError(f"{text}: is outside {root}, the folder that this page reads and writes") from None


def refuse_outside(name: str, text: str, folder: Path) -> str:
    """Return what may be a word, numbers, or a file with arguments; a ParameterError for a file outside a folder."""
    if re.fullmatch(r"[0-9.,]*", text):
        return text
    try:
        path, *arguments = shlex.split(text) or [""]
        if not all(":=" in each for each in arguments):
            path, arguments = text, []  # a name with blanks
        if "/" not in path and "." not in Path(path).name[1:]:
            return text
        place = str(folder.resolve() / inside(folder, path))
    except (FileError, ValueError) as error:  # ValueError: a quotation mark that is not closed
        raise ParameterError(name, str(error)) from None
    return shlex.join([place, *arguments]) if arguments else place
