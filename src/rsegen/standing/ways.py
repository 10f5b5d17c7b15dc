"""The way of a robot over a field: the pose at every step, and where and why a way ends.

1. A lane is a straight piece of a way, cut into steps of a fraction of a block. At each step the robot rests
   (settling.py), and its surplus of forward force is known (pushing.py).
2. A lane ends where the robot tips over, where an upright face of it hits a block, or where it cannot push itself on:
   the force that lacks, along the distance over which it lacks, is more than its kinetic energy gives back,

       sum of -s dx > v^2 / 2 g

3. Drops and slips are told, but do not end a way: a robot that slides or falls forward goes on.
4. Moves between the centres of cells, in eight headings, are lanes; turns are poses between. What is passed is a graph
   over (x, y, heading), on which places are reached (strongly connected components) and ways are shortest (Dijkstra).

Cost: poses of all lanes at once, some 20 for each move: a second to ten on 10 x 10 to 40 x 40 blocks. What breaks it:
a robot that is turned by what it climbs, as by a block under one wheel, leaves its lane; the wheels' own dynamics.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from heapq import heappop, heappush
from typing import Any

import numpy as np

from rsegen.field.metrics.graphs import strongly_connected
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.pushing import SLIDING, surplus
from rsegen.standing.resting import GRAVITY, has_stood
from rsegen.standing.settling import Ground, Settled, reach_of, settle

_STEPS = 100
"""Steps per length of a robot."""

_LEAST_STEP, _MOST_STEP = 0.0025, 0.01
"""Bounds of a step, metres: a wheel of 3 cm has turned by 5 degrees."""

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
        return np.asarray(np.arctan(np.hypot(*self.poses.slope.T)).reshape(len(self.end), -1).max(axis=1))

    @property
    def passed(self) -> Mask:
        """Return which lanes are driven to their ends, (L,)."""
        return np.asarray(self.end == End.NONE)


def step_of(body: Body) -> float:
    """Return the length of a step of a robot, metres."""
    return min(max(body.length / _STEPS, _LEAST_STEP), _MOST_STEP)


def drive(ground: Ground, body: Body, x: Array, y: Array, yaw: Array, length: float) -> Lanes:
    """Return the lanes of a length [m] that begin at x, y [m] with a heading [rad], (L,)."""
    count = max(round(length / step_of(body)), 1) + 1
    step = length / (count - 1)
    along = np.arange(count) * step
    lanes = len(x)
    every_x = (x[:, None] + np.cos(yaw)[:, None] * along).ravel()
    every_y = (y[:, None] + np.sin(yaw)[:, None] * along).ravel()
    rest = settle(ground, body, every_x, every_y, np.repeat(yaw, count))
    force = surplus(ground, body, rest).reshape(lanes, count)
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


def _hits(ground: Ground, body: Body, rest: Settled, lanes: int, count: int) -> Mask:
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


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Way:
    """The shortest way of a robot from the level ground on one side of a field to that on the other.

    crosses: whether there is one; length: metres, with turns as the path of its sides; length_ratio: to straight across
    points: (k, 2), x and y of the robot's origin, metres, empty without a way; tilt: the largest on it, radians
    reason: without a way, what ends the straight lane that gets farthest, and `at` which place, metres
    """

    crosses: bool
    length: float | None
    length_ratio: float | None
    tilt: float | None
    points: Array
    reason: str | None = None
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        self.points.setflags(write=False)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reach:
    """The places of a field that a robot can reach, and its ways across.

    cover: share of the blocks in `region`; region: (n_x, n_y), the largest set of blocks on which it gets from every
    place and heading to every other
    """

    cover: float
    west_east: Way
    south_north: Way
    region: Mask

    def __post_init__(self) -> None:
        self.region.setflags(write=False)


HEADINGS = 8
_MOVES = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
"""Cells by which a move in each heading goes on along x and y; heading k is k times 45 degrees."""

_LANES = 2000
"""Lanes whose poses are found together: some ten thousand poses."""


class Lattice:
    """The moves of a robot between the centres of a field's cells in eight headings, and those that it can make.

    What it can do at a place and heading is found once it is asked for: no robot that a wall stops is tried behind it.

    moves: (n_x, n_y, 8) whether it can drive on to the next cell; turns: (n_x, n_y, 8) whether it can turn to the next
    heading and back; tilts: (n_x, n_y, 8) the largest tilt on a move, radians; False and 0 where not yet found
    """

    def __init__(self, field: StepField, body: Body) -> None:
        self.field, self.body, self.ground = field, body, Ground.of(field, reach_of(body))
        self.x, self.y = _middles(field, 0), _middles(field, 1)
        shape = (*field.shape, HEADINGS)
        self.moves, self.turns, self.tilts = np.zeros(shape, bool), np.zeros(shape, bool), np.zeros(shape)
        self._is_driven, self._is_turned = np.zeros(shape, bool), np.zeros(shape, bool)

    def _drive_from(self, places: Ints) -> None:
        """Find the moves from places, numbers in `moves`."""
        places = places[~self._is_driven.ravel()[places]]
        self._is_driven.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.moves.shape)
        on_i, on_j = i + _MOVES[k, 0], j + _MOVES[k, 1]
        inside = (on_i >= 0) & (on_i < self.moves.shape[0]) & (on_j >= 0) & (on_j < self.moves.shape[1])
        for is_diagonal in (0, 1):
            chosen = np.flatnonzero(inside & (k % 2 == is_diagonal))
            if len(chosen):
                length = self.field.block_width * (2**0.5 if is_diagonal else 1.0)
                starts = self.x[i[chosen]], self.y[j[chosen]], k[chosen] * np.pi / 4
                passed, tilts = self._driven(*starts, length)
                self.moves.ravel()[places[chosen]], self.tilts.ravel()[places[chosen]] = passed, tilts

    def _turn_at(self, places: Ints) -> None:
        """Find whether the robot can turn from places to their next headings, and back."""
        places = places[~self._is_turned.ravel()[places]]
        self._is_turned.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.turns.shape)
        # At both headings, and half-way between.
        turn = np.add.outer((0.0, 0.5, 1.0), k).ravel()
        stands = has_stood(
            settle(self.ground, self.body, np.tile(self.x[i], 3), np.tile(self.y[j], 3), turn * np.pi / 4)
        )
        self.turns.ravel()[places] = stands.reshape(3, -1).all(axis=0)

    def _explore(self, front: Ints) -> None:
        """Find all that the robot can do from places on: wave by wave, each of the places that the last one reached."""
        seen = np.zeros(self.moves.size, bool)
        while len(front):
            seen[front] = True
            i, j, k = np.unravel_index(front, self.moves.shape)
            before = np.ravel_multi_index((i, j, (k - 1) % HEADINGS), self.moves.shape)
            after = np.ravel_multi_index((i, j, (k + 1) % HEADINGS), self.moves.shape)
            self._drive_from(front)
            self._turn_at(np.unique(np.concatenate([front, before])))
            driven = self.moves.ravel()[front]
            ahead = i[driven] + _MOVES[k[driven], 0], j[driven] + _MOVES[k[driven], 1], k[driven]
            reached = np.concatenate(
                [
                    np.ravel_multi_index(ahead, self.moves.shape),
                    after[self.turns.ravel()[front]],
                    before[self.turns.ravel()[before]],
                ]
            )
            front = np.unique(reached[~seen[reached]])

    def _driven(self, x: Array, y: Array, yaw: Array, length: float) -> tuple[Mask, Array]:
        """Return which lanes are driven to their ends, and the largest tilt on each, radians."""
        passed, tilts = [], []
        for begin in range(0, len(x), _LANES):
            part = slice(begin, begin + _LANES)
            lanes = drive(self.ground, self.body, x[part], y[part], yaw[part], length)
            passed.append(lanes.passed)
            tilts.append(lanes.tilt)
        return np.concatenate(passed), np.concatenate(tilts)

    def region(self) -> Mask:
        """Return the largest set of blocks on which the robot gets from every place and heading to every other."""
        places = np.arange(self.moves.size).reshape(self.moves.shape)
        self._drive_from(places.ravel())
        self._turn_at(places.ravel())
        low: list[Any] = []
        high, onward, back = list[Any](), list[Any](), list[Any]()
        for k, (along_x, along_y) in enumerate(_MOVES):
            # Each move once, as a pair of places: what is `next` in heading k is not `before` in any other.
            from_here, to_there = (
                _shifted(places[..., k], -axis_x, -axis_y)
                for axis_x, axis_y in ((-along_x, -along_y), (along_x, along_y))
            )
            passed = _shifted(self.moves[..., k], along_x, along_y)
            low.append(from_here.ravel())
            high.append(to_there.ravel())
            onward.append(passed.ravel())
            back.append(np.zeros(passed.size, bool))
        low.append(places.ravel())
        high.append(np.roll(places, -1, axis=2).ravel())
        onward.append(self.turns.ravel())
        back.append(self.turns.ravel())
        group = strongly_connected(places.size, *(np.concatenate(part) for part in (low, high, onward, back)))
        blocks = ~self.field.frame
        # Of each component the cells over which it is, in any heading; the one with the most blocks.
        cells = np.unique(np.stack([group, np.arange(group.size) // HEADINGS], axis=1), axis=0)
        cells = cells[blocks.ravel()[cells[:, 1]]]
        region = np.zeros(self.field.levels.size, bool)
        if len(cells):
            region[cells[cells[:, 0] == np.bincount(cells[:, 0]).argmax(), 1]] = True
        return region.reshape(self.field.shape)

    def way(self, axis: int) -> Way | None:
        """Return the shortest way across along an axis, with straight lanes at both ends; None if there is none."""
        lanes, across = self._lanes_in(axis), self.field.shape[1 - axis]
        heading, last = 2 * axis, self.field.shape[axis] - 1
        half = float(np.hypot(self.body.high[1] - self.body.low[1], 0)) / 2
        costs = np.full(self.moves.shape, np.inf)
        before = np.full((*self.moves.shape, 3), -1)
        if not lanes[1].any():
            return None
        starts = [(0, line, heading) if axis == 0 else (line, 0, heading) for line in range(across) if lanes[0][line]]
        self._explore(np.array([np.ravel_multi_index(start, self.moves.shape) for start in starts], np.intp))
        front = [(0.0, start) for start in starts]  # a heap, as all are equal
        for start in starts:
            costs[start] = 0.0
        while front:
            cost, (i, j, k) = heappop(front)
            if cost > costs[i, j, k]:
                continue
            if (i, j)[axis] == last and k == heading and lanes[1][(i, j)[1 - axis]]:
                return self._found(axis, cost, before, (i, j, k))
            for place, length in self._onward(i, j, k, half):
                if cost + length < costs[place] - 1e-9:
                    costs[place], before[place] = cost + length, (i, j, k)
                    heappush(front, (cost + length, place))
        return None

    def _onward(self, i: int, j: int, k: int, half: float) -> Iterator[tuple[tuple[int, int, int], float]]:
        """Yield the places to which the robot can go on, and the length of each move; a turn moves its sides."""
        if self.moves[i, j, k]:
            along_x, along_y = (int(cells) for cells in _MOVES[k])
            yield (i + along_x, j + along_y, k), self.field.block_width * (2**0.5 if k % 2 else 1.0)
        if self.turns[i, j, k]:
            yield (i, j, (k + 1) % HEADINGS), half * np.pi / 4
        if self.turns[i, j, k - 1]:
            yield (i, j, (k - 1) % HEADINGS), half * np.pi / 4

    def _lanes_in(self, axis: int) -> tuple[Mask, Mask]:
        """Return for each line of cells whether the robot comes in to its first cell, and gets out from its last."""
        middles = self.y if axis == 0 else self.x
        first = (self.x if axis == 0 else self.y)[0]
        edge, yaw = entry(self.field, self.body, axis), np.full(len(middles), axis * np.pi / 2)
        outward = self.field.extent[axis] / 2 - min(float(self.body.low[0]), 0.0) + step_of(self.body) + first
        results = []
        for begin, length in ((-edge, edge + first), (-first, outward)):
            along = np.full(len(middles), begin)
            x, y = (along, middles) if axis == 0 else (middles, along)
            results.append(self._driven(x, y, yaw, length)[0])
        return results[0], results[1]

    def _found(self, axis: int, cost: float, before: Ints, place: tuple[int, int, int]) -> Way:
        places = [place]
        while (previous := tuple(before[places[-1]].tolist()))[0] >= 0:
            places.append(previous)
        i, j, k = np.array(places[::-1]).T
        points = np.stack([self.x[i], self.y[j]], axis=1)
        moved = np.append(np.any(np.diff(points, axis=0) != 0, axis=1), False)
        tilt = float(self.tilts[i, j, k][moved].max(initial=0.0))
        ends = points[[0, -1]].copy()
        ends[:, axis] = -entry(self.field, self.body, axis), self.field.extent[axis] / 2 - float(self.body.low[0])
        length = cost + float(np.abs(ends[:, axis] - points[[0, -1], axis]).sum())
        kept = np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))
        return Way(
            crosses=True,
            length=length,
            length_ratio=length / float(ends[1, axis] - ends[0, axis]),
            tilt=tilt,
            points=np.concatenate([ends[:1], points[kept], ends[1:]]),
        )


def _shifted(values: Any, along_x: int, along_y: int) -> Any:
    """Return the values whose neighbour by (along_x, along_y) is in the array too."""
    n_x, n_y = values.shape
    return values[
        max(-along_x, 0) : n_x - max(along_x, 0),
        max(-along_y, 0) : n_y - max(along_y, 0),
    ]


def reach(field: StepField, body: Body) -> Reach:
    """Return where a robot gets on a field, and its shortest ways across."""
    lattice = Lattice(field, body)
    region, blocks, ways = lattice.region(), int((~field.frame).sum()), []
    for axis in (0, 1):
        lanes = straight(field, body, axis)
        ways.append(_straight_way(lanes, field, body, axis) or lattice.way(axis) or no_way(lanes, body))
    cover = float(region.sum() / blocks) if blocks else 0.0
    return Reach(cover=cover, west_east=ways[0], south_north=ways[1], region=region)


def crossing(field: StepField, body: Body, axis: int) -> Way:
    """Return the shortest way across a field along an axis, 0 for x and 1 for y.

    That is a straight one if there is one, of these the one with the least tilt; else the shortest on the lattice.
    """
    lanes = straight(field, body, axis)
    return _straight_way(lanes, field, body, axis) or Lattice(field, body).way(axis) or no_way(lanes, body)


def _straight_way(lanes: Lanes, field: StepField, body: Body, axis: int) -> Way | None:
    """Return the straight way with the least tilt; None if no lane is driven to its end."""
    if not lanes.passed.any():
        return None
    best = int(np.where(lanes.passed, lanes.tilt, np.inf).argmin())
    low, high = -entry(field, body, axis), field.extent[axis] / 2 - float(body.low[0])
    points = np.array([(low, (middle := _middles(field, 1 - axis)[best])), (high, middle)])
    return Way(
        crosses=True,
        length=high - low,
        length_ratio=1.0,
        tilt=float(lanes.tilt[best]),
        points=points if axis == 0 else points[:, ::-1].copy(),
    )


_BESIDE = 0.003
"""Metres to either side of a lane that have to be driven too: by so much a robot leaves its line in Gazebo."""


def straight_lane(field: StepField, body: Body, axis: int, middles: Array | None = None) -> float | None:
    """Return the place across, metres, of the first straight lane that is driven to its end; None if there is none.

    The lanes a little to either side of it are driven too. middles: of the lanes, by default of all lines of cells.
    """
    middles = _middles(field, 1 - axis) if middles is None else middles
    passed = straight(field, body, axis, middles).passed
    for beside in (-_BESIDE, _BESIDE):
        if passed.any():
            passed[passed] = straight(field, body, axis, middles[passed] + beside).passed
    return float(middles[passed.argmax()]) if passed.any() else None


def _middles(field: StepField, axis: int) -> Array:
    """Return the middles of the cells along an axis, metres."""
    edges = field.edges()[axis]
    return np.asarray((edges[1:] + edges[:-1]) / 2)


def no_way(lanes: Lanes, body: Body) -> Way:
    """Return what ends the straight lane that gets farthest."""
    best = int(lanes.last.argmax())
    count = len(lanes.poses.x) // len(lanes.end)
    place = best * count + int(lanes.last[best])
    # Where the robot's origin was put down there; the centre of mass is beside it.
    c, s, (along, across, _) = np.cos(lanes.poses.yaw[place]), np.sin(lanes.poses.yaw[place]), body.centre
    at = lanes.poses.x[place] - c * along + s * across, lanes.poses.y[place] - s * along - c * across
    return Way(
        crosses=False,
        length=None,
        length_ratio=None,
        tilt=None,
        points=np.empty((0, 2)),
        reason=End(int(lanes.end[best])).words,
        at=(float(at[0]), float(at[1])),
    )


def entry(field: StepField, body: Body, axis: int) -> float:
    """Return how far before a field, along an axis, the origin of a robot is that is wholly outside it, metres."""
    return field.extent[axis] / 2 + max(float(body.high[0]), 0.0) + step_of(body)


def straight(field: StepField, body: Body, axis: int, across: Array | None = None) -> Lanes:
    """Return the straight lanes across a field along an axis, 0 for x and 1 for y, at places across, in metres.

    They are where the robot is wholly outside at first and at last; by default through the middle of every line of
    cells.
    """
    middles = _middles(field, 1 - axis) if across is None else across
    before = entry(field, body, axis)
    length = before + field.extent[axis] / 2 - min(float(body.low[0]), 0.0) + step_of(body)
    along = np.full(len(middles), -before)
    x, y = (along, middles) if axis == 0 else (middles, along)
    return drive(Ground.of(field, reach_of(body)), body, x, y, np.full(len(middles), axis * np.pi / 2), length)
