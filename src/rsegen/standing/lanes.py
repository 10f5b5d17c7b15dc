r"""Lanes: the pose of a robot at every step of a straight piece of its way, and where and why a lane ends.

1. A lane is cut into steps of a fraction of a block. At each step the robot rests (settling.py), and its margin of
   forward force is known (pushing.py).
2. A lane ends where the robot tips over, where an upright face of it hits a block, where a round part that does not
   drive is held at the side of a block, or where the robot cannot push itself on: the missing force, along the distance
   over which it is missing, takes more than its kinetic energy, or parts without drive have to be lifted between poses
   by more than the wheels' work and half of that energy,

       sum of -s dx > v^2 / 2 g        sum of (lift - F dx) > v^2 / 4 g

   in weights, with F the friction of the driven contacts, mu times the load on them.
3. Drops and slips are reported, but do not end a lane: a robot that slides or falls forward goes on.

A round part, as a caster's ball of radius r with friction mu, is pushed up an edge as long as the contact leans by less
than 90 degrees minus the angle of friction: up to a rise of r (1 - mu / sqrt(1 + mu^2)).

    (   )|            (   )
     \_ /|___          \_|/___       left: the rise is above the equator of a ball without friction: it is held
    _____|            ___|           right: below it: it is lifted, if force and energy last

Which of several stable poses a robot takes depends on the one before. To follow it takes three times as long, and does
not predict better whether a lane is driven: 203 of 228 drives in Gazebo Classic (benchmarks/crossings), and 202 with
each pose by itself. So lanes that are tried have the poses of a robot that is put down level. In lanes that are answers
each pose follows (`follows`): if it is unlike the one before, the robot is put down as it stood there.

    put down level   a a a b b b b a b b b        asked at each jump from a to b, and from b to a
    that follows     a a a a a b b b b b b        the third b is where a is stable no more

The motors of wheels act back on the chassis, as real ones, MuJoCo's and Gazebo Sim's do. Gazebo Classic's drives do
not: the robot pitches forward, and its caster is lifted over edges that would hold it (`Body.reaction`).

Cost: poses of all lanes at once, section by section, and none behind the section in which a lane ends. What breaks it:
a robot that is turned by what it climbs, as by a block under one wheel, leaves its lane; the wheels' own dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.pushing import SLIDING, force_margin
from rsegen.standing.resting import GRAVITY, has_stood, loads_on
from rsegen.standing.settling import Settled, joined, outer_radius, settle, settle_from

_STEPS = 100
"""Steps per length of a robot."""

_LEAST_STEP, _MOST_STEP = 0.0025, 0.01
"""Bounds of a step, metres: a wheel of 3 cm has turned by 5 degrees."""

_SECTION, _TOGETHER = 8, 1000
"""Poses of a section of each lane, and of a section of all lanes together, at least: two calls for a few cost more than
one, and half of the lanes that end do so in their first quarter."""

_JUMP, _ALIKE = 0.01, 1e-3
"""Slope from which on a pose is so unlike the one before that it may not follow from it, and slope and metres up to
which two poses are the same."""

_LATER = 4
"""Poses later at which a robot that slides is lower, if it slides forward."""

_HIT = 0.001
"""Metres by which a block may be above the lower edge of an upright face: contacts give way by as much."""

_DROP = 0.01
"""Metres by which the centre of mass comes down in a step of a drop: several times what a slope gives."""


_USED = 0.5
"""Share of the kinetic energy that lifts a part between two poses: meeting an edge costs the rest. Of 48 ways in Gazebo
Classic on which half of it and the wheels' work were asked for, 26 were left, of which 22 were crossed."""


_WALL = 3.0
"""Rise of the centre of mass in a step, in lengths of it, from which on it is that of a wall: tracks that climb one
with their ends rise by 2, wheels on a slope that friction holds by 1."""


