"""The trajectory of a robot, and its metrics: distance, crossing, time stuck, tilt, tips, climb and incidents.

All follow from rows of time, position and angles, the robot's size and speed, and the sides of the map, so a log,
another simulator or a real robot is measured in the same way; the definitions are in docs/driving.md. An incident is
what a distance alone would hide: the robot was off the map, or at a place or speed that no robot has. Every figure ends
before the first impossible row. Cost: linear in the rows. What breaks it: rows too far apart, as distance is then too
short and a tip may be missed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, inf, isfinite, radians
from typing import ClassVar

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.robots.links import Vector

TIPPED = radians(75)
"""Angle, radians, between a robot's upright and the vertical, beyond which it has tipped over.

With less, a robot that leans against a block would count; one that lies on its side has 90 degrees, less its shape.
"""

SLOW = 0.1
"""Share of its speed below which a robot is stuck in a second.

A robot that slips on an edge comes on by less; a robot that climbs, turns or waits for its flippers by more.
"""

STILL = 0.01
"""Distance from its first place, metres, up to which a robot counts as still: ten times the
resolution of Gazebo Classic's record."""

DEEP = 0.1
"""Metres below the ground at which no robot's origin can be: wheels sink by some mm, and the origin of a robot on
its back may be lower."""

FAST = 3.0
"""Times the commanded speed that a robot cannot go on for a second, beyond its own diagonal: one that slides is
faster for a moment, one that tips over moves its origin by its diagonal."""

FALLING = 5.0
"""Metres per second of a robot that falls or slides, beyond its own speed: from a block of 1.2 m."""

RESOLUTION = 0.05
"""Metres by which a place in a record may be off, besides."""

WINDOW = 1.0
"""Seconds over which a robot is too fast, or stuck."""

FALL = 0.3
"""Seconds at the start in which a robot falls to the ground; it would fall 0.4 m in them, and starts 5 mm above."""

