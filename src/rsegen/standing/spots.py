"""Spots: places at which a robot stands level and firmly, and from which it can drive away, drawn at random.

1. Places are drawn: half of them at centres, edges and corners of cells with one of 16 headings, as platforms have
   them, the others anywhere. Those come first where the ground is level below the robot's feet, its contacts on level
   ground, and nowhere too high; of these, those where it is so ahead too, the more the better: some look-ups each.
2. There the robot is put down (settling.py). It must stand within the largest tilt, on its feet and driven parts alone,
   not on a frame, far from tipping over, and be able to push itself on (resting.py, pushing.py).
3. It must drive away: ahead, over a lane a little longer than itself (lanes.py), without tilting or falling so far that
   it might tip over. The top of a tower is level, and no spot.

Cost: some tenths of a second, on a map of any size, since a bounded number of places is drawn. What breaks it: a map
with very few spots among very many places; they may be missed.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np

from rsegen.errors import NoSpot, ParameterError
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.streams import generator
from rsegen.standing.body import Body
from rsegen.standing.outlines import EXACT, HEADINGS, Outline, Spot, apart, fits, range_inside
from rsegen.standing.spot_judge import At, Fault, Place, SpotJudge, some

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
"""Places with other ground at which it is put down at last, the least uneven ones first."""

_LANES, _MORE_LANES = 48, 6
"""Places from which it is driven away at most, and more of them for each spot: 20 milliseconds a lane."""

_LOOKED_AT = 2000
"""Places with level ground of which the room ahead is looked at, and the roomiest are taken first."""


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

    evenest: if there are too few, take places where the robot stands at all, with what is wrong about them: those first
    that were refused last, and of these the least tilted. ParameterError if there are too few.
    """
    if not fits(field, body):
        n_x, n_y = field.shape
        raise ParameterError("robot", f"too large for {n_x} x {n_y} cells; use a smaller robot or a larger map")
    search = _Search(SpotJudge(field, body, most_tilt), count, rng, gap)
    search.try_level_places()
    return search.spots(evenest=evenest)


class _Search:
    """A search for spots: the places that are drawn, the spots that are chosen, and places that are none.

    drawn: (3, n), random numbers of each place; lanes: places from which the robot may still be driven away
    """

    def __init__(self, judge: SpotJudge, count: int, rng: np.random.Generator, gap: float) -> None:
        self.judge, self.count, self.gap = judge, count, gap
        self.drawn, self.outline = rng.random((3, _DRAWN)), Outline.of(judge.body)
        self.lanes = _LANES + _MORE_LANES * count
        self.chosen: list[Spot] = []
        self.others: list[Place] = []

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
                    self.others.append((fault, spot))
                elif self._is_free(spot):
                    self.drive_away(spot)
                    if self.is_over:
                        return

    def drive_away(self, place: Spot) -> None:
        """Choose the spot of a place, if the robot leaves it."""
        self.lanes -= 1
        if spot := self.judge.left(place):
            self.chosen.append(spot)
        else:
            self.others.append((Fault.CAUGHT, replace(place, reason=Fault.CAUGHT.reason(0, 0))))

    def places(self, numbers: Ints) -> tuple[At, Mask]:
        """Return places by their numbers, every second one on a half cell with a heading of 16; and which are inside.

        Inside is where the robot is wholly within the field.
        """
        even, (along, across, turn) = numbers % 2 == 0, self.drawn[:, numbers]
        yaw = np.where(even, np.floor(turn * HEADINGS) / HEADINGS, turn) * 2 * pi
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
        """Return the places that are apart from all spots that are chosen."""
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