class End(IntEnum):
    """Reason why a way ends."""

    NONE = 0
    TIPS = 1
    HITS = 2
    STUCK = 3
    HELD = 4
    STOPPED = 5

    @property
    def words(self) -> str:
        """The reason in words."""
        return (
            "goes on",
            "tips over",
            "hits a block with an upright face",
            "cannot push itself on",
            "gets stuck at the side of a block on a part that does not drive",
            "is stopped by a step that it cannot climb",
        )[self]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Lanes:
    """Straight lanes that a robot drives, L of them with K poses each; a lane repeats its last known pose up to K.

    poses: L * K robots at rest, lane by lane; count: (L,) poses of each lane if it is driven to its end
    end: (L,) why a lane ends; last: (L,) index of its last pose, count - 1 for one that is driven to its end
    drops, slips: (L, K) where the robot falls, or slides by itself, before a lane ends
    """

    poses: Settled
    count: Ints
    end: Ints
    last: Ints
    drops: Mask
    slips: Mask

    @property
    def tilt(self) -> Array:
        """Return the largest tilt on each lane, radians, (L,)."""
        return np.asarray(self.poses.tilt.reshape(len(self.end), -1).max(axis=1))

    def lane(self, number: int) -> Lanes:
        """Return the lane of a number."""
        count, row = self.drops.shape[1], slice(number, number + 1)
        poses = self.poses.some(slice(number * count, (number + 1) * count))
        rows = {name: getattr(self, name)[row] for name in ("count", "end", "last", "drops", "slips")}
        return Lanes(poses=poses, **rows)

    def starts_of(self, which: Mask, body: Body) -> list[tuple[float, float]]:
        """Return where the robot's origin is, metres, at the beginning of each stretch of a mask (L, K) of poses."""
        begins = which & ~np.pad(which, ((0, 0), (1, 0)))[:, :-1]
        x, y = origins(self.poses.some(np.flatnonzero(begins)), body)
        return list(zip(x.tolist(), y.tolist(), strict=True))

    def ends_of(self, lanes: Ints, body: Body) -> tuple[Array, Array]:
        """Return x and y of the robot's origin at the last poses of some lanes, by their numbers, metres, (n,) each."""
        return origins(self.poses.some(lanes * self.drops.shape[1] + self.last[lanes]), body)

    @property
    def passed(self) -> Mask:
        """Return which lanes are driven to their ends, (L,)."""
        return np.asarray(self.end == End.NONE)

    @property
    def driven_shares(self) -> Array:
        """Return the share of each lane that is driven, (L,): 1 of one that is driven to its end."""
        return np.where(self.passed, 1.0, self.last / self.count)


def origins(poses: Settled, body: Body) -> tuple[Array, Array]:
    """Return x and y of the origin of a robot at some poses, which have its centre of mass, metres, (n,) each."""
    c, s, (along, across, _) = np.cos(poses.yaw), np.sin(poses.yaw), body.centre
    return poses.x - c * along + s * across, poses.y - s * along - c * across


def step_of(body: Body) -> float:
    """Return the length of a step of a robot, metres."""
    return min(max(body.length / _STEPS, _LEAST_STEP), _MOST_STEP)


def steps_on(body: Body, length: float | Array) -> Ints:
    """Return the number of steps of a robot on a lane of a length in metres, or of one each."""
    return np.asarray(np.maximum(np.rint(length / step_of(body)), 1), np.int64)


def drive_lanes(  # noqa: PLR0913  # a place is three
    ground: PaddedGround,
    body: Body,
    x: Array,
    y: Array,
    yaw: Array,
    length: float | Array,
    *,
    ends: tuple[Settled, Settled] | None = None,
    follows: bool = False,
) -> Lanes:
    """Return the lanes of a length [m], or of one each (L,), that begin at x, y [m] with a heading [rad], (L,).

    ends: the robot at rest at the first and at the last pose of each lane, where that is known
    follows: whether each pose follows from the one before, and not from a robot that is put down level
    """
    driving = _Driving(ground, body, (x, y, yaw), np.broadcast_to(length, x.shape), follows=follows)
    if ends is not None:
        driving.know(*ends)
    return driving.driven()


