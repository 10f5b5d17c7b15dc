"""Spots: places at which a robot stands level and firmly, and from which it can drive away, drawn at random.

1. Places are drawn: half of them at centres, edges and corners of cells with one of 16 headings, as platforms have
   them, the others anywhere. Places with level ground below the robot's feet (its contacts on level ground) and no
   block too high come first, and of these the ones with the most level ground ahead: some look-ups each.
2. There the robot is put down (settling.py). It must stand within the largest tilt, on its feet and driven parts alone,
   not on a frame, far from tipping over, and be able to push itself on (resting.py, pushing.py).
3. It must drive away: ahead, over a lane a little longer than itself (lanes.py), without tilting or falling so far that
   it might tip over. The top of a tower is level, and no spot.

Cost: some tenths of a second, on a map of any size, since a bounded number of places is drawn. What breaks it: a map
with very few spots among very many places; they may be missed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from enum import IntEnum
from math import degrees, pi, radians, tan

import numpy as np

from rsegen.errors import NoSpot, ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.streams import generator
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import drive_lanes
from rsegen.standing.outlines import EXACT, SPOT_HEADINGS, Outline, Spot, apart, fits, range_inside
from rsegen.standing.pushing import TOUCHING, sample_heights
from rsegen.standing.resting import GRAVITY, Poses, has_stood, of_settled
from rsegen.standing.settling import Settled, outer_radius, settle
from rsegen.standing.stance import stance_on

MOST_TILT = radians(3)
"""Largest tilt at which a robot may rest at its start. A robot 40 cm wide then stands on heights that differ by 2 cm at
most, which are the gaps and tolerances of sawn blocks; a whole unit tilts it by far more."""

GAP = 0.1
"""Gap, metres, between a robot and the map next to it, and between two robots: more than they drift on the way."""

_DRAWN = 60_000
"""Places that are drawn: a map of 10 x 10 blocks has 6,000 half cells with their headings."""

_AT_ONCE = 64
"""Places at which the robot is put down together: ten milliseconds."""

_SETTLED, _MORE = 600, 60
"""Places at which the robot is put down at most, and more of them for each spot: some tenths of a second."""

_LEAST_UNEVEN = 256
"""Other places at which it is put down at last, the least uneven ones first."""

_LANES, _MORE_LANES = 48, 6
"""Places from which it is driven away at most, and more of them for each spot: 20 milliseconds a lane."""

_LOOKED_AT = 2000
"""Places with level ground for which the room ahead is looked at; the roomiest are taken first."""


def find_spots(  # noqa: PLR0913  # the last three by name
    field: StepField,
    body: Body,
    count: int,
    rng: np.random.Generator,
    *,
    gap: float = GAP,
    most_tilt: float = MOST_TILT,
    evenest: bool = False,
) -> tuple[Spot, ...]:
    """Return `count` spots at least `gap` metres apart; most_tilt: the largest tilt there, radians.

    evenest: if they are too few, take other places where the robot stands, with what is wrong about them: first those
    that failed the latest check, and of these the least tilted. ParameterError if these are too few as well.
    """
    if not fits(field, body):
        n_x, n_y = field.shape
        raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; use a smaller robot or a larger map")
    search = _Search(SpotJudge(field, body, most_tilt), count, rng, gap)
    search.try_level_places()
    return search.spots(evenest=evenest)


class _Search:
    """A search for spots: it draws places, and chooses or refuses them.

    drawn: (3, n), random numbers of each place; lanes: how many places the robot may still be driven away from
    """

    def __init__(self, judge: SpotJudge, count: int, rng: np.random.Generator, gap: float) -> None:
        self.judge, self.count, self.gap = judge, count, gap
        self.drawn, self.outline = rng.random((3, _DRAWN)), Outline.of(judge.body)
        self.lanes = _LANES + _MORE_LANES * count
        self.chosen: list[Spot] = []
        self.refused: list[Place] = []

    @property
    def is_over(self) -> bool:
        """Return whether there are enough spots, or enough was tried."""
        return len(self.chosen) == self.count or not self.lanes

    def try_level_places(self) -> None:
        """Try level places, the roomy ones of them first, then all others."""
        # Look-ups find level places, and only the roomy ones have to settle, which costs far more.
        level = self.level_places()
        room = self.judge.level_lanes(self.places(level)[0])
        self.try_places(level[np.argsort(-room, kind="stable")][: _SETTLED + _MORE * self.count])
        if not self.is_over:
            numbers, at = self.inside(0, _DRAWN)
            others = numbers[self.judge.least_uneven(at)]
            self.try_places(others[~np.isin(others, level)][:_LEAST_UNEVEN])

    def level_places(self) -> Ints:
        """Return the numbers of the first places where the ground is level."""
        level: Ints = np.empty(0, np.intp)
        begin, count = 0, _LOOKED_AT
        while len(level) < _LOOKED_AT and begin < _DRAWN:
            numbers, at = self.inside(begin, begin + count)
            level = np.append(level, numbers[self.judge.is_level(at)])[:_LOOKED_AT]
            begin, count = begin + count, 2 * count
        return level

    def try_places(self, order: Ints) -> None:
        """Put the robot down at places, best first, and let it drive away, until there are enough spots."""
        for begin in range(0, len(order), _AT_ONCE):
            at, _ = self.places(order[begin : begin + _AT_ONCE])
            for fault, spot in self.judge.put_down(self._free(at)):
                if fault is not Fault.NONE:
                    self.refused.append((fault, spot))
                elif self._is_free(spot):
                    self.drive_away(spot)
                    if self.is_over:
                        return

    def drive_away(self, place: Spot) -> None:
        """Choose the spot at a place if the robot can leave it, else refuse it."""
        self.lanes -= 1
        if spot := self.judge.left(place):
            self.chosen.append(spot)
        else:
            self.refused.append((Fault.CAUGHT, replace(place, reason=Fault.CAUGHT.reason(0, 0))))

    def places(self, numbers: Ints) -> tuple[At, Mask]:
        """Return places by their numbers, every second one on a half cell with a heading of 16; and which are inside.

        Inside is where the robot is wholly within the field.
        """
        even, (along, across, turn) = numbers % 2 == 0, self.drawn[:, numbers]
        yaw = np.where(even, np.floor(turn * SPOT_HEADINGS) / SPOT_HEADINGS, turn) * 2 * pi
        extent, half = self.judge.field.extent, self.judge.field.block_width / 2
        room = range_inside(extent, self.outline, yaw)
        inside = np.asarray((room[:, 0] <= room[:, 1]).all(axis=0))
        sides: list[Array] = []
        for (low, high), share, side in zip(room, (along, across), extent, strict=True):
            # The edges of cells are at multiples of a block from the rim, so their halves are too.
            rim = -side / 2
            first, last = np.ceil((low - rim) / half - EXACT), np.floor((high - rim) / half + EXACT)
            inside &= ~even | (first <= last)
            on_halves = rim + half * (first + np.floor(share * (last - first + 1)))
            sides.append(np.where(even, on_halves, low + share * (high - low)))
        return (sides[0], sides[1], yaw), inside

    def inside(self, begin: int, end: int) -> tuple[Ints, At]:
        """Return the numbers of places that are inside, of those from a number on, and the places."""
        numbers = np.arange(begin, min(end, self.drawn.shape[1]))
        at, inside = self.places(numbers)
        return numbers[inside], some(at, inside)

    def spots(self, *, evenest: bool) -> tuple[Spot, ...]:
        """Return the spots; NoSpot if they are too few, with `evenest` also together with refused places."""
        if evenest:
            for fault, spot in sorted(self.refused, key=_by_fault_and_tilt):
                if len(self.chosen) < self.count and fault is not Fault.TIPS and self._is_free(spot):
                    self.chosen.append(spot)
        if len(self.chosen) == self.count:
            return tuple(self.chosen)
        if self.chosen:
            enough = f"found spots for {len(self.chosen)} of {self.count} on this map"
            raise NoSpot("count", f"{enough}; use fewer, or {_HELP}")
        reason = min(self.refused, key=_by_fault_and_tilt)[1].reason
        raise NoSpot("robot", f"no spot on this map: at the best place it {reason}; {_HELP}")

    def _free(self, at: At) -> At:
        """Return the places that are apart from all chosen spots."""
        free = np.ones(len(at[0]), bool)
        for spot in self.chosen:
            free &= apart(self.outline, self.gap, *at, spot)
        return some(at, free)

    def _is_free(self, spot: Spot) -> bool:
        place = np.array([spot.x]), np.array([spot.y]), np.array([spot.yaw])
        return len(self._free(place)[0]) > 0


def _by_fault_and_tilt(place: Place) -> tuple[int, float]:
    return -place[0], place[1].tilt


_HELP = "add a platform obstacle, or use a smaller robot or another map"


def spot_generator(seed: int) -> np.random.Generator:
    """Return the generator of the places of robots: `rsegen spots` gives those at which `rsegen drive` starts."""
    return generator(seed, 0, "places")


# The conditions on a place at which a robot starts: level, firm, on its feet alone, and able to drive away.


_SPARE = 0.002
"""Metres that stay free below all parts that do not bear the robot on level ground: a TurtleBot3's wheel sinks 1 mm
into the floor in Gazebo Classic (decision 8)."""

_FIRM = 0.5
"""Share of its angle to tip over on level ground that a robot must have left, at a spot, and on the lane from it: it
starts and stops there."""

_FEW = 3
"""Feet that are looked at first: on rough ground they differ already."""

_BINS = 8
"""Squares along a robot of which the lowest point is looked at first."""

_LANE = 1.25
"""Lengths of a robot that it drives away: its own, and some more, as it must not stop on a brink."""

_LOOKS = 4
"""Poses on a lane that are looked at before it is driven in small steps: steep ones need no more."""

_ROOM = tuple((lengths, turn * pi / 8) for lengths in (1, 2) for turn in (-1, 0, 1))
"""Lanes that are looked at for level ground, in lengths of a robot and turned to a side, radians: robots also steer,
and with more room they go farther before something happens."""


class Fault(IntEnum):
    """Reason why a place is no spot, in the order of the checks."""

    TIPS = 0
    TILTS = 1
    FRAME = 2
    HANGS = 3
    UNSTEADY = 4
    STUCK = 5
    CAUGHT = 6
    NONE = 7

    def reason(self, tilt: float, tip_angle: float) -> str:
        """Return the reason in words that follow "there it"; angles in degrees."""
        return (
            "tips over",
            f"tilts by {tilt:.3g} degrees",
            "stands on a frame",
            "touches a block with more than it stands on",
            f"tips over as soon as it is turned by {tip_angle:.2g} degrees",
            "cannot push itself on",
            "cannot drive away: a little more than its length ahead it would fall, tip over or be stopped",
            "",
        )[self]


Place = tuple[Fault, Spot]
At = tuple[Array, Array, Array]
"""x, y [m] and yaw [rad] of n robots."""


def some(at: At, chosen: Ints | Mask | slice) -> At:
    """Return the chosen robots."""
    x, y, yaw = (values[chosen] for values in at)
    return x, y, yaw


class SpotJudge:
    """The conditions on a place on a field, for one body.

    feet: (k, 2), its outermost contacts on level ground, about its origin, metres; coarse: (m, 3), its lowest points
    lowest, highest: the least and largest height in reach of each cell; sunk: its depth in level ground, metres
    hanging: the samples that must touch nothing; level: the largest unevenness at a spot, metres
    lane, steep, fall: length of a lane, metres, the largest tilt on it, radians, and the highest fall in a step, metres
    """

    def __init__(self, field: StepField, body: Body, most_tilt: float) -> None:
        self.field, self.body, self.most_tilt = field, body, most_tilt
        self.lane = _LANE * body.length
        self.ground = PaddedGround.of(field, outer_radius(body) + self.lane)
        frame = np.pad(field.frame, self.ground.border).ravel()
        self.blocks = replace(self.ground, heights=np.where(frame, np.nan, self.ground.heights))
        # All else follows from how it stands on level ground.
        stance = stance_on(self.ground, body)
        pose = stance.pose
        self.feet = np.unique(np.nan_to_num(pose.support[0, :, :2]), axis=0)
        self.level = tan(most_tilt) * float(np.ptp(self.feet, axis=0).max()) + TOUCHING
        self.coarse = _coarse(body, max(field.block_width / 2, body.length / _BINS))
        self.hanging = np.flatnonzero(~body.drives & ~stance.bearing[body.part])
        self.sunk = max(-float(self.coarse[:, 2].min()), 0.0)
        cells = int(np.ceil(np.linalg.norm(body.points[:, :2], axis=1).max() / field.block_width)) + 1
        self.lowest, self.highest = (_extreme(self.blocks, cells, best) for best in (np.minimum, np.maximum))
        self.steep = _FIRM * float(pose.tip_angle[0])
        self.fall = float(pose.tip_energy[0]) / (body.mass * GRAVITY)

    def is_level(self, at: At, along: Sequence[float] | Array = (0.0,), turn: float = 0.0) -> Mask:
        """Return where the ground is level below the feet, nowhere too high, at places and `along` ahead of them, (n,).

        False with a foot on a frame; turn: to which side ahead is, radians. Few look-ups decide most places: level
        for sure if all cells around are, and not level if the feet differ.
        """
        # Cheapest first: the cells around, some feet, all feet; each only for the places that the last one left open.
        around = np.zeros((1, 2))
        low, high = (self._below(ground, around, at, along, turn) for ground in (self.lowest, self.highest))
        level = np.asarray(high.max(axis=1) - low.min(axis=1) + self.sunk <= self.level)
        (undecided,) = np.nonzero(~level)
        for points in (self.feet[:: max(len(self.feet) // _FEW, 1)], self.feet):
            feet = self._below(self.blocks, points, some(at, undecided), along, turn)
            differs = np.ptp(feet, axis=1)
            even = differs <= self.level
            undecided, feet, differs = undecided[even], feet[even], differs[even]
        over = self._below(self.ground, self.coarse, some(at, undecided), along, turn) - np.tile(
            self.coarse[:, 2], len(along)
        )
        level[undecided] = differs + np.maximum(over.max(axis=1) - feet.max(axis=1), 0.0) <= self.level
        return level

    def _below(self, ground: PaddedGround, points: Array, at: At, along: Sequence[float] | Array, turn: float) -> Array:
        """Return the heights of the ground below points of the robot at places, and so far ahead, (n, k points)."""
        x, y, yaw = (values[:, None] for values in at)
        c, s = np.cos(yaw + turn), np.sin(yaw + turn)
        ahead, aside = np.add.outer(np.asarray(along), points[:, 0]).ravel(), np.tile(points[:, 1], len(along))
        return np.asarray(ground.below(x + c * ahead - s * aside, y + s * ahead + c * aside))

    def level_lanes(self, at: At) -> Ints:
        """Return on how many of some lanes ahead the ground is level, for each place, (n,)."""
        room = np.zeros(len(at[0]), np.intp)
        for lengths, turn in _ROOM:
            room += self.is_level(at, np.linspace(0, lengths * self.lane, _LOOKS * lengths + 1), turn)
        return room

    def least_uneven(self, at: At) -> Ints:
        """Return the indices of all places, the ones with the most even ground below the feet first."""
        differs = np.ptp(self._below(self.blocks, self.feet, at, (0.0,), 0.0), axis=1)
        return np.argsort(differs, kind="stable")

    def put_down(self, at: At) -> Iterator[Place]:
        """Yield how a robot rests at each place, and what is wrong about standing there."""
        rest = settle(self.ground, self.body, *at)
        poses = of_settled(self.ground, self.body, rest)
        _, above = sample_heights(self.ground, self.body, rest, np.arange(len(rest.x)))
        wrong = {
            Fault.TIPS: ~has_stood(rest),
            Fault.TILTS: poses.tilt > self.most_tilt + EXACT,
            Fault.FRAME: self._on_frame(poses),
            Fault.HANGS: above[:, self.hanging].min(axis=1, initial=np.inf) < _SPARE,
            Fault.UNSTEADY: poses.tip_angle < self.steep,
            Fault.STUCK: ~poses.pushes,
        }
        faults = np.select(list(wrong.values()), list(wrong), Fault.NONE)
        (left,) = np.nonzero(faults == Fault.NONE)
        faults[left[~self._is_open(some(at, left))]] = Fault.CAUGHT
        columns = (poses.x, poses.y, poses.z, poses.yaw, poses.roll, poses.pitch, poses.tilt, poses.tip_angle)
        for fault, row in zip(faults.tolist(), np.round(np.stack(columns, axis=1), 6) + 0.0, strict=True):
            yield _place(Fault(fault), row.tolist())

    def _on_frame(self, poses: Poses) -> Mask:
        corners = np.nan_to_num(poses.support[..., :2])
        cells = np.floor(corners / self.field.block_width + np.array(self.field.shape) / 2).astype(np.intp)
        i, j = (np.clip(cells[..., axis], 0, self.field.shape[axis] - 1) for axis in (0, 1))
        return np.asarray(self.field.frame[i, j].any(axis=1))

    def _is_open(self, at: At) -> Mask:
        """Return from which places the robot is nowhere steep at a few poses of the lane ahead."""
        x, y, yaw = (np.repeat(values, _LOOKS) for values in at)
        along = np.tile(np.arange(1, _LOOKS + 1) * self.lane / _LOOKS, len(at[0]))
        looks = settle(self.ground, self.body, x + np.cos(yaw) * along, y + np.sin(yaw) * along, yaw)
        return np.asarray(~self._is_steep(looks).reshape(-1, _LOOKS).any(axis=1))

    def left(self, place: Spot) -> Spot | None:
        """Return the spot at a place, if a lane ahead is driven from there to its end, never steep, without a fall.

        The robot is put down once more where it rested, since its origin moved as it settled: a place at the very edge
        of a block may not pass now, and of two poses it may take the other one, which then is the spot's.
        """
        at = np.array([place.x]), np.array([place.y]), np.array([place.yaw])
        ((fault, spot),) = self.put_down(at)
        # The lane is driven last, as it is the dearest check.
        if fault is not Fault.NONE:
            return None
        lanes = drive_lanes(self.ground, self.body, *at, self.lane)
        fall = -np.diff(lanes.poses.z).min(initial=0.0)
        is_left = lanes.passed[0] and not self._is_steep(lanes.poses).any() and fall <= self.fall
        return replace(spot, x=place.x, y=place.y, yaw=place.yaw) if is_left else None

    def _is_steep(self, rest: Settled) -> Mask:
        return np.asarray(~has_stood(rest) | (rest.tilt > self.steep))


def _extreme(ground: PaddedGround, cells: int, best: np.ufunc) -> PaddedGround:
    """Return the least or largest height of the cells around each, up to `cells` away; NaN where one is on a frame."""
    heights = ground.heights.reshape(ground.shape)
    for axis in range(2):
        padded = np.pad(heights, [(cells, cells) if axis == side else (0, 0) for side in range(2)])
        heights = best.reduce(np.lib.stride_tricks.sliding_window_view(padded, 2 * cells + 1, axis=axis), axis=-1)
    return replace(ground, heights=heights.ravel())


def _coarse(body: Body, width: float) -> Array:
    """Return the lowest sample of a body in each square of a width, (m, 3), metres."""
    lowest_first = body.points[np.argsort(body.points[:, 2], kind="stable")]
    _, first = np.unique(np.floor(lowest_first[:, :2] / width), axis=0, return_index=True)
    return lowest_first[first]


def _place(fault: Fault, row: Sequence[float]) -> Place:
    x, y, z, yaw, roll, pitch, tilt, tip_angle = row
    reason = fault.reason(degrees(tilt), degrees(tip_angle))
    return fault, Spot(x=x, y=y, z=z, yaw=yaw, roll=roll, pitch=pitch, tilt=tilt, tip_angle=tip_angle, reason=reason)