COLUMNS = ("t", "x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trajectory:
    """The poses of a robot over time: rows of COLUMNS in seconds, metres and radians, shape (n, 7)."""

    rows: Array

    @property
    def tilt(self) -> Array:
        """Radians between the robot's upright and the vertical, shape (n,)."""
        return np.asarray(np.arccos(np.clip(np.cos(self.rows[:, 4]) * np.cos(self.rows[:, 5]), -1, 1)))

    @property
    def has_tipped(self) -> bool:
        """Return whether the robot has tipped over at the end."""
        return bool(self.tilt[-1] > TIPPED)

    @property
    def is_still(self) -> bool:
        """Return whether the robot has stayed within a centimetre of its first place."""
        return bool(np.hypot(*(self.rows[:, 1:3] - self.rows[0, 1:3]).T).max() < STILL)

    def csv(self) -> Iterator[str]:
        """Yield the lines of a CSV file."""
        yield ",".join(COLUMNS) + "\n"
        for row in self.rows.tolist():
            yield ",".join(f"{round(value, 4) + 0:.4f}".rstrip("0").rstrip(".") for value in row) + "\n"


@dataclass(frozen=True, kw_only=True, slots=True)
class Course:
    """The map that a robot is driven over.

    extent: its sides along x and y, metres; top: the height of its highest block, metres
    finish_x: the x of a robot's origin beyond which the whole robot is east of the map, None on a route not across it
    starts_on_it: True if the robot starts on the map, and its first row may be too late to show that
    """

    extent: tuple[float, float] = (0.0, 0.0)
    top: float = 0.0
    finish_x: float | None = None
    starts_on_it: bool = False

    @classmethod
    def over(cls, field: StepField, finish_x: float | None = None) -> Course:
        """Return the course over a field."""
        return cls(extent=field.extent, top=float(field.heights.max()), finish_x=finish_x)


PLANE = Course()
"""The ground without a map."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Incident:
    """An event of a drive that the distance does not show, seconds after its start.

    kind: OFF, when its origin was off the map for the first time, or IMPOSSIBLE, when its figures end
    """

    OFF: ClassVar[str] = "off the map"
    IMPOSSIBLE: ClassVar[str] = "impossible"

    kind: str
    seconds: float
    reason: str

    def __str__(self) -> str:
        return f"{self.kind} after {self.seconds:g} s: {self.reason}"


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveMetrics:
    """Metrics of the drive of a robot, up to the first row that no robot can have.

    distance: length of the trajectory seen from above, metres
    crossed: seconds until the whole robot was beyond the map; None if it never was, or left the map or tipped over
    stuck: seconds; tipped: how often it tipped over; tilt: largest angle between its upright and the vertical, radians
    climbed: its highest place above the one on which it stood after the fall at the start, metres
    incidents: in the order of time
    touched: for each part, LINK::COLLISION, the share of samples with contacts; empty if the simulator reports none
    """

    seconds: float
    distance: float
    crossed: float | None
    stuck: float
    tipped: int
    tilt: float
    climbed: float
    incidents: tuple[Incident, ...]
    touched: Mapping[str, float]

    def has(self, kind: str) -> bool:
        """Return whether there is an incident of a kind."""
        return any(incident.kind == kind for incident in self.incidents)


def drive_metrics(
    trajectory: Trajectory,
    speed: float,
    size: Vector,
    course: Course = PLANE,
    touched: Mapping[str, float] | None = None,
) -> DriveMetrics:
    """Return the metrics of a trajectory of a robot of a size, metres, at a commanded speed, m/s, over a course."""
    drive, ending = possible_part(trajectory, speed, size, course)
    t, x, y, z = drive.rows[:, :4].T
    off, fallen = _off_the_map(drive, course), drive.tilt > TIPPED
    crossed, arrived = None, inf
    if course.finish_x is not None and (row := _first(x > course.finish_x)) is not None:
        arrived = _seconds(drive, row)
        crossed = None if fallen[: row + 1].any() or (off and off.seconds <= arrived) else arrived
    lengths, moves = moves_by_window(t, x, y)
    on_its_way = np.cumsum(lengths) - lengths < arrived  # then it waits for the others
    ground = int(z[t <= t[0] + FALL].argmin())  # it may start above the place on which it then stands
    return DriveMetrics(
        seconds=round(float(t[-1] - t[0]), 3),
        distance=round(float(np.hypot(np.diff(x), np.diff(y)).sum()), 3),
        crossed=crossed,
        stuck=round(float(lengths[(moves < SLOW * speed * lengths) & on_its_way].sum()), 3),
        tipped=int(fallen[0]) + int((np.diff(fallen.astype(int)) == 1).sum()),
        tilt=round(float(drive.tilt.max()), 3),
        climbed=round(float(z[ground:].max() - z[ground]) + 0.0, 3),  # no -0.0, as 0.0 is subtracted from -0.0
        incidents=tuple(incident for incident in (off, ending) if incident),
        touched=touched or {},
    )


def possible_part(
    trajectory: Trajectory, speed: float, size: Vector, course: Course = PLANE
) -> tuple[Trajectory, Incident | None]:
    """Return the rows before the first impossible one for a robot of a size, metres, and a speed, m/s, and why it is.

    One row at the origin if the very first is impossible; no incident if none is.
    """
    # Rows after one without a number are not looked at, so that sums have numbers.
    strange = _first(np.asarray(~np.isfinite(trajectory.rows).all(axis=1)))
    problems = [(strange, "its pose is no number")] if strange is not None else []
    rows = trajectory.rows[:strange]
    if len(rows):
        t, x, y, z = rows[:, :4].T
        diagonal = hypot(*size)
        # A model may have its origin above its shapes or below them, and so at its start above the blocks or below.
        low, high = min(0.0, float(z[0])) - DEEP, course.top + max(0.0, float(z[0])) + diagonal
        places = ((z < low, "below the ground"), (z > high, "above all blocks by more than its diagonal"))
        problems += [(row, reason) for claims, reason in places if (row := _first(claims)) is not None]
        problems += [*_too_fast(t, x, y, speed, diagonal), *_lost(rows, speed)]
    if not problems:
        return trajectory, None
    row, reason = min(problems, key=lambda problem: problem[0])
    incident = Incident(kind=Incident.IMPOSSIBLE, seconds=_seconds(trajectory, row), reason=reason)
    return Trajectory(rows=trajectory.rows[:row] if row else np.zeros((1, len(COLUMNS)))), incident


def _too_fast(t: Array, x: Array, y: Array, speed: float, diagonal: float) -> list[tuple[int, str]]:
    """Return the row at which a robot began to be faster than it can be, with the reason; empty if it never was."""
    # Metres along the path, and of these the ones in the last window before each row.
    path = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    within = path - np.interp(np.maximum(t - WINDOW, t[0]), t, path)
    late = _first(within > FAST * speed * WINDOW + diagonal)
    if late is None:
        return []
    # It began to be too fast at the first row in that window that is too far from the row before.
    steps = np.diff(path[: late + 1]) > FAST * speed * np.diff(t[: late + 1])
    row = int(np.flatnonzero(steps & (t[1 : late + 1] > t[late] - WINDOW))[0]) + 1
    return [(row, f"up to {within.max():.2f} m in {WINDOW:g} s, at a commanded {speed:g} m/s")]


def _lost(rows: Array, speed: float) -> Iterator[tuple[int, str]]:
    """Yield the rows at which the physics lost a robot, with the reasons: it has no pose, or jumped."""
    nowhere, has_moved = (rows[:, 1:] == 0).all(axis=1), np.logical_or.accumulate((rows[:, 3:] != 0).any(axis=1))
    # A robot on its way over the origin is there in one row, and is hardly ever quite level.
    if (row := _first(nowhere[:-1] & nowhere[1:] & has_moved[:-1])) is not None:
        yield row, "its pose became 0 0 0 0 0 0, which Gazebo Classic writes for one that is no number"
    jumps = np.linalg.norm(np.diff(rows[:, 1:4], axis=0), axis=1)
    most = (FAST * speed + FALLING) * np.diff(rows[:, 0]) + RESOLUTION
    if (row := _first(jumps > most)) is not None:
        yield row + 1, f"it jumped {jumps[row]:.2f} m in {rows[row + 1, 0] - rows[row, 0]:.3g} s"


def _off_the_map(trajectory: Trajectory, course: Course) -> Incident | None:
    """Return the incident of a robot that was next to the map on its way across, or left it on a random route."""
    _, x, y = trajectory.rows[:, :3].T
    half_x, half_y = (side / 2 for side in course.extent)
    between, beside = np.abs(x) < half_x, np.abs(y) > half_y
    if course.finish_x is not None:
        row = _first(between & beside)
    else:
        on_it = between & ~beside
        row = _first(~on_it & (np.logical_or.accumulate(on_it) | course.starts_on_it))
    if row is None:
        return None
    side = ("north" if y[row] > 0 else "south") if beside[row] else ("east" if x[row] > 0 else "west")
    return Incident(kind=Incident.OFF, seconds=_seconds(trajectory, row), reason=f"{side} of it")


def _seconds(trajectory: Trajectory, row: int) -> float:
    """Return the time of a row after the first one, 0 if it is no number."""
    seconds = float(trajectory.rows[row, 0]) - float(trajectory.rows[0, 0])
    return round(seconds, 3) if isfinite(seconds) else 0.0


def _first(claims: Mask) -> int | None:
    """Return the first row of which a claim is true, None if it is true of no row."""
    rows = np.flatnonzero(claims)
    return int(rows[0]) if len(rows) else None


def moves_by_window(t: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return the seconds of each WINDOW, of which the last may be shorter, and the metres from its begin to its end.

    So a robot that shakes in its place does not move, however long its path is.
    """
    marks = np.append(np.arange(t[0], t[-1] - 1e-6, WINDOW), t[-1])
    on_x, on_y = (np.diff(np.interp(marks, t, along)) for along in (x, y))
    return np.diff(marks), np.hypot(on_x, on_y)
