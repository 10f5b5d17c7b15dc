"""Drives that were recorded, for a page to play: where each robot was, and what happened to it.

A folder of `rsegen drive` has a trajectory and the contacts of each robot. A mark is made where a person would look:

    contact   a part that seldom touches anything touches something, for the first time or after a pause
    fall      it comes down faster than it drives down
    hang-up   it stays at its place for two seconds or more, upright and before it has crossed the map
    tip, end  it tips over; it has crossed the map

A contact is a small mark, an outcome (trouble, or the success at the end) a large one.

A body that scrapes along, or bounces, is one mark, not one for each sample. What breaks it: a wheel that is in the air
for more than half of the drive counts as a part that seldom touches. The folder may come from anybody.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any, Literal, TypedDict

import numpy as np

from rsegen.driving.drive_metrics import COLUMNS, STILL, TIPPED, Trajectory, moves_by_window
from rsegen.driving.planning import predictions
from rsegen.driving.prediction import Prediction
from rsegen.errors import FileError
from rsegen.field.stepfield import Mask
from rsegen.input_files import text_of
from rsegen.page.calls import call_of_host
from rsegen.page.host import Host
from rsegen.page.places import Places
from rsegen.params.watch import watched
from rsegen.robots.page import Across, robot_of_page, scene_of_document
from rsegen.standing.draping import draped

_MIB = 32
"""The largest file of a drive that is read, MiB: an hour of one robot's trajectory is 4."""

_ROBOTS, _EVENTS = 100, 300
"""Robots of a drive, and events of a robot, at most: if there are more, contacts are left out first."""

_SELDOM = 0.5
"""Share of the samples up to which the contacts of a part are news: wheels and tracks have more."""

_PAUSE = 2.0
"""Seconds without a contact of a part after which its next one is news: two to eight samples, and longer than a body
takes to bounce over an edge."""

_FALL, _WITHIN = 0.03, 0.2
"""Metres by which a robot comes down within some seconds in a fall: on a slope of 30 degrees it takes twice as long."""


class Mark(TypedDict):
    """An event of a robot."""

    second: float
    text: str
    kind: Literal["contact", "trouble", "success"]


class PlayedRobot(TypedDict):
    """A robot of a drive, with what happened to it in order of time."""

    name: str
    robot: str
    seconds: list[float]
    poses: list[list[float]]  # x y z roll pitch yaw
    events: list[Mark]


class Playback(TypedDict):
    """A drive that was recorded."""

    title: str
    simulator: str
    robots: list[PlayedRobot]
    duration: float


@call_of_host
def playback(host: Host, *, path: str) -> Playback:
    """Return the drive that a folder holds."""
    folder = host.places.inside(path)
    drive = _drive(folder)
    robots = [_robot(folder, name) for name in drive["robots"][:_ROBOTS]]
    return {
        "title": ", ".join(str(drive.get(name, "")) for name in ("map", "route") if drive.get(name)),
        "simulator": str(drive.get("simulator", "")),
        "robots": robots,
        "duration": max((robot["seconds"][-1] for robot in robots), default=0.0),
    }


class DrawnEnd(TypedDict):
    """A place where drives that do not cross end."""

    reason: str  # in words that follow "the robot"
    x: float
    y: float
    drives: int


class CrossingOfSide(TypedDict):
    """A prediction of whether a robot gets from one side of a map to the other."""

    name: str  # "west to east"
    probability: float
    crossed: int
    drives: int
    seconds: float | None  # until it is across, in the middle; null: no drive crosses
    ends: list[DrawnEnd]  # the most frequent first


class DrawnCrossing(TypedDict):
    """A prediction of whether a robot gets across a map, with its drives."""

    text: str  # why nothing is predicted, else empty
    simulator: str  # with the model of motors
    sides: list[CrossingOfSide]
    ways: list[Across]  # of each drive: it crosses, or ends where the robot stayed


@call_of_host
def crossing(host: Host, *, doc: str, index: int, robot: str) -> DrawnCrossing:
    """Return how surely a robot gets across a map, with all its drives."""
    with host.opened(doc).newest_turn("crossing") as watch, watched(lambda step, share: watch(share, step)):
        scene = scene_of_document(host, doc, index)
        predicted = predictions(robot_of_page(host, robot), scene)
    named = {side.replace("_", " to "): prediction for side, prediction in predicted.items()}
    simulators = {f"{prediction.simulator}, {prediction.motors} motors" for prediction in named.values()}
    return {
        "text": "" if named else "MuJoCo is not installed, so it cannot be driven here",
        "simulator": "; ".join(sorted(simulators)),
        "sides": [_crossing_of_side(name, prediction) for name, prediction in named.items()],
        "ways": [
            {"points": draped(scene.field, outcome.path).tolist(), "name": name, "crosses": not outcome.reason}
            for name, prediction in named.items()
            for outcome in prediction.outcomes
        ],
    }


def _crossing_of_side(name: str, prediction: Prediction) -> CrossingOfSide:
    return {
        "name": name,
        "probability": prediction.probability,
        "crossed": prediction.crossed,
        "drives": prediction.drives,
        "seconds": prediction.seconds,
        "ends": [{"reason": end.reason, "x": end.x, "y": end.y, "drives": end.drives} for end in prediction.ends],
    }


def _drive(folder: Path) -> dict[str, Any]:
    """Return the content of drive.json; a FileError if `rsegen drive` did not write it."""
    file = folder / "drive.json"
    try:
        drive = json.loads(text_of(file, _MIB, "a drive"))
    except (ValueError, RecursionError):
        drive = None
    robots = drive.get("robots") if isinstance(drive, dict) else None
    named = isinstance(robots, list) and all(
        isinstance(robot, dict) and isinstance(robot.get("name"), str) and isinstance(robot.get("kind"), str)
        for robot in robots
    )
    if not isinstance(drive, dict) or not named:
        raise FileError(f"{file}: not the drive.json of rsegen drive")
    return drive


