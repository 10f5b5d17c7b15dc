"""Lanes: the pose of a robot at every step of a straight piece of its way, and where and why a lane ends.

1. A lane is cut into steps of a fraction of a block. At each step the robot rests (settling.py), and its margin of
   forward force is known (pushing.py).
2. A lane ends where the robot tips over, where an upright face of it hits a block, or where it cannot push itself on:
   the force that lacks, along the distance over which it lacks, is more than its kinetic energy gives back,

       sum of -s dx > v^2 / 2 g

3. Drops and slips are told, but do not end a lane: a robot that slides or falls forward goes on.

Poses are found each by itself, not from the one before on the lane: of the 228 drives in Gazebo Classic of
benchmarks/crossings that tells 202 rightly, and the other way 203, in four times the time.

Cost: poses of all lanes at once. What breaks it: a robot that is turned by what it climbs, as by a block under one
wheel, leaves its lane; the wheels' own dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.pushing import SLIDING, force_margin
from rsegen.standing.resting import GRAVITY, has_stood
from rsegen.standing.settling import PaddedGround, Settled, joined, outer_radius, settle

_STEPS = 100
"""Steps per length of a robot."""

_LEAST_STEP, _MOST_STEP = 0.0025, 0.01
"""Bounds of a step, metres: a wheel of 3 cm has turned by 5 degrees."""

_LOOKS = 8
"""Steps between two poses that are looked at first: most lanes of a small robot end early, where it tips over."""

_HIT = 0.001
"""Metres by which a block may be above the lower edge of an upright face: contacts give way by as much."""

_DROP = 0.01
"""Metres by which the centre of mass comes down in a step of a drop: several times what a slope gives."""


class End(IntEnum):
    """Why a way ends."""

    NONE = 0
    TIPS = 1
    HITS = 2
    STUCK = 3

    @property
    def words(self) -> str:
        """The reason in words."""
        return ("goes on", "tips over", "hits a block with an upright face", "cannot push itself on")[self]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Lanes:
    """Straight lanes that a robot drives, L of them with K poses each.

    poses: L * K robots at rest, lane by lane; end: (L,) why a lane ends; last: (L,) the number of its last pose, K - 1
    for one that is driven to its end; drops, slips: (L, K) where the robot falls, or slides by itself
    """

    poses: Settled
    end: Ints
    last: Ints
    drops: Mask
    slips: Mask

    @property
    def tilt(self) -> Array:
        """Return the largest tilt on each lane, radians, (L,)."""
        return np.asarray(self.poses.tilt.reshape(len(self.end), -1).max(axis=1))

    def lane(self, number: int) -> Lanes:
        """Return one of them."""
        count, row = len(self.poses.x) // len(self.end), slice(number, number + 1)
        poses = self.poses.some(slice(number * count, (number + 1) * count))
        return Lanes(poses=poses, end=self.end[row], last=self.last[row], drops=self.drops[row], slips=self.slips[row])

    def starts_of(self, which: Mask, body: Body) -> list[tuple[float, float]]:
        """Return where the robot's origin is, metres, at the beginning of each stretch of a mask (L, K) of poses."""
        begins = which & ~np.pad(which, ((0, 0), (1, 0)))[:, :-1]
        x, y = origins(self.poses.some(np.flatnonzero(begins)), body)
        return list(zip(x.tolist(), y.tolist(), strict=True))

    @property
    def passed(self) -> Mask:
        """Return which lanes are driven to their ends, (L,)."""
        return np.asarray(self.end == End.NONE)


def origins(poses: Settled, body: Body) -> tuple[Array, Array]:
    """Return x and y of the origin of a robot at some poses, metres, (n,) each; the poses tell its centre of mass."""
    c, s, (along, across, _) = np.cos(poses.yaw), np.sin(poses.yaw), body.centre
    return poses.x - c * along + s * across, poses.y - s * along - c * across


def step_of(body: Body) -> float:
    """Return the length of a step of a robot, metres."""
    return min(max(body.length / _STEPS, _LEAST_STEP), _MOST_STEP)


def steps_on(body: Body, length: float) -> int:
    """Return the number of steps of a robot on a lane of a length in metres."""
    return max(round(length / step_of(body)), 1)


