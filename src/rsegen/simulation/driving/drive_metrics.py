"""The trajectory of a robot, and what it amounts to: distance, crossing, time stuck, tilt, tips and climb.

All follow from rows of time, position and angles alone, so those of a log, of another simulator or of a real robot are
measured alike; the definitions are in docs/driving.md. Cost: linear in the rows. What breaks it: rows too far apart, as
distance is then too short and a tip may be missed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import radians

import numpy as np

from rsegen.field.stepfield import Array

TIPPED = radians(75)
"""Angle, radians, between a robot's upright and the vertical, beyond which it has tipped over.

With less, a robot that leans against a block would count; one that lies on its side has 90 degrees, less its shape.
"""

SLOW = 0.1
"""Share of its speed below which a robot is stuck in a second.

A robot that slips on an edge comes on by less; one that climbs, turns or waits for its flippers by more.
"""

STILL = 0.01
"""Distance from its first place, metres, up to which a robot counts as still: ten times the
resolution of Gazebo Classic's record."""

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
            yield ",".join(f"{value:.4f}".rstrip("0").rstrip(".") for value in row) + "\n"


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveMetrics:
    """Metrics of the drive of a robot.

    distance: length of the trajectory seen from above, metres; crossed: seconds until the whole robot was beyond the
    map, None if never; stuck: seconds; tipped: how often it tipped over; tilt: largest angle between its upright and
    the vertical, radians; climbed: its highest place above the one on which it stood after the fall at the start, m
    touched: for each part, LINK::COLLISION, the share of samples with contacts; empty if the simulator reports none
    """

    seconds: float
    distance: float
    crossed: float | None
    stuck: float
    tipped: int
    tilt: float
    climbed: float
    touched: Mapping[str, float]


def drive_metrics(
    trajectory: Trajectory, speed: float, finish_x: float | None = None, touched: Mapping[str, float] | None = None
) -> DriveMetrics:
    """Return the metrics of a trajectory at a commanded speed, m/s; beyond x = `finish_x` the map is crossed."""
    t, x, y, z = trajectory.rows[:, :4].T
    over = np.flatnonzero(x > finish_x) if finish_x is not None else np.array([], dtype=int)
    fallen = trajectory.tilt > TIPPED
    return DriveMetrics(
        seconds=round(float(t[-1] - t[0]), 3),
        distance=round(float(np.hypot(np.diff(x), np.diff(y)).sum()), 3),
        crossed=round(float(t[over[0]] - t[0]), 3) if len(over) else None,
        stuck=round(_stuck(t, x, y, speed), 3),
        tipped=int(fallen[0]) + int((np.diff(fallen.astype(int)) == 1).sum()),
        tilt=round(float(trajectory.tilt.max()), 3),
        climbed=round(_climbed(t, z), 3),
        touched=touched or {},
    )


def _climbed(t: Array, z: Array) -> float:
    """Return the rise from the lowest height during the fall at the start to the highest one after it, metres."""
    ground = int(z[t <= t[0] + FALL].argmin())
    return float(z[ground:].max() - z[ground])


def _stuck(t: Array, x: Array, y: Array, speed: float) -> float:
    """Return the number of seconds in which it moved by less than SLOW of the commanded distance."""
    marks = np.arange(t[0], t[-1] + 1e-6, 1.0)
    on_x, on_y = (np.diff(np.interp(marks, t, along)) for along in (x, y))
    return float((np.hypot(on_x, on_y) < SLOW * speed).sum())
