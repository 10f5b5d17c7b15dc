"""What lies in the folder of a data set already: only files of that data set are replaced."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

from rsegen.errors import OutputError
from rsegen.io.contents import refuse_link
from rsegen.io.dataset.manifest import MANIFEST, RECORD
from rsegen.io.existing import OnExisting
from rsegen.io.input_files import regular_content
from rsegen.io.staging import HIDDEN

_SHARDS = re.compile(r"levels-[0-9]{5,}\.npy|metrics-[0-9]{5,}\.(npy|parquet)")
_BEGIN = {MANIFEST: b'{\n  "dataset":', RECORD: b'{"dataset":'}
_LARGEST = 256 * 2**20


def refuse_taken(folder: Path, on_existing: OnExisting) -> None:
    """Raise an OutputError if the folder holds anything that may be neither kept nor replaced."""
    names = sorted(os.listdir(folder)) if folder.is_dir() else []
    marks = [name for name in _BEGIN if name in names]
    if not marks and not all(map(HIDDEN.fullmatch, names)):
        raise OutputError(f"{folder}: is not empty, and not a data set of rsegen; give another folder")
    if marks and on_existing is OnExisting.REFUSE:
        raise OutputError(
            f"{folder}: a data set exists there already; give --resume to continue it, --force to replace it, or "
            "another folder"
        )
    for name in marks:
        _refuse_other(folder / name, _BEGIN[name])
    own = own_names(folder)
    for path in (folder / name for name in names if _SHARDS.fullmatch(name)):
        refuse_link(path)
        if path.name not in own or not path.is_file():
            raise OutputError(f"{path}: is not of the data set in this folder; move it away, or give another folder")


def own_names(folder: Path) -> set[str]:
    """The names of the files of shards in a folder: all that its manifest lists.

    A run that was stopped may have written more than its record lists: with a record, all with names of shards.
    """
    if (folder / RECORD).is_file():
        return set(filter(_SHARDS.fullmatch, os.listdir(folder)))
    return set(filter(_SHARDS.fullmatch, _names(_parsed(_content(folder / MANIFEST)))))


def _refuse_other(path: Path, begin: bytes) -> None:
    """Raise an OutputError if a file is a link, or was not written by rsegen: the run would replace it."""
    refuse_link(path)
    content = _content(path)
    if not path.is_file() or content[: len(begin)] != begin[: len(content)]:
        raise OutputError(f"{path}: was not written by rsegen; move it away, or give another folder")


def _names(found: object) -> Iterator[str]:
    """The names of files in a piece of a manifest or record."""
    if isinstance(found, dict):
        if isinstance(found.get("file"), str):
            yield found["file"]
        found = list(found.values())
    for part in found if isinstance(found, list) else ():
        yield from _names(part)


def _content(path: Path) -> bytes:
    return regular_content(path, _LARGEST) or b""


def _parsed(text: bytes) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