class _Driving:
    """Lanes that are driven together, section by section, L of them of at most K poses: a lane ends in its section.

    count, step: (L,) poses of each lane, and metres between two of them; rest: the robot at rest at known poses
    place: (L, K) the number of each pose in `rest`, -1 where it is not known
    seen: (L,) how many poses of each lane were looked at, none after one in which it tips over
    height, force: (L, K) of the centre of mass, metres, and its force margin, in weights
    surplus: (L, K) work to lift parts in the step to a pose, less the work of the wheels, in weights times metres
    tips, hits, held: (L, K) at which poses it tips over, hits a block, and is held; end, last: (L,) as in Lanes
    """

    def __init__(
        self,
        ground: PaddedGround,
        body: Body,
        start: tuple[Array, Array, Array],
        length: Array,
        *,
        follows: bool,
    ) -> None:
        self.ground, self.body, self.start, self.follows = ground, body, start, follows
        self.count = steps_on(body, length) + 1
        self.step = length / (self.count - 1)
        shape = len(length), int(self.count.max(initial=1))
        self.place, self.seen = np.full(shape, -1), np.zeros(shape[0], np.int64)
        self.height, self.surplus, self.force = (np.zeros(shape) for _ in range(3))
        self.tips, self.hits, self.held = (np.zeros(shape, bool) for _ in range(3))
        self.end, self.last = np.zeros(shape[0], np.int64), self.count - 1
        self.rest = settle(ground, body, *(values[:0] for values in start))

    def know(self, first: Settled, last: Settled) -> None:
        """Take the robot at rest at the first and at the last pose of each lane as known."""
        lanes = np.arange(len(self.count))
        self.place[lanes, self.count - 1] = len(lanes) + lanes
        self.place[:, 0] = lanes
        self.rest = joined([first, last])

    def driven(self) -> Lanes:
        """Drive the lanes, and return them; each stays at the last pose that was looked at."""
        live, begin, most = np.arange(len(self.count)), 0, self.place.shape[1]
        while len(live):
            # The fewer lanes go on, the longer are sections. Lanes whose poses follow each other are one section.
            end = begin + max(_SECTION, _TOGETHER // len(live))
            end = most if self.follows or end + _SECTION > most else end
            self._look(live, begin, end)
            self._judge(live, end)
            begin, live = end, live[(self.end[live] == End.NONE) & (self.seen[live] < self.count[live])]
        # A robot that tips over as it is lifted up a wall does not get there.
        stop = self._stops()
        self.end, self.last = np.where(stop < most, End.STOPPED, self.end), np.minimum(self.last, stop)
        stays = np.minimum(np.arange(most), self.seen[:, None] - 1)
        height, force, place = (
            np.take_along_axis(values, stays, axis=1) for values in (self.height, self.force, self.place)
        )
        return Lanes(
            poses=self.rest.some(place.ravel()),
            count=self.count,
            end=self.end,
            last=self.last,
            drops=np.diff(height, axis=1, prepend=height[:, :1]) < -np.maximum(_DROP, 2 * self.step)[:, None],
            slips=(force <= SLIDING) & _falls(height, self.seen),
        )

    def _look(self, live: Ints, begin: int, end: int) -> None:
        """Find the poses `begin` to `end` of lanes that still go on, and all that decides where these end."""
        section = np.arange(begin, end)
        row, column = np.nonzero((section < self.count[live, None]) & (self.place[live, begin:end] < 0))
        lane, k = live[row], section[column]
        x, y, yaw = (values[lane] for values in self.start)
        along = k * self.step[lane]
        self.place[lane, k] = len(self.rest.x) + np.arange(len(lane))
        new = settle(self.ground, self.body, x + np.cos(yaw) * along, y + np.sin(yaw) * along, yaw)
        self.rest = joined([self.rest, new])
        if self.follows:
            self._follow()
        # A lane stays at the first pose in which the robot tips over.
        self.tips[live, begin:end] = tips = ~has_stood(self.rest)[self.place[live, begin:end]]
        tips &= section < self.count[live, None]
        until = np.where(tips.any(axis=1), begin + tips.argmax(axis=1) + 1, end)
        self.seen[live] = np.minimum(until, self.count[live])
        row, column = np.nonzero(section < self.seen[live, None])
        lane, k = live[row], section[column]
        rest = self.rest.some(self.place[lane, k])
        self.height[lane, k], self.force[lane, k] = rest.z, force_margin(self.ground, self.body, rest)
        self.surplus[lane, k] = -_grip(self.body, rest) * self.step[lane]
        # From the second pose on, the step that leads there.
        lane, k = lane[k > 0], k[k > 0]
        step = _Steps(self.ground, self.body, self.rest, self.place[lane, k - 1], self.place[lane, k])
        self.surplus[lane, k] += step.lift()
        self.hits[lane, k] = step.meets(_upright_faces(self.body), _HIT)
        if self.body.reaction:
            self.held[lane, k] = step.meets(_holding_sides(self.body), 0.0)

    def _follow(self) -> None:
        """Take the poses that follow from those before them, until each does."""
        may = np.arange(1, self.place.shape[1]) < self.count[:, None]  # differ from what follows: the one before is new
        while True:
            rest, slope = self.rest, self.rest.slope[self.place]
            is_jump = np.abs(np.diff(slope, axis=1)).max(axis=2) > _JUMP
            asked = may & is_jump & has_stood(rest)[self.place[:, :-1]]  # what has tipped over leads nowhere
            lane, before = np.nonzero(asked)
            if not len(lane):
                return
            at = self.place[lane, before + 1]
            start = rest.slope[self.place[lane, before]]
            new = settle_from(self.ground, self.body, rest.x[at], rest.y[at], rest.yaw[at], start)
            turned, lifted = np.abs(new.slope - rest.slope[at]).max(axis=1), np.abs(new.z - rest.z[at])
            differs = (np.maximum(turned, lifted) > _ALIKE) & has_stood(new)
            lane, pose = lane[differs], before[differs] + 1
            self.place[lane, pose] = len(rest.x) + np.arange(len(lane))
            self.rest = joined([rest, new.some(np.flatnonzero(differs))])
            # Only what comes after a changed pose may change next.
            may &= ~asked
            has_next = pose < may.shape[1]
            may[lane[has_next], pose[has_next]] = True

    def _judge(self, live: Ints, end: int) -> None:
        """Find which lanes end before the pose `end`, and why, as far as enough poses after them are known."""
        seen, pose = self.seen[live], np.arange(end)
        tips, hits, held = (mask[live, :end] for mask in (self.tips, self.hits, self.held))
        force, surplus = self.force[live, :end], self.surplus[live, :end]
        # A robot that nothing balances slides: forward, if it comes down, which takes it on; else it is held up.
        force = np.where((force <= SLIDING) & _falls(self.height[live, :end], seen), 0.0, force)
        # The force that lacks is taken from the kinetic energy; as soon as none lacks, the robot has its speed again.
        # What lifts parts that do not drive, beyond the wheels' work, is taken from half of it: poses jump over edges.
        energy = self.body.speed**2 / 2 / GRAVITY
        lacks = force < 0
        taken = np.where(lacks, -force * self.step[live, None], 0.0).cumsum(axis=1)
        lacking = taken - np.maximum.accumulate(np.where(lacks, 0.0, taken), axis=1)
        # `asked` is the largest sum over any stretch that ends at a pose: work of the wheels before it is not stored.
        work = surplus.cumsum(axis=1)
        asked = work - np.minimum(np.minimum.accumulate(work, axis=1), 0.0)
        is_stuck = (lacking > energy) | (asked > _USED * energy)
        reasons = [End.TIPS, End.HITS, End.HELD, End.STUCK]
        reason = np.asarray(np.select([tips, hits, held, is_stuck], reasons, End.NONE))
        # Whether a robot slides forward is known `_LATER` poses on, so the last ones wait for the next section.
        is_whole = (seen == self.count[live]) | tips[np.arange(len(live)), seen - 1]
        reason[pose >= np.where(is_whole, seen, seen - _LATER)[:, None]] = End.NONE
        ends = np.flatnonzero(reason.any(axis=1))
        self.last[live[ends]] = last = (reason[ends] != End.NONE).argmax(axis=1)
        self.end[live[ends]] = reason[ends, last]

    def _stops(self) -> Ints:
        """Return the pose at which a block stops the robot, on lanes that end where it tips over, (L,); K for none.

        It tips over as it is lifted up a wall, which no robot climbs: it stays where the wall begins.
        """
        stop = np.full(len(self.count), self.place.shape[1])
        tipped = np.flatnonzero((self.end == End.TIPS) & (self.last > 0))
        last, height = self.last[tipped], self.height[tipped]
        step = _Steps(self.ground, self.body, self.rest, self.place[tipped, last - 1], self.place[tipped, last])
        meets = step.meets(np.arange(len(self.body.points)), _HIT)
        stop[tipped[meets]] = last[meets]
        # Of the rises since it was as long before it tips over, the first that no slope gives.
        pose, long = np.arange(self.place.shape[1]), self.step[tipped, None]
        near = (pose <= last[:, None]) & (pose > last[:, None] - self.body.length / long)
        lifted = near & (np.diff(height, axis=1, prepend=height[:, :1]) > _WALL * long)
        up = lifted.any(axis=1)
        stop[tipped[up]] = lifted[up].argmax(axis=1)
        return stop


def _falls(height: Array, seen: Ints) -> Mask:
    """Return at which poses (L, K) a robot is lower `_LATER` poses on, or at the last one that was looked at."""
    later = np.minimum(np.arange(height.shape[1]) + _LATER, seen[:, None] - 1)
    return np.asarray(np.take_along_axis(height, later, axis=1) < height - _HIT)


def _grip(body: Body, rest: Settled) -> Array:
    """Return the largest force of the driven contacts of robots, in shares of their weights, (n,)."""
    mu = np.array([part.mu if part.drives else 0.0 for part in body.parts])[body.part]
    at = np.einsum("nij,ncj->nci", rest.axes, (body.points - body.centre)[rest.contacts])
    stands = (rest.contacts >= 0).all(axis=1)
    return np.where(stands, (loads_on(at) * mu[rest.contacts]).sum(axis=1), 0.0)


def _upright_faces(body: Body) -> Ints:
    """Return the samples on the lower edges of upright faces that do not drive, in front of the centre of mass."""
    return np.flatnonzero(body.rim & ~body.drives & (body.points[:, 0] > body.centre[0]))


_AHEAD = 0.7
"""Least forward part of a normal that looks ahead: within 45 degrees of the heading, to which diagonals come."""


def _holding_sides(body: Body) -> Ints:
    """Return the samples of round parts that do not drive, looking ahead, at which no push lifts them over an edge.

    With friction, rigid parts would be held lower than at their equators; in no simulator are they.
    """
    is_up = body.normals[:, 2] >= 0
    return np.flatnonzero(~body.drives & ~body.rim & is_up & (body.normals[:, 0] > _AHEAD))


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """Steps of lanes, n of them, from a pose to the next one, by their numbers among robots at rest, (n,) each."""

    ground: PaddedGround
    body: Body
    rest: Settled
    before: Ints
    after: Ints

    def meets(self, samples: Ints, give: float) -> Mask:
        """Return whether some samples of a robot, in its pose before, are in the ground at its next place, (n,).

        give: depth in metres that is allowed, besides the rise of the robot on its slope
        """
        rest, before, after = self.rest, self.before, self.after
        points = (self.body.points - self.body.centre)[samples]
        if not len(samples):
            return np.zeros(len(before), bool)
        relative = points @ np.swapaxes(rest.axes[before], 1, 2)
        under = self.ground.below(rest.x[after, None] + relative[..., 0], rest.y[after, None] + relative[..., 1])
        into = (under - relative[..., 2] - rest.z[before, None]).max(axis=1)
        step = np.hypot(rest.x[after] - rest.x[before], rest.y[after] - rest.y[before])
        return np.asarray(into > give + np.hypot(*rest.slope[before].T) * step)

    def lift(self) -> Array:
        """Return the rise of the contacts after a step that do not drive, by their shares of the load, metres, (n,)."""
        rest, before, after = self.rest, self.before, self.after
        # The three samples that bear the robot after the step, and how high the same ones were before it.
        contacts = rest.contacts[after]
        points = (self.body.points - self.body.centre)[contacts]
        at = np.einsum("nij,ncj->nci", rest.axes[after], points)
        low = np.einsum("nj,ncj->nc", rest.axes[before, 2], points) + rest.z[before, None]
        loads = np.where(self.body.drives[contacts], 0.0, loads_on(at))
        lift = (loads * (at[..., 2] + rest.z[after, None] - low)).sum(axis=1)
        return np.where((contacts >= 0).all(axis=1), lift, 0.0)


BESIDE = 0.003
"""Metres to either side of a lane that have to be driven too: as far as a robot leaves its line in Gazebo."""

FALL_ROOM = 0.02
"""Metres to either side of a lane with drops: of the crawler's ways over blocks of 10 cm with as much room 5 of 5 were
crossed in Gazebo Classic, of those with less 3 of 9."""


def driven_lanes(field: StepField, body: Body, axis: int, middles: Array | None = None) -> Array:
    """Return the places across, metres, of the straight lanes that are driven to their ends.

    The lanes a little to either side of them are driven too. middles: of the lanes, by default as in `straight`.
    """
    middles = across(field, axis) if middles is None else middles
    return middles[surely_passed(straight(field, body, axis, middles), field, body, axis, middles)]


def surely_passed(lanes: Lanes, field: StepField, body: Body, axis: int, middles: Array) -> Mask:
    """Return which lanes at places across, metres, are driven to their ends together with the lanes next to them.

    Where a robot falls it comes down a little aside, so lanes with drops have more room.
    """
    passed = lanes.passed
    for room, asked in ((BESIDE, np.ones_like(passed)), (FALL_ROOM, lanes.drops.any(axis=1))):
        tried = np.flatnonzero(passed & asked)
        if len(tried):
            beside = straight(field, body, axis, np.append(middles[tried] - room, middles[tried] + room)).passed
            passed[tried] = beside.reshape(2, -1).all(axis=0)
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
    """Return how far from the middle of a field, along an axis, a robot's origin is when it is wholly before it [m]."""
    return field.extent[axis] / 2 + max(float(body.high[0]), 0.0) + step_of(body)


def straight_length(field: StepField, body: Body, axis: int) -> float:
    """Return the length of a lane across a field along an axis, outside of which a robot is at both ends, metres."""
    return entry_distance(field, body, axis) + field.extent[axis] / 2 - min(float(body.low[0]), 0.0) + step_of(body)


def straight(
    field: StepField,
    body: Body,
    axis: int,
    middles: Array | None = None,
    *,
    follows: bool = False,
) -> Lanes:
    """Return the straight lanes across a field along an axis, 0 for x and 1 for y, at places across it, in metres.

    The robot is wholly outside at their first and last poses. By default one is on each line of cells, but for lines of
    frames alone. follows: as in `drive_lanes`
    """
    middles = across(field, axis) if middles is None else middles
    along = np.full(len(middles), -entry_distance(field, body, axis))
    x, y = (along, middles) if axis == 0 else (middles, along)
    ground, yaw = PaddedGround.of(field, outer_radius(body)), np.full(len(middles), axis * np.pi / 2)
    return drive_lanes(ground, body, x, y, yaw, straight_length(field, body, axis), follows=follows)