def drive_lanes(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array, length: float) -> Lanes:
    """Return the lanes of a length [m] that begin at x, y [m] with a heading [rad], (L,)."""
    count = steps_on(body, length) + 1
    step = length / (count - 1)
    along = np.arange(count) * step
    lanes = len(x)
    every_x = x[:, None] + np.cos(yaw)[:, None] * along
    every_y = y[:, None] + np.sin(yaw)[:, None] * along
    # A lane is looked at up to the first of some of its poses in which the robot tips over, and stays there.
    some = np.append(np.arange(0, count - 1, _LOOKS), count - 1)
    looked = settle(ground, body, every_x[:, some].ravel(), every_y[:, some].ravel(), np.repeat(yaw, len(some)))
    tipped = ~has_stood(looked).reshape(lanes, len(some))
    until = np.where(tipped.any(axis=1), some[tipped.argmax(axis=1)], count - 1)
    # The poses up to there that were not looked at are found too, and all of them put in their order.
    is_new = np.arange(count) <= until[:, None]
    needed = is_new.copy()
    is_new[:, some] = False
    settled = settle(ground, body, every_x[is_new], every_y[is_new], np.repeat(yaw, is_new.sum(axis=1)))
    place = np.empty((lanes, count), np.int64)
    place[:, some] = np.arange(lanes * len(some)).reshape(lanes, -1)
    place[is_new] = lanes * len(some) + np.arange(len(settled.x))
    distinct = joined([looked, settled]).some(place[needed])
    number = (np.cumsum(until + 1) - until - 1)[:, None] + np.minimum(np.arange(count), until[:, None])
    rest = distinct.some(number.ravel())
    force = force_margin(ground, body, distinct)[number]
    height = rest.z.reshape(lanes, count)
    tips = ~has_stood(rest).reshape(lanes, count)
    hits = _hits(ground, body, rest, lanes, count)
    # A robot that nothing balances slides: forward, if it comes down with it, which takes it on; else it is held up.
    ahead = np.minimum(np.arange(count) + 4, count - 1)
    falls = height[:, ahead] < height - _HIT
    sliding = force <= SLIDING
    force = np.where(sliding & falls, 0.0, force)
    # The force that lacks is taken from the kinetic energy; as soon as none lacks, the robot has its speed again.
    lacking, energy = np.zeros(lanes), body.speed**2 / 2 / GRAVITY
    end, last = np.zeros(lanes, np.int64), np.full(lanes, count - 1)
    for k in range(count):
        lacking = np.where(force[:, k] < 0, lacking - force[:, k] * step, 0.0)
        reason = np.select([tips[:, k], hits[:, k], lacking > energy], [End.TIPS, End.HITS, End.STUCK], End.NONE)
        now = (end == End.NONE) & (reason != End.NONE)
        end[now], last[now] = reason[now], k
    drops = np.diff(height, axis=1, prepend=height[:, :1]) < -max(_DROP, 2 * step)
    return Lanes(poses=rest, end=end, last=last, drops=drops, slips=sliding & falls)


def _hits(ground: PaddedGround, body: Body, rest: Settled, lanes: int, count: int) -> Mask:
    """Return at which step an upright face of a part that does not drive meets a block, (L, K)."""
    front = np.flatnonzero(body.rim & ~body.drives & (body.points[:, 0] > body.centre[0]))
    hits = np.zeros((lanes, count), bool)
    if not len(front) or count < 2:
        return hits
    now = np.arange(lanes * count).reshape(lanes, count)
    before, after = now[:, :-1].ravel(), now[:, 1:].ravel()
    relative = (body.points[front] - body.centre) @ np.swapaxes(rest.axes[before], 1, 2)
    under = ground.below(rest.x[after, None] + relative[..., 0], rest.y[after, None] + relative[..., 1])
    into = (under - relative[..., 2] - rest.z[before, None]).max(axis=1)
    step = np.hypot(rest.x[after] - rest.x[before], rest.y[after] - rest.y[before])
    hits[:, 1:] = (into > _HIT + np.hypot(*rest.slope[before].T) * step).reshape(lanes, count - 1)
    return hits


_BESIDE = 0.003
"""Metres to either side of a lane that have to be driven too: by so much a robot leaves its line in Gazebo."""


def straight_lane(field: StepField, body: Body, axis: int, middles: Array | None = None) -> float | None:
    """Return the place across, metres, of the first straight lane that is driven to its end; None if there is none.

    The lanes a little to either side of it are driven too. middles: of the lanes, by default as of `straight`.
    """
    middles = across(field, axis) if middles is None else middles
    passed = surely_passed(straight(field, body, axis, middles), field, body, axis, middles)
    return float(middles[passed.argmax()]) if passed.any() else None


def surely_passed(lanes: Lanes, field: StepField, body: Body, axis: int, middles: Array) -> Mask:
    """Return which lanes at some places across, metres, are driven to their ends, and the ones beside them too."""
    passed = lanes.passed
    for beside in (-_BESIDE, _BESIDE):
        if passed.any():
            passed[passed] = straight(field, body, axis, middles[passed] + beside).passed
    return passed


def lines_along(field: StepField, axis: int) -> Mask:
    """Return on which lines of cells along an axis a robot may drive, counted across it.

    It crosses frames, but does not drive along them, which would lead around every obstacle; as in traversability.
    """
    inside = field.inside(1 - axis)
    return inside if inside.any() else ~inside


def across(field: StepField, axis: int) -> Array:
    """Return the middles of the lines of cells along an axis on which a robot may drive, metres."""
    return field.middles()[1 - axis][lines_along(field, axis)]


def entry_distance(field: StepField, body: Body, axis: int) -> float:
    """Return how far before a field, along an axis, the origin of a robot is that is wholly outside it, metres."""
    return field.extent[axis] / 2 + max(float(body.high[0]), 0.0) + step_of(body)


def straight(field: StepField, body: Body, axis: int, middles: Array | None = None) -> Lanes:
    """Return the straight lanes across a field along an axis, 0 for x and 1 for y, at places across it, in metres.

    They are where the robot is wholly outside at first and at last; by default through the middle of every line of
    cells but those of frames alone.
    """
    middles = across(field, axis) if middles is None else middles
    before = entry_distance(field, body, axis)
    length = before + field.extent[axis] / 2 - min(float(body.low[0]), 0.0) + step_of(body)
    along = np.full(len(middles), -before)
    x, y = (along, middles) if axis == 0 else (middles, along)
    return drive_lanes(
        PaddedGround.of(field, outer_radius(body)), body, x, y, np.full(len(middles), axis * np.pi / 2), length
    )
