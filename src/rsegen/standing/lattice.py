"""The state lattice of a robot on a field: which places it reaches, and its best ways there.

Moves between the centres of neighbouring cells, in eight headings, are lanes (lanes.py); no move leads along a frame.
Turns on the spot are poses between two headings. The moves and turns that the robot can make are a graph over
(x, y, heading), a state lattice (Pivtoraiko, Knepper and Kelly 2009). On it places are reached (strongly connected
components) and ways are found (Dijkstra 1959): the shortest one, a short and safe one, or the shortest with the least
maximum tilt or the largest minimum margin, the angle by which the robot must be turned to tip over.

    o   o   @---o-->     o  middle of a cell, in each of eight headings
          /              -  move: a lane to the next middle in its heading, which the robot drives to its end
    o---@   o   x        @  turn by 45 degrees: the robot stands before, half-way and after it
                         x  no move leads here: it would tip over, hit a block or be stuck
    o   o   o   o

What the robot can do at a place is found once it is asked for. A region (reach.py) asks for half of it. A way asks for
little: the robot is trusted with all moves, what is not known of the best way is found, and so on (`_cheapest`).

Cost: some 12 poses a move, or as many as steps of the robot; for a way one to three seconds, or as long as for a region
if no way leads there. What breaks it: what breaks lanes; and each move begins at the robot's full speed, which it may
not have after the move before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import count

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.evidence import MOVE, Evidence
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import drive_lanes, lines_along, steps_on
from rsegen.standing.resting import has_stood, margins
from rsegen.standing.settling import Settled, joined, outer_radius, settle, settled_on_level

HEADINGS = 8

MOVES = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
"""Cells by which a move in each heading goes on along x and y; heading k is k times 45 degrees."""

BEST = ("safe", "length", "tilt", "margin")
"""Criteria of the best way: short and safe, the shortest, the least tilt, or the largest margin."""

_RISK = 3.0
"""Weight of risk in a safe way: a metre at half of the tilt at which the robot tips over counts as 2.5 metres on level
ground, and one on which it falls as four."""

_MOST_RISK = 2.0
"""The largest tilt of a robot that stands, as a share of that at which it tips over on level ground."""

Place = tuple[int, int, int]
"""Cells along x and y, and the heading."""

Lane = tuple[float, float]
"""Metres as which a lane onto the map or off it counts, and the worst on it."""

_AROUND = 2
"""Cells around a way at which poses are found with those on it."""

_FEW_STEPS = 30
"""Steps of a move by a block up to which its middle is not looked at before all of it: the robot is no small one."""

_LANES = 2000
"""Lanes whose poses are found together: some ten thousand poses."""

_REPORT_EVERY = 20_000
"""Places that a search looks at between two reports, each of which may end it: a fifth of a second."""

Watch = Callable[[float], object]
"""Called now and then with the share of a search that is done; what it raises ends the search."""


def unwatched(_: float) -> None:
    """Ignore the progress of a search that nobody watches."""


class Lattice:
    """The moves of a robot between the centres of a field's cells in eight headings, and those that it can make.

    A move or turn is tried once it is asked for: behind a wall that stops the robot nothing is tried.

    best: which ways are the best, one of BEST; it decides what "the worst" on a move is, the smaller the better: the
    largest tilt, radians; the negative of the least margin; or, for safe ways, the tilt as a share of the tilt at which
    it tips over on level ground, 1 for a fall
    moves, turns: (n_x, n_y, 8) whether it can drive on to the next cell, and turn to the next heading and back
    worst_of_moves, worst_of_turns: the worst on each; False and 0 where not yet found
    evidence: what drives have shown of moves; None before the first drive
    watch: called with the share of the search that is done
    """

    evidence: Evidence | None = None

    def __init__(self, field: StepField, body: Body, best: str = "length", watch: Watch = unwatched) -> None:
        self.field, self.body, self.best, self.watch = field, body, best, watch
        self._share = 0.0
        self.ground = PaddedGround.of(field, outer_radius(body))
        self.x, self.y = field.middles()
        shape = (*field.shape, HEADINGS)
        self.moves, self.turns, self.stands = (np.zeros(shape, bool) for _ in range(3))
        self.is_driven, self.is_turned, self.is_settled = (np.zeros(shape, bool) for _ in range(3))
        self.worst_of_moves, self.worst_of_turns = np.zeros(shape), np.zeros(shape)
        self._worst_of_places = np.full(shape, -np.inf if best == "margin" else 0.0)  # no pose is better
        # The tilt at which it tips over on level ground, in which the risk of a safe way is counted.
        self._tips_at = _margin_on_level(self.ground, body) if best == "safe" else np.inf
        self.turn_length = body.width / 2 * np.pi / 4
        self._lengths = field.block_width * np.hypot(*np.broadcast_to(MOVES, (*shape, 2)).T).T.ravel()
        nowhere = np.empty(0)
        self._rest, self._number_of_rest = settle(self.ground, body, nowhere, nowhere, nowhere), np.full(shape, -1)

    def tell(self, share: float) -> None:
        """Report the share of the search that is done, never less than before: a way is searched after a region."""
        self._share = max(self._share, share)
        self.watch(self._share)

    def settle_at(self, places: Ints) -> None:
        """Find whether the robot stands at places, numbers in `moves`, and how bad that is."""
        places = np.unique(places[~self.is_settled.ravel()[places]])
        if not len(places):
            return
        self.is_settled.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.moves.shape)
        rest = settle(self.ground, self.body, self.x[i], self.y[j], k * np.pi / 4)
        self.stands.ravel()[places], self._worst_of_places.ravel()[places] = has_stood(rest), self.worst_value(rest)
        self._number_of_rest.ravel()[places] = len(self._rest.x) + np.arange(len(places))
        self._rest = joined([self._rest, rest])

    def _moves_from(self, places: Ints) -> tuple[Ints, Ints]:
        """Return the places from which a move leads on, out of some, and the places to which it leads."""
        i, j, k = np.unravel_index(places, self.moves.shape)
        on_i, on_j = i + MOVES[k, 0], j + MOVES[k, 1]
        inside = (on_i >= 0) & (on_i < self.moves.shape[0]) & (on_j >= 0) & (on_j < self.moves.shape[1])
        places, i, j, k, on_i, on_j = (values[inside] for values in (places, i, j, k, on_i, on_j))
        # No move leads along a frame, nor diagonally within a double one.
        rows, columns = (lines_along(self.field, axis) for axis in (0, 1))
        free = ((i == on_i) | rows[j] | rows[on_j]) & ((j == on_j) | columns[i] | columns[on_i])
        return places[free], np.ravel_multi_index((on_i[free], on_j[free], k[free]), self.moves.shape)

    @cached_property
    def all_moves(self) -> tuple[Ints, Ints]:
        """The places from which moves lead on, and those to which they lead."""
        return self._moves_from(np.arange(self.moves.size))

    def drive_from(self, places: Ints) -> None:
        """Find the moves from places."""
        places = places[~self.is_driven.ravel()[places]]
        self.is_driven.ravel()[places] = True
        places, ahead = self._moves_from(places)
        i, j, k = np.unravel_index(places, self.moves.shape)
        # Most moves of a robot that is smaller than the blocks end where it tips over: three poses rule them out.
        self.settle_at(np.concatenate([places, ahead]))
        left = np.flatnonzero(self.stands.ravel()[places] & self.stands.ravel()[ahead])
        if steps_on(self.body, self.field.block_width) > _FEW_STEPS:
            middle = self.field.block_width / 2 * MOVES[k[left]].T
            x, y = self.x[i[left]] + middle[0], self.y[j[left]] + middle[1]
            left = left[has_stood(settle(self.ground, self.body, x, y, k[left] * np.pi / 4))]
        if len(left):
            length = self.field.block_width * np.where(k[left] % 2 == 1, 2**0.5, 1.0)
            starts = self.x[i[left]], self.y[j[left]], k[left] * np.pi / 4
            passed, worst = self.driven(*starts, length, (places[left], ahead[left]))
            self.moves.ravel()[places[left]], self.worst_of_moves.ravel()[places[left]] = passed, worst

    def turn_at(self, places: Ints) -> None:
        """Find whether the robot can turn from places to their next headings, and back: at both, and half-way."""
        places = places[~self.is_turned.ravel()[places]]
        self.is_turned.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.turns.shape)
        after = np.ravel_multi_index((i, j, (k + 1) % HEADINGS), self.moves.shape)
        self.settle_at(np.concatenate([places, after]))
        able = self.stands.ravel()[places] & self.stands.ravel()[after]
        places, after = places[able], after[able]
        i, j, k = np.unravel_index(places, self.turns.shape)
        rest = settle(self.ground, self.body, self.x[i], self.y[j], (k + 0.5) * np.pi / 4)
        self.turns.ravel()[places] = has_stood(rest)
        ends = self._worst_of_places.ravel()
        self.worst_of_turns.ravel()[places] = np.maximum.reduce([ends[places], ends[after], self.worst_value(rest)])

    def driven(
        self, x: Array, y: Array, yaw: Array, length: Array, ends: tuple[Ints, Ints] | None = None
    ) -> tuple[Mask, Array]:
        """Return which lanes are driven to their ends, and the worst on each; ends: the places there, if known."""
        passed, worst = [], []
        numbers = [self._number_of_rest.ravel()[places] for places in ends] if ends else None
        for begin in range(0, len(x), _LANES):
            part = slice(begin, begin + _LANES)
            first_last = (self._rest.some(numbers[0][part]), self._rest.some(numbers[1][part])) if numbers else None
            lanes = drive_lanes(self.ground, self.body, x[part], y[part], yaw[part], length[part], ends=first_last)
            passed.append(lanes.passed)
            count = lanes.drops.shape[1]
            values = self.worst_value(lanes.poses.some(np.flatnonzero(np.repeat(lanes.passed, count))))
            worst.append(np.zeros(len(lanes.end)))
            worst[-1][lanes.passed] = values.reshape(-1, count).max(axis=1)
            if self.best == "safe":
                worst[-1] = np.where(lanes.drops.any(axis=1), 1.0, worst[-1])
        return np.concatenate(passed), np.concatenate(worst)

    def worst_value(self, rest: Settled) -> Array:
        """Return the tilt of each robot, radians, its margin with a minus, or its share of the tilt to tip over."""
        if self.best == "margin":
            return -margins(self.ground, self.body, rest)
        return rest.tilt / self._tips_at if self.best == "safe" else rest.tilt

    def at_blocks(self) -> Settled:
        """Return the robot at rest in every heading at every block, by the blocks; known once its region is."""
        return self._rest.some(self._number_of_rest[~self.field.frame].ravel())

    def standing_at(self, i: int, j: int) -> dict[Place, Lane]:
        """Return the places of a cell at which the robot stands, with how bad its pose is there, and no lane."""
        yaw = np.arange(HEADINGS) * np.pi / 4
        rest = settle(self.ground, self.body, np.full(HEADINGS, self.x[i]), np.full(HEADINGS, self.y[j]), yaw)
        worst = self.worst_value(rest)
        return {(i, j, k): (0.0, float(worst[k])) for k in np.flatnonzero(has_stood(rest)).tolist()}

    def counted(self, part: int, places: Ints | slice, length: Array, worst: Array) -> Array:
        """Return the lengths as which moves or lanes count, infinite where closed; their own without evidence.

        For safe and short ways evidence makes them longer or shorter. Where the largest tilt or least margin decides, a
        place that held more drives than got on is closed.
        part: MOVE, IN or OUT of rsegen.standing.evidence; worst: on each
        """
        if self.evidence is None:
            return length
        if self.best in ("tilt", "margin"):
            passed, held = self.evidence.counts(part, places)
            return np.where(held > passed, np.inf, length)
        # Divided by the risk again, as the cost of a safe way multiplies by it (`best_way`).
        risk = 1 + _RISK * worst if self.best == "safe" else 1.0
        return self.evidence.metres(part, places, length * risk) / risk

    def best_way(
        self, starts: Mapping[Place, Lane], goals: Mapping[Place, Lane], left: Array
    ) -> tuple[float, list[Place]] | None:
        """Return the cost of the best way from a start to a goal, and its places; None if no goal is reached.

        left: (n_x, n_y), a lower bound of the length from each cell to a goal
        """
        # Where a drive got on, moves count less than their lengths, and the bound must stay one.
        if self.evidence is not None:
            left = left * self.evidence.least_share(float(self._lengths.max()) * (1 + _RISK * _MOST_RISK))
        if self.best == "safe":
            return self._cheapest(starts, goals, lambda cost, length, worst: cost + length * (1 + _RISK * worst), left)
        # The least maximum first, then the shortest way that does not exceed it.
        limit = np.inf
        if self.best != "length":
            none = np.zeros(self.field.shape)
            least = self._cheapest(starts, goals, lambda cost, _, worst: max(cost, worst), none, -np.inf)
            if least is None:
                return None
            limit = least[0] + 1e-9

        def longer(cost: float, length: float, worst: float) -> float:
            return cost + length if worst <= limit else np.inf

        return self._cheapest(starts, goals, longer, left)

    def _cheapest(
        self,
        starts: Mapping[Place, Lane],
        goals: Mapping[Place, Lane],
        cost_of: Callable[[float, float, float], float],
        left: Array,
        first: float = 0.0,
    ) -> tuple[float, list[Place]] | None:
        """Return the least cost from a start to a goal, with the lanes at both, and the places between.

        All moves that are not known to fail are trusted, and are taken to be no worse than the poses at their ends. The
        unknown moves of the best way are then found, and so on until all of it is known: no other way is better than
        that one (LazySP, Dellin and Srinivasa 2016). On rough ground that takes two to twenty ways.
        cost_of: the cost after a move, from the cost before it, its length and the worst on it; it never falls
        left: of each cell a lower bound of the cost to a goal; it falls by no more than a move costs
        first: the cost before a start
        """
        of_place = np.repeat(left.ravel(), HEADINGS).tolist()
        begins, ends = (
            {int(np.ravel_multi_index(place, self.moves.shape)): lane for place, lane in lanes.items()}
            for lanes in (starts, goals)
        )
        while True:
            cheapest = _cheapest_way(begins, ends, self._hopes(), cost_of, of_place, first)
            if cheapest is None:
                return None
            cost, way = cheapest
            if self._knows(np.array(way)):
                return cost, [self._place(at) for at in way]

    def _place(self, number: int) -> Place:
        """Return the place of a number in `moves`."""
        cell, k = divmod(number, HEADINGS)
        return (*divmod(cell, self.field.shape[1]), k)

    def _hopes(self) -> Callable[[int], Iterator[tuple[int, float, float]]]:
        """Return a function that yields the moves and turns from a place: where to, the length, and the worst on it.

        Places are numbers in `moves`. The worst is a lower bound where it is not yet found; a turn is as long as the
        path of the robot's sides.
        """
        # A pose that tips over rules a move out; else, until it is driven, it is as bad as the worse pose at its ends.
        tails, heads = self.all_moves
        fails = (self.is_settled & ~self.stands).ravel()
        least = np.where(fails, np.inf, self._worst_of_places.ravel())
        leads_to, hoped = np.full(self.moves.size, -1), np.full(self.moves.size, np.inf)
        leads_to[tails], hoped[tails] = heads, np.maximum(least[tails], least[heads])
        known = np.where(self.moves, self.worst_of_moves, np.inf).ravel()
        worst = np.where(self.is_driven.ravel(), known, hoped)
        lengths = self.counted(MOVE, slice(None), self._lengths, np.where(np.isfinite(worst), worst, 0.0))
        # Lists, as A* reads numbers one by one, for which arrays are slow.
        moves, lengths = np.where(np.isfinite(lengths), worst, np.inf).tolist(), lengths.tolist()
        least = least.reshape(self.turns.shape)
        known, hoped = np.where(self.turns, self.worst_of_turns, np.inf), np.maximum(least, np.roll(least, -1, axis=2))
        turns, ahead = np.where(self.is_turned, known, hoped).ravel().tolist(), leads_to.tolist()

        looked_at = count(1)

        def onward(at: int) -> Iterator[tuple[int, float, float]]:
            if not next(looked_at) % _REPORT_EVERY:
                self.tell(0.0)
            # Headings wrap around; a turn to the right is kept as the turn to the left of the place it leads to.
            k = at % HEADINGS
            to_left, to_right = at + 1 - HEADINGS * (k == HEADINGS - 1), at - 1 + HEADINGS * (k == 0)
            if moves[at] < np.inf:
                yield ahead[at], lengths[at], moves[at]
            if turns[at] < np.inf:
                yield to_left, self.turn_length, turns[at]
            if turns[to_right] < np.inf:
                yield to_right, self.turn_length, turns[to_right]

        return onward

    def _knows(self, places: Ints) -> bool:
        """Return whether all poses, moves and turns of a way are known; else find the poses, or then the moves.

        Poses at the places around are found with them: the next ways mostly lead there, and a call for few is as dear.
        places: numbers in `moves`
        """
        i, j, k = np.unravel_index(places, self.moves.shape)
        if not self.is_settled.ravel()[places].all():
            aside = np.arange(-_AROUND, _AROUND + 1)
            x, y = np.broadcast_arrays(i[:, None, None] + aside[:, None], j[:, None, None] + aside)
            inside = (x >= 0) & (x < self.field.shape[0]) & (y >= 0) & (y < self.field.shape[1])
            cells = x[inside] * self.field.shape[1] + y[inside]
            self.settle_at((cells[:, None] * HEADINGS + np.arange(HEADINGS)).ravel())
            return False
        # Headings between places: 0 for a move, 1 for a turn to the left, 7 to the right, as a turn of the next place.
        turned = np.diff(k) % HEADINGS
        moves, turns = places[:-1][turned == 0], np.where(turned == 1, places[:-1], places[1:])[turned > 0]
        moves, turns = moves[~self.is_driven.ravel()[moves]], turns[~self.is_turned.ravel()[turns]]
        self.drive_from(moves)
        self.turn_at(turns)
        self.tell(float(self.is_driven.mean()))
        return not len(moves) and not len(turns)


def _margin_on_level(ground: PaddedGround, body: Body) -> float:
    """Return the tilt at which a robot tips over on level ground, radians."""
    level, rest = settled_on_level(ground, body)
    return float(margins(level, body, rest)[0])


# The cheapest way through a graph that is given place by place.


_BEYOND = -1
"""The place behind all goals, to which each leads."""


def _cheapest_way(
    starts: Mapping[int, tuple[float, float]],
    goals: Mapping[int, tuple[float, float]],
    onward: Callable[[int], Iterable[tuple[int, float, float]]],
    cost_of: Callable[[float, float, float], float],
    left: Sequence[float],
    first: float = 0.0,
) -> tuple[float, list[int]] | None:
    """Return the least cost from a start to a goal, and the places between; None if no goal is reached.

    Of all places at the front the one with the least sum of its cost and the bound of what is left goes on (A*, Hart,
    Nilsson and Raphael 1968). Cost: each place once, and each move out of it, in Python: some microseconds.

    starts, goals: length and worst of the lane that leads there, or on from there; places are numbers from 0 on
    onward: places to which a place leads, the length of each move, and the worst on it
    cost_of: the cost after a move, from the cost before it, its length and the worst on it; it never falls
    left: of each place a lower bound of the cost to a goal, which falls by no more than a move costs
    first: the cost before a start
    """
    costs, before = {at: cost_of(first, *lane) for at, lane in starts.items()}, dict[int, int]()
    # Of equal sums the place with the shorter way so far goes on.
    front = [(cost + left[at], 0.0, at) for at, cost in costs.items() if cost < np.inf]
    heapify(front)
    done, arrived = set[int](), np.inf
    while front:
        _, run, at = heappop(front)
        if at == _BEYOND:
            return arrived, _traced(before)
        if at in done:
            continue
        # A goal leads on to the place behind all goals: the search ends once that is the cheapest at the front.
        done.add(at)
        if at in goals and (last := cost_of(costs[at], *goals[at])) < arrived:
            arrived, before[_BEYOND] = last, at
            heappush(front, (last, run, _BEYOND))
        for on, length, worst in onward(at):
            after = cost_of(costs[at], length, worst)
            if after < costs.get(on, np.inf) - 1e-9:
                costs[on], before[on] = after, at
                heappush(front, (after + left[on], run + length, on))
    return None


def _traced(before: Mapping[int, int]) -> list[int]:
    """Return the places from a start to a goal, by the place before each."""
    way = [before[_BEYOND]]
    while way[-1] in before:
        way.append(before[way[-1]])
    return way[::-1]
