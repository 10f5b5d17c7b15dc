"""Folders without a record: what rsegen 0.1 wrote is known by its names, if the file that marks it is in order."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from rsegen.io.input_files import regular_content
from rsegen.io.record import Content

_LARGEST = 64 * 2**20

_OF_A_MAP = r"recipe\.json|levels\.csv|model\.(config|sdf)|formats\.json|preview\.png|sheet\.(csv|pdf)"

_OF_FILES = {
    "series.csv": (b"number,map,", ("series.csv", "series.png")),
    "results.jsonl": (b'{"plan":', ("results.jsonl", "table.md", "trials.csv", "summary.json", "plot.png")),
}
"""The file that marks a series and an experiment, how it begins, and what else belongs to it."""


def former_files(folder: Path, content: Content) -> Callable[[str], bool]:
    """Whether rsegen 0.1 wrote a file of this path into a folder, if that holds what `content` says."""
    found = {"map": _of_a_map, "drive": _of_a_drive, "files": _of_files}[content](folder)
    return lambda name: found is not None and re.fullmatch(found, name) is not None


def _of_a_map(folder: Path) -> str | None:
    """The names of a map's files as a pattern; formats are those that formats.json lists. None if it is no map."""
    recipe = regular_content(folder / "recipe.json", _LARGEST)
    if recipe is None or (folder / "drive.json").exists():
        return None
    if recipe and not str(_parsed(recipe).get("generator")).startswith("rsegen "):
        return None
    name = re.escape(folder.name)
    formats = "|".join(re.escape(each) for each in _parsed(regular_content(folder / "formats.json", _LARGEST) or b""))
    return rf"{_OF_A_MAP}|{name}\.world|meshes/{name}[^/]*\.(obj|mtl)" + (rf"|({formats})/.*" if formats else "")


def _of_a_drive(folder: Path) -> str | None:
    robots = _parsed(regular_content(folder / "drive.json", _LARGEST) or b"").get("robots")
    if not isinstance(robots, list):
        return None
    names = "|".join(re.escape(str(each.get("name"))) for each in robots if isinstance(each, dict))
    return rf"recipe\.json|drive\.(json|png)|gazebo\.jpg|(contacts|{names})\.csv"


def _of_files(folder: Path) -> str | None:
    found = [
        re.escape(name)
        for mark, (begins, names) in _OF_FILES.items()
        if (regular_content(folder / mark, len(begins)) or b"").startswith(begins)
        for name in names
    ]
    return "|".join(found) or None


def _parsed(text: bytes) -> Mapping[str, object]:
    """A JSON object, empty if it is none."""
    try:
        found = json.loads(text or b"{}")
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
