"""What installed packages offer to rsegen, by the entry points that they declare: found without importing anything.

    [project.entry-points."rsegen.obstacles"]
    ramp = "rsegen_ramps:Ramp"

`importlib.metadata` takes as long as numpy's half to be imported, so it is asked only about packages that have such.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from rsegen.params.plugins import Source


@dataclass(frozen=True, kw_only=True, slots=True)
class EntryPoint:
    """One line of a package: under which name it offers what to rsegen."""

    group: str
    name: str
    value: str
    source: Source

    def __str__(self) -> str:
        return f"plug-in {self.name!r} of {self.source} ({self.value})"

    def load(self) -> Any:
        """What it offers; raises whatever its module raises."""
        module, _, place = self.value.partition(":")
        found: Any = import_module(module.strip())
        for part in filter(None, place.strip().split(".")):
            found = getattr(found, part)
        return found


@cache
def entry_points() -> tuple[EntryPoint, ...]:
    """All that installed packages offer to rsegen, by their names."""
    found = (each for folder in _packages() for each in _of(folder))
    return tuple(sorted(found, key=lambda each: (each.group, each.name, str(each.source))))


def _packages() -> Iterator[Path]:
    """The folders of metadata that speak of rsegen; of two of one package the first on the path counts."""
    seen = set()
    for place in dict.fromkeys(sys.path):
        for entry in _metadata(place or "."):
            package = re.sub(r"[-_.]+", "-", os.path.splitext(entry.name)[0].partition("-")[0]).lower()
            if package not in seen and _speaks(entry.path):
                yield Path(entry.path)
            seen.add(package)


def _metadata(place: str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(place) as entries:
            found = [each for each in entries if each.name.endswith((".dist-info", ".egg-info"))]
    except OSError:  # most paths hold no packages, and some are not there
        return []
    return sorted(found, key=lambda each: each.name)


def _speaks(folder: str) -> bool:
    try:
        with open(os.path.join(folder, "entry_points.txt"), "rb") as file:
            return b"[rsegen." in file.read()
    except OSError:
        return False


def _of(folder: Path) -> Iterator[EntryPoint]:
    from importlib.metadata import Distribution

    package = Distribution.at(folder)
    source = Source(name=package.metadata["Name"] or folder.name.partition("-")[0], version=package.version or "0")
    for each in package.entry_points:
        if each.group.startswith("rsegen."):
            yield EntryPoint(group=each.group, name=each.name, value=each.value, source=source)
