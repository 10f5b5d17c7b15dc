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

from collections.abc import Sequence
from dataclasses import dataclass, replace
from dataclasses import field as field_of
from functools import partial
from itertools import islice
from math import pi, radians

import numpy as np

from rsegen.errors import NoSpot, ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.streams import generator
from rsegen.standing.body import Body
from rsegen.standing.outlines import EXACT, HEADINGS, Bounds, Outline, apart, fits, range_inside
from rsegen.standing.spot_judge import At, Fault, Place, Spot, SpotJudge, Values, some

MOST_TILT = radians(3)
"""Largest tilt at which a robot may rest at its start. A robot 40 cm wide then stands on heights that differ by 2 cm at
most, which are the gaps and tolerances of sawn blocks; a whole unit tilts it by far more."""

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

_LOOKED_AT, _LEAST_LOOKED_AT = 2000, 64
"""Places with level ground of which the room ahead is looked at, and the roomiest are taken first; of many parts of a
field, which are looked at together, at least 64 each.
"""


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


def _judge(field: StepField, body: Body, most_tilt: float, parts: Sequence[Bounds]) -> SpotJudge:
    """Return the judge of a robot on a field; ParameterError if it is larger than one of these parts."""
    for bounds in parts:
        if not fits(bounds, body):
            n_x, n_y = (
                round((high - low) / field.block_width) for low, high in zip(bounds.low, bounds.high, strict=True)
            )
            raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; use a smaller robot or a larger map")
    return SpotJudge(field, body, most_tilt)


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
    waiting: list[Place] = field_of(default_factory=list)
    chosen: list[Spot] = field_of(default_factory=list)
    others: list[Place] = field_of(default_factory=list)

    @property
    def is_over(self) -> bool:
        """Return whether there are enough spots, or enough was tried."""
        return len(self.chosen) == self.count or not self.lanes

    def places(self, numbers: Ints) -> tuple[At, Mask]:
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

    def inside(self, begin: int, end: int) -> tuple[Ints, At]:
        """Return the numbers of places that are inside, of those from a number on, and the places."""
        numbers = np.arange(begin, min(end, self.drawn.shape[1]))
        at, inside = self.places(numbers)
        return numbers[inside], some(at, inside)

    def next_places(self, count: int) -> At:
        """Return the next places of the order that are apart from all that are chosen."""
        at, _ = self.places(self.order[self.tried : self.tried + count])
        self.tried += count
        return self._free(at)

    def next_spot(self) -> Spot | None:
        """Return the next of the waiting places that is no bad one, nor too near to a spot; None if none is left."""
        while self.waiting:
            fault, spot = self.waiting.pop(0)
            if fault is not Fault.NONE:
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
            self.others.append((Fault.CAUGHT, replace(place, reason=Fault.CAUGHT.reason(0, 0))))

    def spots(self, *, evenest: bool) -> tuple[Spot, ...]:
        """Return the spots; ParameterError if there are too few, also with the places at which it stands at all."""
        if evenest:
            for fault, spot in sorted(self.others, key=_by_fault_and_tilt):
                if len(self.chosen) < self.count and fault is not Fault.TIPS and self._is_free(spot):
                    self.chosen.append(spot)
        if len(self.chosen) == self.count:
            return tuple(self.chosen)
        if self.chosen:
            enough = f"found spots for {len(self.chosen)} of {self.count} on this map"
            raise NoSpot("count", f"{enough}; use fewer, or {_HELP}")
        reason = min(self.others, key=_by_fault_and_tilt)[1].reason
        raise NoSpot("robot", f"no spot on this map: at the best place it {reason}; {_HELP}")

    def _free(self, at: At) -> At:
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


def _searched_parts(
    judge: SpotJudge, bounds: Sequence[Bounds], count: int, rngs: Sequence[np.random.Generator], gap: float
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


def _find_level(judge: SpotJudge, parts: Sequence[_Part]) -> None:
    """Find the first places of each part where the ground is level, 2,000 in all; more are drawn of parts with few."""
    most = max(_LOOKED_AT // len(parts), _LEAST_LOOKED_AT)
    begin, count, searched = 0, most, list(parts)
    while searched:
        numbers, places = zip(*(part.inside(begin, begin + count) for part in searched), strict=True)
        for part, own, level in zip(searched, numbers, _split(judge.is_level(_joined(places)), places), strict=True):
            part.level = np.append(part.level, own[level])[:most]
        begin, count = begin + count, 2 * count
        searched = [part for part in searched if len(part.level) < most and begin < _DRAWN]


def _try(judge: SpotJudge, parts: Sequence[_Part]) -> None:
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


def _joined(places: Sequence[At]) -> At:
    x, y, yaw = (np.concatenate(values) for values in zip(*places, strict=True))
    return x, y, yaw


def _split(values: Values, places: Sequence[At]) -> list[Values]:
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
