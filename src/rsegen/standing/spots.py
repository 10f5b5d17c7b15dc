"""Spots: places at which a robot stands level and firmly, and from which it can drive away, drawn at random.

1. Places are drawn: half of them at centres, edges and corners of cells with one of 16 headings, as platforms have
   them, the others anywhere. Those come first where the ground is level below the robot's feet, its contacts on level
   ground, and nowhere too high; of these, those where it is so ahead too, the more the better: some look-ups each.
2. There the robot is put down (settling.py). It must stand within the largest tilt, on its feet and driven parts alone,
   not on a frame, far from tipping over, and be able to push itself on (resting.py, pushing.py).
3. It must drive away: ahead, over a lane a little longer than itself (lanes.py), without tilting or falling so far that
   it might tip over. The top of a tower is level, and no spot.

Parts of a field, such as the tiles of a terrain, are searched together, step by step, so that numpy's calls are shared.

Cost: some tenths of a second, on a map of any size, since a bounded number of places is drawn; 10 to 50 milliseconds
for each of many parts. What breaks it: a map with very few spots among very many places; they may be missed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from dataclasses import field as field_of
from enum import IntEnum
from functools import partial
from itertools import islice
from math import degrees, pi, radians, tan
from typing import TypeVar

import numpy as np

from rsegen.errors import NoSpot, ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.streams import generator
from rsegen.standing.body import Body
from rsegen.standing.lanes import drive_lanes
from rsegen.standing.outlines import EXACT, HEADINGS, Bounds, Outline, apart, fits, range_inside
from rsegen.standing.pushing import TOUCHING, sample_heights
from rsegen.standing.resting import GRAVITY, Poses, has_stood, of_settled
from rsegen.standing.settling import PaddedGround, Settled, outer_radius, settle, settled_on_level

MOST_TILT = radians(3)
"""Largest tilt at which a robot may rest at its start. A robot 40 cm wide then stands on heights that differ by 2 cm at
most, which are the gaps and tolerances of sawn blocks; a whole unit tilts it by far more."""


_SPARE = 0.002
"""Metres that stay free below all that does not bear the robot on level ground: a TurtleBot3's wheel sinks 1 mm into
the floor in Gazebo Classic (decision 8)."""

_FIRM = 0.5
"""Share of its angle to tip over on level ground that a robot must have left, at a spot, and on the lane from it: it
starts and stops there."""

_DRAWN = 60_000
"""Places that are drawn: a map of 10 x 10 blocks has 6,000 half cells with their headings."""

_AT_ONCE, _LEAST_AT_ONCE = 64, 4
"""Places at which the robot is put down together: ten milliseconds; and at least of each part."""

_SETTLED, _MORE = 600, 60
"""Places at which the robot is put down at most, and more of them for each spot: some tenths of a second."""

_LEAST_UNEVEN = 256
"""Places with other ground at which it is put down at last, the least uneven ones first."""

_LANES, _MORE_LANES = 48, 6
"""Places from which it is driven away at most, and more of them for each spot: 20 milliseconds a lane."""

_FEW = 3
"""Feet that are looked at first: on rough ground they differ already."""

_BINS = 8
"""Squares along a robot of which the lowest point is looked at first."""

_LOOKED_AT, _LEAST_LOOKED_AT = 2000, 64
"""Places with level ground of which the room ahead is looked at, and the roomiest are taken first; of many parts of a
field, which are looked at together, at least 64 each.
"""

_LANE = 1.25
"""Lengths of a robot that it drives away: its own, and some more, as it must not stop on a brink."""

_LOOKS = 4
"""Poses on a lane that are looked at before it is driven in small steps: steep ones need no more."""

_ROOM = tuple((lengths, turn * pi / 8) for lengths in (1, 2) for turn in (-1, 0, 1))
"""Lanes of these lengths of a robot, and turned to a side, are looked at for level ground: robots also steer, and where
there is more room they go farther before something happens."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Spot:
    """A place for a start or a goal of a robot.

    Attributes
    ----------
    x, y, z, roll, pitch, yaw : float
        Pose of the robot's origin at rest, metres and radians, as in Gazebo.
    tilt : float
        Angle between its upright and the vertical, radians.
    tip_angle : float
        The least turn that tips it over, radians.
    reason : str
        Empty; at a place that was taken for want of a spot, why it is none.
    """

    x: float
    y: float
    z: float
    yaw: float
    roll: float = 0.0
    pitch: float = 0.0
    tilt: float = 0.0
    tip_angle: float = 0.0
    reason: str = ""