def _robot(folder: Path, robot: Mapping[str, Any]) -> PlayedRobot:
    name = robot["name"]
    trajectory = _trajectory(Places(folder).inside(f"{name}.csv"))
    touches = list(_touches(folder, robot))
    tips = ((float(trajectory.rows[at, 0]), "tips over") for at, _ in _runs(trajectory.tilt > TIPPED))
    outcome = [*_falls(trajectory), *_hang_ups(robot, trajectory, touches), *tips]
    # The most important first: if they are too many, those at the end are left out.
    events: list[tuple[float, str, Literal["contact", "trouble", "success"]]] = [
        *((second, "has crossed the map", "success") for second in [_crossed(robot)] if second < inf),
        *((second, text, "trouble") for second, text in outcome),
        *((second, text, "contact") for second, text in _contacts(touches)),
    ]
    return {
        "name": name,
        "robot": robot["kind"],
        "seconds": trajectory.rows[:, 0].tolist(),
        "poses": trajectory.rows[:, 1:].tolist(),
        "events": [{"second": second, "text": text, "kind": kind} for second, text, kind in sorted(events[:_EVENTS])],
    }


def _trajectory(file: Path) -> Trajectory:
    """Return a trajectory without its rows that are not finite; a FileError for a file that has no trajectory."""
    rows = [row for row in csv.reader(io.StringIO(text_of(file, _MIB, "a trajectory"))) if row]
    if not rows or tuple(rows[0]) != COLUMNS:
        raise FileError(f"{file}: not a trajectory of rsegen drive, whose columns are {','.join(COLUMNS)}")
    try:
        values = np.array([[float(cell) for cell in row] for row in rows[1:]], np.float64).reshape(-1, len(COLUMNS))
    except ValueError:
        raise FileError(f"{file}: has a row that is not {len(COLUMNS)} numbers") from None
    finite = values[np.isfinite(values).all(axis=1)]
    if not len(finite) or (np.diff(finite[:, 0]) < 0).any():
        raise FileError(f"{file}: has no poses in the order of time")
    return Trajectory(rows=finite)


_Touch = tuple[float, str, str]
"""Time of a contact, seconds, the part, and what it touched."""


def _touches(folder: Path, robot: Mapping[str, Any]) -> Iterator[_Touch]:
    """Yield the contacts of parts that seldom touch anything, in the order of time."""
    file, shares = Places(folder).inside("contacts.csv"), robot.get("touched")
    if not file.is_file() or not isinstance(shares, dict):
        return
    seldom = {part for part, share in shares.items() if isinstance(share, int | float) and share < _SELDOM}
    touches = set[_Touch]()
    for row in csv.DictReader(io.StringIO(text_of(file, _MIB, "contacts"))):
        try:
            touch = float(row["t"]), row["part"], row["other"]
            is_its = row["robot"] == robot["name"]
        except (KeyError, TypeError, ValueError):
            raise FileError(f"{file}: not the contacts.csv of rsegen drive") from None
        if is_its and row["part"] in seldom:
            touches.add(touch)
    yield from sorted(touches)


def _contacts(touches: Sequence[_Touch]) -> Iterator[tuple[float, str]]:
    """Yield when a part touches something for the first time, and after each pause."""
    last: dict[str, float] = {}
    for second, part, touched in touches:
        if second - last.get(part, -inf) > _PAUSE:
            yield second, f"{part} touches {touched}"
        last[part] = second


def _falls(trajectory: Trajectory) -> Iterator[tuple[float, str]]:
    """Yield when a robot comes down faster than it drives down, and by how much."""
    seconds, z = trajectory.rows[:, 0], trajectory.rows[:, 3]
    # For each row the last one within that time.
    ahead = np.minimum(np.searchsorted(seconds, seconds + _WITHIN, side="right"), len(z)) - 1
    for at, until in _runs(z - z[ahead] > _FALL):
        yield float(seconds[at]), f"falls by {100 * (z[at] - z[at : ahead[until - 1] + 1].min()):.0f} cm"


def _runs(which: Mask) -> Iterator[tuple[int, int]]:
    """Yield where each run of true values begins, and where it has ended."""
    edges = np.flatnonzero(np.diff(which, prepend=False, append=False)).tolist()
    return zip(edges[::2], edges[1::2], strict=True)


_HELD = 2
"""Windows of a second in which a robot that hangs up does not move: in one it may turn, or swing its flippers."""


def _hang_ups(
    robot: Mapping[str, Any], trajectory: Trajectory, touches: Sequence[_Touch]
) -> Iterator[tuple[float, str]]:
    """Yield when a robot begins to stay at its place, and the parts on which it rests then."""
    t, x, y = trajectory.rows[:, :3].T
    lengths, moves = moves_by_window(t, x, y)
    begins = t[0] + np.append(0.0, lengths.cumsum())
    upright = np.interp(begins[:-1], t, trajectory.tilt) < TIPPED
    held = (moves < STILL) & upright & (begins[:-1] < _crossed(robot))
    for at, until in _runs(held):
        if until - at >= _HELD:
            parts = sorted({part for second, part, _ in touches if begins[at] <= second < begins[until]})
            yield float(begins[at]), f"hangs up on {' and '.join(parts)}" if parts else "is stuck"


def _crossed(robot: Mapping[str, Any]) -> float:
    """Return when a robot has crossed the map, infinity if it never has."""
    crossed = robot.get("crossed")
    return float(crossed) if isinstance(crossed, int | float) and not isinstance(crossed, bool) else inf
