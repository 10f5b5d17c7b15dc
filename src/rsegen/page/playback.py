"""Drives that were recorded, for a page to play: where each robot was, and what happened to it.

A folder of `rsegen drive` has a trajectory and the contacts of each robot. What happens is found in them: a part that
seldom touches anything begins to, the robot falls, tips over, or crosses the map. The folder may come from anybody.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rsegen.errors import FileError
from rsegen.field.stepfield import Array
from rsegen.io.input_files import text_of
from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.page.places import Places
from rsegen.simulation.driving.drive_metrics import COLUMNS, TIPPED, Trajectory

_MIB = 32
"""The largest file of a drive that is read, MiB: an hour of one robot's trajectory is 4."""

_ROBOTS, _EVENTS = 100, 300
"""Robots of a drive, and events of a robot, at most."""

_SELDOM = 0.5
"""Share of the samples up to which the contacts of a part are news: wheels and tracks have more."""

_FALL, _WITHIN = 0.03, 0.2
"""Metres by which a robot comes down within some seconds in a fall: on a slope of 30 degrees it takes twice as long."""


@call_of_host
def playback(host: Host, *, path: str) -> dict[str, Any]:
    """Return the drive that a folder holds."""
    folder = host.places.inside(path)
    drive = _drive(folder)
    robots = [_robot(folder, each) for each in drive["robots"][:_ROBOTS]]
    return {
        "title": ", ".join(str(drive.get(name, "")) for name in ("map", "route") if drive.get(name)),
        "simulator": str(drive.get("simulator", "")),
        "robots": robots,
        "duration": max((robot["seconds"][-1] for robot in robots), default=0.0),
    }


def _drive(folder: Path) -> dict[str, Any]:
    """Return the content of drive.json; a FileError if it is not that of a drive."""
    file = folder / "drive.json"
    try:
        drive = json.loads(text_of(file, _MIB, "a drive"))
    except (ValueError, RecursionError):
        drive = None
    robots = drive.get("robots") if isinstance(drive, dict) else None
    named = isinstance(robots, list) and all(
        isinstance(each, dict) and isinstance(each.get("name"), str) and isinstance(each.get("kind"), str)
        for each in robots
    )
    if not isinstance(drive, dict) or not named:
        raise FileError(f"{file}: not the drive.json of rsegen drive")
    return drive


def _robot(folder: Path, robot: Mapping[str, Any]) -> dict[str, Any]:
    name = robot["name"]
    trajectory = _trajectory(Places(folder).inside(f"{name}.csv"))
    events = sorted([*_contacts(folder, robot), *_falls(trajectory), *_marks(robot, trajectory)])
    return {
        "name": name,
        "robot": robot["kind"],
        "seconds": trajectory.rows[:, 0].tolist(),
        "poses": trajectory.rows[:, 1:].tolist(),
        "events": [{"second": second, "text": text} for second, text in events[:_EVENTS]],
    }


def _trajectory(file: Path) -> Trajectory:
    """Return a trajectory without rows that are no numbers; a FileError for a file that has none."""
    rows = [row for row in csv.reader(io.StringIO(text_of(file, _MIB, "a trajectory"))) if row]
    if not rows or tuple(rows[0]) != COLUMNS:
        raise FileError(f"{file}: not a trajectory of rsegen drive, whose columns are {','.join(COLUMNS)}")
    try:
        values = np.array([[float(each) for each in row] for row in rows[1:]], np.float64).reshape(-1, len(COLUMNS))
    except ValueError:
        raise FileError(f"{file}: has a row that is not {len(COLUMNS)} numbers") from None
    kept = values[np.isfinite(values).all(axis=1)]
    if not len(kept) or (np.diff(kept[:, 0]) < 0).any():
        raise FileError(f"{file}: has no poses in the order of time")
    return Trajectory(rows=kept)


def _contacts(folder: Path, robot: Mapping[str, Any]) -> Iterator[tuple[float, str]]:
    """Yield when a part that seldom touches anything begins to touch something."""
    file, shares = Places(folder).inside("contacts.csv"), robot.get("touched")
    if not file.is_file() or not isinstance(shares, dict):
        return
    news = {part for part, share in shares.items() if isinstance(share, int | float) and share < _SELDOM}
    before: set[tuple[str, str]] = set()
    for second, touching in _samples(file, robot["name"]):
        now = {(part, other) for part, other in touching if part in news}
        yield from ((second, f"{part} touches {other}") for part, other in sorted(now - before))
        before = now


def _samples(file: Path, robot: str) -> Iterator[tuple[float, set[tuple[str, str]]]]:
    """Yield each time at which anything has contact, and what of a robot touches what then."""
    second, touching = None, set[tuple[str, str]]()
    for row in csv.DictReader(io.StringIO(text_of(file, _MIB, "contacts"))):
        try:
            now = float(row["t"])
            known = row["robot"], (row["part"], row["other"])
        except (KeyError, TypeError, ValueError):
            raise FileError(f"{file}: not the contacts.csv of rsegen drive") from None
        if second is not None and now != second:
            yield second, touching
            touching = set()
        second = now
        if known[0] == robot:
            touching.add(known[1])
    if second is not None:
        yield second, touching


def _falls(trajectory: Trajectory) -> Iterator[tuple[float, str]]:
    """Yield when a robot comes down faster than it drives down, and by how much."""
    seconds, z = trajectory.rows[:, 0], trajectory.rows[:, 3]
    ahead = np.minimum(np.searchsorted(seconds, seconds + _WITHIN, side="right"), len(z)) - 1
    falls = z - z[ahead] > _FALL
    for at in _begins(falls):
        until = at + int(np.argmin(np.append(falls[at:], False)))
        yield float(seconds[at]), f"falls by {100 * (z[at] - z[at : ahead[until - 1] + 1].min()):.0f} cm"


def _begins(which: Any) -> list[int]:
    starts: Array = which & ~np.append(False, which[:-1])
    return [int(at) for at in np.flatnonzero(starts)]


def _marks(robot: Mapping[str, Any], trajectory: Trajectory) -> Iterator[tuple[float, str]]:
    """Yield when a robot tips over, and when it has crossed the map."""
    yield from ((float(trajectory.rows[at, 0]), "tips over") for at in _begins(trajectory.tilt > TIPPED))
    crossed = robot.get("crossed")
    if isinstance(crossed, int | float) and not isinstance(crossed, bool):
        yield float(crossed), "has crossed the map"
