"""The files of the folder that pages may read and write: nothing outside it, however it is named."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rsegen.errors import FileError
from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.page.places import HOLDS, Places

MOST = 1000
"""Entries of a folder that are listed: a page shows a list of some hundred."""

_RECIPES = (".yaml", ".yml", ".json")


def names_in(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Yield up to `MOST` entries of a folder, by name, hidden ones and those that lead outside it left out."""
    try:
        with os.scandir(folder) as entries:
            shown = sorted((each for each in entries if not each.name.startswith(".")), key=lambda each: each.name)
    except OSError as error:
        raise FileError(f"{folder}: {error.strerror}") from None
    yield from [each for each in shown if not each.is_symlink() or _stays(folder, each.name)][:MOST]


def _stays(folder: Path, name: str) -> bool:
    try:
        Places(folder).inside(name)
    except FileError:
        return False
    return True


def kind_of(path: Path) -> str:
    """Return what a file or folder is for a page: a recipe, a data set, a drive, another folder, or anything else."""
    if not path.is_dir():
        return "recipe" if path.suffix.lower() in _RECIPES and path.name not in _MADE else "other"
    return next((kind for name, kind in HOLDS.items() if (path / name).is_file()), "folder")


_MADE = ("drive.json", "manifest.json", "summary.json")
"""Files of ours that are no recipes though their names end as those of recipes do."""


@call_of_host
def files(host: Host, *, folder: str = "") -> dict[str, Any]:
    """List a folder: recipes, folders of maps with their recipe, data sets, drives, folders and other files."""
    place = host.places.inside(folder)
    below = host.places.seen(place)
    entries = [
        {"name": each.name, "path": str(below / each.name), "kind": kind_of(place / each.name)}
        for each in names_in(place)
    ]
    return {"folder": "" if below == Path() else str(below), "entries": entries}
