"""Files on the disk, and problems with them: every unit is old or new as a whole, and messages are true."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

Tree = Mapping[str, tuple[str, int, bytes]]
"""Path -> kind, permissions, and content or the link's target."""

JOURNALS = {".rsegen.jsonl"}
"""Files in which a run notes what it does: they are neither old nor new."""

_UNCHANGED = re.compile(
    r"nothing (was left|is left|has changed|changed|was changed|was written)( there)?|as (it was )?before"
)
_NAMED = re.compile(r"rsegen: (.*?): ")
_COMPLETE = re.compile(r"(\d+) of (\d+) maps (are|is) complete")
_MAP = re.compile(r"root/out/[^/]*_[0-9]{4}")


@dataclass(frozen=True, kw_only=True, slots=True)
class End:
    """End of a command: its exit code, or the signal that killed it; what it said, and what inject.c counted."""

    code: int | None
    signal: int
    stopped: bool
    err: str
    calls: int = 0
    by_workers: int = 0
    call: str = ""
    unsynced: tuple[tuple[int, int], ...] = ()

    @classmethod
    def of(cls, answer: Mapping[str, Any]) -> End:
        """That of a driver's answer."""
        unsynced = tuple((inode, size) for inode, size in answer.get("unsynced", ()))
        return cls(**{**answer, "unsynced": unsynced})


def tree(folder: Path) -> Tree:
    """Everything below a folder, hidden things too; links are not followed."""
    return dict(_entries(folder, ""))


def _entries(folder: Path, above: str) -> Iterator[tuple[str, tuple[str, int, bytes]]]:
    with os.scandir(folder) as entries:
        found = sorted(entries, key=lambda entry: entry.name)
    for entry in found:
        name, mode = above + entry.name, stat.S_IMODE(entry.stat(follow_symlinks=False).st_mode)
        if entry.is_symlink():
            yield name, ("link", 0, os.fsencode(os.readlink(entry.path)))
        elif entry.is_dir():
            yield name, ("folder", mode, b"")
            yield from _entries(Path(entry.path), f"{name}/")
        else:
            yield name, ("file", mode, Path(entry.path).read_bytes())


def is_hidden(path: str) -> bool:
    """Return whether a path is that of a hidden file or folder of rsegen, or in one."""
    return any(part.startswith(".rsegen") for part in PurePosixPath(path).parts)


def visible(files: Tree) -> Tree:
    """Without what is hidden, and without journals."""
    return {path: file for path, file in files.items() if not is_hidden(path) and _name(path) not in JOURNALS}


def journals(files: Tree) -> Tree:
    """Journals of what is complete."""
    return {path: file for path, file in files.items() if _name(path) in JOURNALS and not is_hidden(path[:-13])}


def differences(found: Tree, expected: Tree, most: int = 2) -> list[str]:
    """The first paths that differ, and how: those that are lost before those that are left over."""
    words = []
    for path in sorted(found.keys() | expected.keys(), key=lambda path: (path not in expected, path)):
        if found.get(path) != expected.get(path):
            how = "is missing" if path not in found else "is left over" if path not in expected else "has changed"
            words.append(f"{path} {how}")
    return words[:most] + ([f"and {len(words) - most} more"] if len(words) > most else [])


def neither_old_nor_new(
    now: Tree, before: Tree, whole: Tree, depth: int, *, gaps: bool = False, named: str = ""
) -> Iterator[str]:
    """Every unit that is neither that of before nor that of an undisturbed run.

    depth: see Run   gaps: a folder that is replaced may be missing, as on a disk that cannot exchange two folders
    named: a message; what it names may be missing too
    """
    old, new, found = (_units(files, depth) for files in (before, whole, now))
    for unit in sorted(old.keys() | new.keys() | found.keys()):
        is_old, is_new = (found.get(unit) == state.get(unit) for state in (old, new))
        is_folder = bool(old.get(unit, {}).keys() - {unit})
        may_miss = is_folder and unit not in found and (gaps or unit in named)
        if not is_old and not is_new and not may_miss:
            what = "foreign thing" if old.get(unit) == new.get(unit) else "unit"
            near = min((differences(found.get(unit, {}), state.get(unit, {})) for state in (old, new)), key=len)
            yield f"{what} {unit} is neither old nor new: {', '.join(near)}"


def _units(files: Tree, depth: int) -> dict[str, dict[str, tuple[str, int, bytes]]]:
    """Visible files, by units: the first names of their paths, of which one is that of the output folder."""
    units: dict[str, dict[str, tuple[str, int, bytes]]] = {}
    for path, file in visible(files).items():
        parts = PurePosixPath(path).parts
        if len(parts) > 1 or file[0] != "folder":
            unit = "/".join(parts[: 1 + depth] if parts[0] == "out" else parts[:1])
            if len(parts) > depth or file[0] != "folder":  # a folder of units is none
                units.setdefault(unit, {})[path] = file
    return units


def wrong_end(end: End, before: Tree, now: Tree, whole: Tree, *, interrupted: bool) -> Iterator[str]:
    """Problems with an exit code, with what was said, and with what was left after it."""
    if end.signal:
        yield from ["does not end"] if end.signal < 0 else []
        return
    if end.code not in ((0, 130) if interrupted else (0, 1, 2)):
        yield f"exit code {end.code}: {end.err.strip()[:200]}"
    yield from _wrong_words(end)
    if end.code == 0 and (wrong := differences(visible(now), visible(whole))):
        yield f"exit code 0, but {', '.join(wrong)}"
    if end.code == 2 and (wrong := differences(now, before)):
        yield f"exit code 2, but {', '.join(wrong)}: {end.err.strip()[:200]}"
    if wrong := list(_false_words(end.err, visible(before), visible(now), visible(whole))):
        yield f"a false message, as {', '.join(wrong)}: {end.err.strip()[:200]}"


def _wrong_words(end: End) -> Iterator[str]:
    """Problems with the form of what was said."""
    lines = end.err.count("\n")
    if end.code and (lines != 1 or not end.err.startswith("rsegen")):
        yield f"not one line on stderr, but {lines}: {end.err[-300:]!r}"
    if "Traceback" in end.err or "internal error" in end.err:
        yield f"a mistake in rsegen: {end.err.strip()[-300:]}"


def _false_words(err: str, before: Tree, now: Tree, whole: Tree) -> Iterator[str]:
    """Statements of messages that are not so: that nothing has changed, everywhere or at a place that it names."""
    named = _NAMED.match(err)
    if said := _UNCHANGED.search(err):
        place = "root/" + named[1].rpartition("/root/")[2] if named and said[2] else "root"
        yield from differences(_at(now, place), _at(before, place))
    maps = [path for path in whole if _MAP.fullmatch(path)]
    if maps and (counted := _COMPLETE.search(err)):
        complete = sum(_at(now, path) == _at(whole, path) for path in maps)
        others = len(maps) - int(counted[2])  # maps in the folder that the run does not make
        stuck = sum(path.removeprefix("root/") in err.partition("could not be put back")[2] for path in maps)
        if not any(0 <= complete - int(counted[1]) - each <= stuck for each in (0, others)):
            yield f"{complete} maps are complete"


def _at(files: Tree, place: str) -> Tree:
    return {path: file for path, file in files.items() if path == place or path.startswith(f"{place}/")}


def left_hidden(files: Tree) -> list[str]:
    """Hidden things of rsegen other than its journals."""
    return [path for path in files if is_hidden(path) and _name(path) not in JOURNALS]


def _name(path: str) -> str:
    return path.rpartition("/")[2]