class _Fault(IntEnum):
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
        """Return it in words that follow "there it"; angles in degrees."""
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


_Values = TypeVar("_Values", Ints, Mask)
_Place = tuple[_Fault, Spot]
_At = tuple[Array, Array, Array]
"""x, y [m] and yaw [rad] of n robots."""


def _some(at: _At, chosen: Ints | Mask | slice) -> _At:
    x, y, yaw = (values[chosen] for values in at)
    return x, y, yaw


class _Judge:
    """The conditions on a place on a field, for one body.

    feet: (k, 2), its outermost contacts on level ground, about its origin, metres; coarse: (m, 3), its lowest points
    lowest, highest: heights of all cells that it may be above at each place; sunk: its depth in level ground, metres
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
        level, rest = settled_on_level(self.ground, body)
        pose = of_settled(level, body, rest)
        _, above = sample_heights(level, body, rest, np.zeros(1, np.intp))
        bearing = np.isin(np.arange(len(body.parts)), body.part[above[0] < TOUCHING])
        self.feet = np.unique(np.nan_to_num(pose.support[0, :, :2]), axis=0)
        self.level = tan(most_tilt) * float(np.ptp(self.feet, axis=0).max()) + TOUCHING
        self.coarse = _coarse(body, max(field.block_width / 2, body.length / _BINS))
        self.hanging = np.flatnonzero(~body.drives & ~bearing[body.part])
        self.sunk = max(-float(self.coarse[:, 2].min()), 0.0)
        cells = int(np.ceil(np.linalg.norm(body.points[:, :2], axis=1).max() / field.block_width)) + 1
        self.lowest, self.highest = (_extreme(self.blocks, cells, best) for best in (np.minimum, np.maximum))
        self.steep = _FIRM * float(pose.tip_angle[0])
        self.fall = float(pose.tip_energy[0]) / (body.mass * GRAVITY)

    def is_level(self, at: _At, along: Sequence[float] | Array = (0.0,), turn: float = 0.0) -> Mask:
        """Return where the ground is level below the feet, nowhere too high, at places and `along` ahead of them, (n,).

        False with a foot on a frame; turn: to which side ahead is, radians. Few look-ups decide most places: level
        for sure if all cells around are, and not level if the feet differ.
        """
        # Cheapest first: the cells around, some feet, all feet; each only for the places that the last one left open.
        around = np.zeros((1, 2))
        low, high = (self._below(ground, around, at, along, turn) for ground in (self.lowest, self.highest))
        level = np.asarray(high.max(axis=1) - low.min(axis=1) + self.sunk <= self.level)
        (rest,) = np.nonzero(~level)
        for points in (self.feet[:: max(len(self.feet) // _FEW, 1)], self.feet):
            feet = self._below(self.blocks, points, _some(at, rest), along, turn)
            differs = np.ptp(feet, axis=1)
            even = differs <= self.level
            rest, feet, differs = rest[even], feet[even], differs[even]
        over = self._below(self.ground, self.coarse, _some(at, rest), along, turn) - np.tile(
            self.coarse[:, 2], len(along)
        )
        level[rest] = differs + np.maximum(over.max(axis=1) - feet.max(axis=1), 0.0) <= self.level
        return level

    def _below(
        self, ground: PaddedGround, points: Array, at: _At, along: Sequence[float] | Array, turn: float
    ) -> Array:
        """Return the heights of the ground below points of the robot at places, and so far ahead, (n, k points)."""
        x, y, yaw = (values[:, None] for values in at)
        c, s = np.cos(yaw + turn), np.sin(yaw + turn)
        ahead, aside = np.add.outer(np.asarray(along), points[:, 0]).ravel(), np.tile(points[:, 1], len(along))
        return np.asarray(ground.below(x + c * ahead - s * aside, y + s * ahead + c * aside))

    def level_lanes(self, at: _At) -> Ints:
        """Return on how many of some lanes ahead the ground is level, for each place, (n,)."""
        room = np.zeros(len(at[0]), np.intp)
        for lengths, turn in _ROOM:
            room += self.is_level(at, np.linspace(0, lengths * self.lane, _LOOKS * lengths + 1), turn)
        return room

    def least_uneven(self, at: _At) -> Ints:
        """Return all places, those first with even ground below the feet."""
        differs = np.ptp(self._below(self.blocks, self.feet, at, (0.0,), 0.0), axis=1)
        return np.argsort(differs, kind="stable")

    def put_down(self, at: _At) -> Iterator[_Place]:
        """Yield how a robot rests at each place, and what is wrong about standing there."""
        rest = settle(self.ground, self.body, *at)
        poses = of_settled(self.ground, self.body, rest)
        _, above = sample_heights(self.ground, self.body, rest, np.arange(len(rest.x)))
        wrong = {
            _Fault.TIPS: ~has_stood(rest),
            _Fault.TILTS: poses.tilt > self.most_tilt + EXACT,
            _Fault.FRAME: self._on_frame(poses),
            _Fault.HANGS: above[:, self.hanging].min(axis=1, initial=np.inf) < _SPARE,
            _Fault.UNSTEADY: poses.tip_angle < self.steep,
            _Fault.STUCK: ~poses.pushes,
        }
        faults = np.select(list(wrong.values()), list(wrong), _Fault.NONE)
        (left,) = np.nonzero(faults == _Fault.NONE)
        faults[left[~self._is_open(_some(at, left))]] = _Fault.CAUGHT
        columns = (poses.x, poses.y, poses.z, poses.yaw, poses.roll, poses.pitch, poses.tilt, poses.tip_angle)
        for fault, row in zip(faults.tolist(), np.round(np.stack(columns, axis=1), 6) + 0.0, strict=True):
            yield _place(_Fault(fault), row.tolist())

    def _on_frame(self, poses: Poses) -> Mask:
        corners = np.nan_to_num(poses.support[..., :2])
        cells = np.floor(corners / self.field.block_width + np.array(self.field.shape) / 2).astype(np.intp)
        i, j = (np.clip(cells[..., axis], 0, self.field.shape[axis] - 1) for axis in (0, 1))
        return np.asarray(self.field.frame[i, j].any(axis=1))

    def _is_open(self, at: _At) -> Mask:
        """Return from which places the robot is nowhere steep at a few poses of the lane ahead."""
        x, y, yaw = (np.repeat(values, _LOOKS) for values in at)
        along = np.tile(np.arange(1, _LOOKS + 1) * self.lane / _LOOKS, len(at[0]))
        looks = settle(self.ground, self.body, x + np.cos(yaw) * along, y + np.sin(yaw) * along, yaw)
        return np.asarray(~self._is_steep(looks).reshape(-1, _LOOKS).any(axis=1))

    def left(self, places: Sequence[Spot]) -> list[Spot | None]:
        """Return the spots of those places from which a lane ahead is driven to its end, never steep, without a fall.

        It is put down once more, where it rests: a place at the very edge of a block is none, and of two ways to stand
        there the spot has the one in which it stands then.
        """
        x, y, yaw = np.array([(spot.x, spot.y, spot.yaw) for spot in places]).T
        again = list(self.put_down((x, y, yaw)))
        leaves = np.array([fault is _Fault.NONE for fault, _ in again])
        # Only from where it still rests as a spot must is a lane driven, the dearest of the checks.
        if leaves.any():
            lanes = drive_lanes(self.ground, self.body, *_some((x, y, yaw), leaves), self.lane)
            heights, steep = (
                values.reshape(leaves.sum(), -1) for values in (lanes.poses.z, self._is_steep(lanes.poses))
            )
            falls = -np.diff(heights, axis=1).min(axis=1, initial=0.0)
            leaves[leaves] = lanes.passed & ~steep.any(axis=1) & (falls <= self.fall)
        return [
            replace(rest, x=spot.x, y=spot.y, yaw=spot.yaw) if is_left else None
            for spot, (_, rest), is_left in zip(places, again, leaves, strict=True)
        ]

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


def _place(fault: _Fault, row: Sequence[float]) -> _Place:
    x, y, z, yaw, roll, pitch, tilt, tip_angle = row
    reason = fault.reason(degrees(tilt), degrees(tip_angle))
    return fault, Spot(x=x, y=y, z=z, yaw=yaw, roll=roll, pitch=pitch, tilt=tilt, tip_angle=tip_angle, reason=reason)


def find_spots(  # noqa: PLR0913  # the last three by name
    field: StepField,
    body: Body,
    count: int,
    rng: np.random.Generator,
    *,
    gap: float = 0.0,
    most_tilt: float = MOST_TILT,
    evenest: bool = False,
) -> tuple[Spot, ...]:
    """Return `count` spots at least `gap` metres apart; most_tilt: the largest tilt there, radians.

    evenest: if there are too few, take places where the robot stands at all, with what is wrong about them: those first
    that were refused last, and of these the least tilted. ParameterError if there are too few.
    """
    judge = _judge(field, body, most_tilt, [Bounds.of(field)])
    (part,) = _searched_parts(judge, [Bounds.of(field)], count, [rng], gap)
    return part.spots(evenest=evenest)


def _judge(field: StepField, body: Body, most_tilt: float, parts: Sequence[Bounds]) -> _Judge:
    """Return the judge of a robot on a field; ParameterError if it is larger than one of these parts."""
    for bounds in parts:
        if not fits(bounds, body):
            n_x, n_y = (
                round((high - low) / field.block_width) for low, high in zip(bounds.low, bounds.high, strict=True)
            )
            raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; use a smaller robot or a larger map")
    return _Judge(field, body, most_tilt)


@dataclass(kw_only=True, slots=True)
class _Part:
    """The search in a part of a field: the places that are drawn, the spots that are chosen, and places that are none.

    drawn: (3, n), random numbers of each place; level: the first places where the ground is level; order: those to be
    tried, best first; tried: how many of them were; waiting: those at which the robot was put down
    """

    bounds: Bounds
    half: float
    drawn: Array
    outline: Outline
    gap: float
    count: int
    lanes: int
    level: Ints = field_of(default_factory=lambda: np.empty(0, np.intp))
    order: Ints = field_of(default_factory=lambda: np.empty(0, np.intp))
    tried: int = 0
    waiting: list[_Place] = field_of(default_factory=list)
    chosen: list[Spot] = field_of(default_factory=list)
    others: list[_Place] = field_of(default_factory=list)

    @property
    def is_over(self) -> bool:
        """Return whether there are enough spots, or enough was tried."""
        return len(self.chosen) == self.count or not self.lanes

    def places(self, numbers: Ints) -> tuple[_At, Mask]:
        """Return places by their numbers, every second one on a half cell with a heading of 16; and which are inside.

        Inside is where the robot is wholly within the bounds.
        """
        even, (along, across, turn) = numbers % 2 == 0, self.drawn[:, numbers]
        yaw = np.where(even, np.floor(turn * HEADINGS) / HEADINGS, turn) * 2 * pi
        room, half = range_inside(self.bounds, self.outline, yaw), self.half
        inside = np.asarray((room[:, 0] <= room[:, 1]).all(axis=0))
        sides: list[Array] = []
        for (low, high), share, rim in zip(room, (along, across), self.bounds.low, strict=True):
            # The edges of cells are at multiples of a block from the rim, so their halves are too.
            first, last = np.ceil((low - rim) / half - EXACT), np.floor((high - rim) / half + EXACT)
            inside &= ~even | (first <= last)
            on_halves = rim + half * (first + np.floor(share * (last - first + 1)))
            sides.append(np.where(even, on_halves, low + share * (high - low)))
        return (sides[0], sides[1], yaw), inside

    def inside(self, begin: int, end: int) -> tuple[Ints, _At]:
        """Return the numbers of places that are inside, of those from a number on, and the places."""
        numbers = np.arange(begin, min(end, self.drawn.shape[1]))
        at, inside = self.places(numbers)
        return numbers[inside], _some(at, inside)

    def next_places(self, count: int) -> _At:
        """Return the next places of the order that are apart from all that are chosen."""
        at, _ = self.places(self.order[self.tried : self.tried + count])
        self.tried += count
        return self._free(at)

    def next_spot(self) -> Spot | None:
        """Return the next of the waiting places that is no bad one, nor too near to a spot; None if none is left."""
        while self.waiting:
            fault, spot = self.waiting.pop(0)
            if fault is not _Fault.NONE:
                self.others.append((fault, spot))
            elif self._is_free(spot):
                self.lanes -= 1
                return spot
        return None

    def take(self, place: Spot, spot: Spot | None) -> None:
        """Choose the spot of a place, if the robot leaves it."""
        if spot:
            self.chosen.append(spot)
        else:
            self.others.append((_Fault.CAUGHT, replace(place, reason=_Fault.CAUGHT.reason(0, 0))))

    def spots(self, *, evenest: bool) -> tuple[Spot, ...]:
        """Return the spots; ParameterError if there are too few, also with the places at which it stands at all."""
        if evenest:
            for fault, spot in sorted(self.others, key=_by_fault_and_tilt):
                if len(self.chosen) < self.count and fault is not _Fault.TIPS and self._is_free(spot):
                    self.chosen.append(spot)
        if len(self.chosen) == self.count:
            return tuple(self.chosen)
        if self.chosen:
            enough = f"found spots for {len(self.chosen)} of {self.count} on this map"
            raise NoSpot("count", f"{enough}; use fewer, or {_HELP}")
        reason = min(self.others, key=_by_fault_and_tilt)[1].reason
        raise NoSpot("robot", f"no spot on this map: at the best place it {reason}; {_HELP}")

    def _free(self, at: _At) -> _At:
        free = np.ones(len(at[0]), bool)
        for spot in self.chosen:
            free &= apart(self.outline, self.gap, *at, spot)
        return _some(at, free)

    def _is_free(self, spot: Spot) -> bool:
        place = np.array([spot.x]), np.array([spot.y]), np.array([spot.yaw])
        return len(self._free(place)[0]) > 0


def _by_fault_and_tilt(place: _Place) -> tuple[int, float]:
    return -place[0], place[1].tilt


_HELP = "add a platform obstacle, or use a smaller robot or another map"


def _searched_parts(
    judge: _Judge, bounds: Sequence[Bounds], count: int, rngs: Sequence[np.random.Generator], gap: float
) -> list[_Part]:
    """Return the search in each part of a field: level places first, the roomy ones of them before, then all others."""
    parts = [
        _Part(
            bounds=area,
            half=judge.field.block_width / 2,
            drawn=rng.random((3, _DRAWN)),
            outline=Outline.of(judge.body),
            gap=gap,
            count=count,
            lanes=_LANES + _MORE_LANES * count,
        )
        for area, rng in zip(bounds, rngs, strict=True)
    ]
    # Level places come first: look-ups find them, and only the roomy ones have to settle, which costs far more.
    _find_level(judge, parts)
    places = [part.places(part.level)[0] for part in parts]
    for part, room in zip(parts, _split(judge.level_lanes(_joined(places)), places), strict=True):
        part.order = part.level[np.argsort(-room, kind="stable")][: _SETTLED + _MORE * count]
    _try(judge, parts)
    for part in parts:
        if not part.is_over:
            numbers, at = part.inside(0, _DRAWN)
            others = numbers[judge.least_uneven(at)]
            part.order, part.tried = others[~np.isin(others, part.level)][:_LEAST_UNEVEN], 0
    _try(judge, parts)
    return parts


def _find_level(judge: _Judge, parts: Sequence[_Part]) -> None:
    """Find the first places of each part where the ground is level, 2,000 in all; more are drawn of parts with few."""
    most = max(_LOOKED_AT // len(parts), _LEAST_LOOKED_AT)
    begin, count, searched = 0, most, list(parts)
    while searched:
        numbers, places = zip(*(part.inside(begin, begin + count) for part in searched), strict=True)
        for part, own, level in zip(searched, numbers, _split(judge.is_level(_joined(places)), places), strict=True):
            part.level = np.append(part.level, own[level])[:most]
        begin, count = begin + count, 2 * count
        searched = [part for part in searched if len(part.level) < most and begin < _DRAWN]


def _try(judge: _Judge, parts: Sequence[_Part]) -> None:
    """Put the robot down at the places of each part's order, and let it drive away, until there are enough spots."""
    at_once = max(_AT_ONCE // len(parts), _LEAST_AT_ONCE)
    while searched := [part for part in parts if not part.is_over and part.tried < len(part.order)]:
        places = [part.next_places(at_once) for part in searched]
        poses = judge.put_down(_joined(places))
        for part, own in zip(searched, places, strict=True):
            part.waiting = list(islice(poses, len(own[0])))
        while waiting := [(part, spot) for part in searched if not part.is_over and (spot := part.next_spot())]:
            for (part, place), spot in zip(waiting, judge.left([place for _, place in waiting]), strict=True):
                part.take(place, spot)


def _joined(places: Sequence[_At]) -> _At:
    x, y, yaw = (np.concatenate(values) for values in zip(*places, strict=True))
    return x, y, yaw


def _split(values: _Values, places: Sequence[_At]) -> list[_Values]:
    """Return the values of joined places, those of each apart."""
    ends = np.cumsum([len(at[0]) for at in places])
    return [values[end - len(at[0]) : end] for end, at in zip(ends, places, strict=True)]


GAP = 0.1
"""Gap, metres, between a robot and the map next to it, and between two robots: more than they drift on the way."""


spots_on_map = partial(find_spots, gap=GAP)
"""Return spots for robots on a map, which do not overlap (`spots`)."""


def spot_generator(seed: int) -> np.random.Generator:
    """Return the generator of the places of robots: `rsegen spots` gives those at which `rsegen drive` starts."""
    return generator(seed, 0, "places")
