"""The state lattice of a robot on a field: where it gets, and how it best gets across.

Moves between the centres of neighbouring cells, in eight headings, are lanes (lanes.py), but along frames there are
none; turns on the spot are poses between two headings. What is passed is a graph over (x, y, heading), a state lattice
(Pivtoraiko, Knepper and Kelly 2009), on which places are reached (strongly connected components) and ways are found
(Dijkstra 1959): the shortest, or the shortest of those whose largest tilt is least, or whose least margin, the angle by
which the robot must be turned to tip over, is largest.

    o   o   @---o-->     o  middle of a cell, in each of eight headings
          /              -  move: a lane to the next middle in its heading, which the robot drives to its end
    o---@   o   x        @  turn by 45 degrees: the robot stands before, half-way and after it
                         x  no move leads here: it would tip over, hit a block or be stuck
    o   o   o   o

The largest region needs all turns, but few moves: with the moves that are known to be driven, and with all that may
be, the strongly connected components are bounds, and a move between two components of the first in one of the second is
driven only where that one is as large as the largest known. First those are that connect each component with one
before it, as a tree. So edges are looked at as lazily as in lazy searches (Bohlin and Kavraki 2000). A way across needs
far fewer: the robot is trusted with all moves, what is not known of the best way is found, and so on (`_cheapest`).

Cost: some 12 poses a move, or as many as steps of the robot. For the region half of the moves where the robot gets
nearly everywhere, but nearly all where it gets nowhere: a second to ten on 10 x 10 to 40 x 40 blocks; for a way one to
three seconds, or as long as for the region where there is none. What breaks it: what breaks lanes; and each move begins
at the robot's full speed, which a straight lane does not give.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from rsegen.field.graphs import strongly_connected
from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.watch import report_share
from rsegen.standing.body import Body
from rsegen.standing.lanes import (
    BESIDE,
    FALL_ROOM,
    Lanes,
    across,
    drive_lanes,
    entry_distance,
    lines_along,
    step_of,
    steps_on,
    straight,
)
from rsegen.standing.pose_statistics import PoseStatistics, statistics_of
from rsegen.standing.resting import has_stood, margins, of_settled
from rsegen.standing.searching import cheapest
from rsegen.standing.settling import PaddedGround, Settled, joined, outer_radius, settle, settled_on_level
from rsegen.standing.ways import DrivenWay, Way, no_way, straight_way, worst_of


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Reach:
    """The places of a field that a robot can reach, its poses there, and its ways across.

    coverage: share of the blocks in `region`; region: (n_x, n_y), the largest set of blocks on which it gets from every
    place and heading to every other; poses: at all blocks
    """

    coverage: float
    poses: PoseStatistics
    west_east: Way
    south_north: Way
    region: Mask

    def __post_init__(self) -> None:
        self.region.setflags(write=False)


HEADINGS = 8

_MOVES = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
"""Cells by which a move in each heading goes on along x and y; heading k is k times 45 degrees."""

BEST = ("safe", "length", "tilt", "margin")
"""Criteria of the best way: short and safe, the shortest, the least tilt, or the largest margin."""

_RISK = 3.0
"""Weight of risk in a safe way: a metre at half of the tilt at which the robot tips over counts as 2.5 metres on level
ground, and one on which it falls as four."""

_Place = tuple[int, int, int]
"""Cells along x and y, and the heading."""

_AROUND = 2
"""Cells around a way at which poses are found with those on it."""

_FEW_STEPS = 30
"""Steps of a move by a block up to which its middle is not looked at before all of it: the robot is no small one."""

_LANES = 2000
"""Lanes whose poses are found together: some ten thousand poses."""

_TURNS_AT_ONCE, _MOVES_AT_ONCE, _LEAST_MOVES = 8192, 2048, 128
"""Places whose turns, and moves that, are found together in the search for a region: a second of work; and moves at
least, as fewer cost as much."""

_TURNING = 0.2
"""Share of the search for a region that turns take; the others are moves."""

_CHECKED = 64
"""Ways whose straight pieces are driven as a whole, before there is said to be none."""


Watch = Callable[[float], object]
"""Called now and then with the share of a search that is done; what it raises ends the search."""


def _unwatched(_: float) -> None:
    """Take what nobody watches."""


class Lattice:
    """The moves of a robot between the centres of a field's cells in eight headings, and those that it can make.

    What it can do at a place and heading is found once it is asked for: no robot that a wall stops is tried behind it.

    best: which ways are the best, one of BEST; the worst on a move is small where that is good: the largest tilt in
    radians, the least margin with a minus, or for safe ones the tilt as a share of that at which it tips over on
    level ground, 1 for a fall
    moves, turns: (n_x, n_y, 8) whether it can drive on to the next cell, and turn to the next heading and back
    worst_of_moves, worst_of_turns: the worst on each; False and 0 where not yet found
    watch: called after each step of what takes long
    """

    def __init__(self, field: StepField, body: Body, best: str = "length", watch: Watch = _unwatched) -> None:
        self.field, self.body, self.best, self.watch = field, body, best, watch
        self._share = 0.0
        self.ground = PaddedGround.of(field, outer_radius(body))
        self.x, self.y = field.middles()
        shape = (*field.shape, HEADINGS)
        self.moves, self.turns, self._stands = (np.zeros(shape, bool) for _ in range(3))
        self._is_driven, self._is_turned, self._is_settled = (np.zeros(shape, bool) for _ in range(3))
        self.worst_of_moves, self.worst_of_turns = np.zeros(shape), np.zeros(shape)
        self._worst_of_places = np.full(shape, -np.inf if best == "margin" else 0.0)  # no pose is better
        # The tilt at which it tips over on level ground, in which the risk of a safe way is counted.
        self._tips_at = _margin_on_level(self.ground, body) if best == "safe" else np.inf
        self._turn_length = body.width / 2 * np.pi / 4
        self._closed: list[tuple[float, float, int]] = []
        self._lanes_at_ends: dict[int, tuple[Array, Array, Array, Mask, Array]] = {}
        # Metres that are driven from x, y in a heading so far aside, and whether the robot falls there.
        self._driven_on: dict[tuple[float, float, float, float], tuple[float, bool]] = {}
        nowhere = np.empty(0)
        self._rest, self._number_of_rest = settle(self.ground, body, nowhere, nowhere, nowhere), np.full(shape, -1)

    def _tell(self, share: float) -> None:
        """Tell who watches how far the search is, never less than before: a way may be searched after a region."""
        self._share = max(self._share, share)
        self.watch(self._share)

    def close(self, x: float, y: float, heading: int) -> None:
        """Let no way lead past a place, metres, in a heading from now on: a robot got stuck there, whatever poses say.

        Moves are closed whose middle is less than a block away; of lanes at both ends those on its line.
        """
        self._closed.append((x, y, heading))
        ahead, reach = _MOVES[heading] * self.field.block_width / 2, self.field.block_width
        near = np.hypot(self.x[:, None] + ahead[0] - x, self.y[None, :] + ahead[1] - y) < reach
        self._is_driven[near, heading], self.moves[near, heading] = True, False

    def _is_closed(self, x: float, y: float, heading: int, length: float) -> bool:
        """Return whether a lane from a place leads past one that is closed."""
        for at_x, at_y, at_heading in self._closed:
            c, s = np.cos(heading * np.pi / 4), np.sin(heading * np.pi / 4)
            along, aside = c * (at_x - x) + s * (at_y - y), c * (at_y - y) - s * (at_x - x)
            if heading == at_heading and 0 <= along <= length and abs(aside) < self.field.block_width / 2:
                return True
        return False

    def _settle_at(self, places: Ints) -> None:
        """Find whether the robot stands at places, numbers in `moves`, and how bad that is."""
        places = np.unique(places[~self._is_settled.ravel()[places]])
        if not len(places):
            return
        self._is_settled.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.moves.shape)
        rest = settle(self.ground, self.body, self.x[i], self.y[j], k * np.pi / 4)
        self._stands.ravel()[places], self._worst_of_places.ravel()[places] = has_stood(rest), self._worst_value(rest)
        self._number_of_rest.ravel()[places] = len(self._rest.x) + np.arange(len(places))
        self._rest = joined([self._rest, rest])

    def _moves_from(self, places: Ints) -> tuple[Ints, Ints]:
        """Return those of places from which a move leads on, and the places to which it leads."""
        i, j, k = np.unravel_index(places, self.moves.shape)
        on_i, on_j = i + _MOVES[k, 0], j + _MOVES[k, 1]
        inside = (on_i >= 0) & (on_i < self.moves.shape[0]) & (on_j >= 0) & (on_j < self.moves.shape[1])
        places, i, j, k, on_i, on_j = (values[inside] for values in (places, i, j, k, on_i, on_j))
        # No move leads along a frame, aslant within a double one neither.
        rows, columns = (lines_along(self.field, axis) for axis in (0, 1))
        free = ((i == on_i) | rows[j] | rows[on_j]) & ((j == on_j) | columns[i] | columns[on_i])
        return places[free], np.ravel_multi_index((on_i[free], on_j[free], k[free]), self.moves.shape)

    @cached_property
    def _all_moves(self) -> tuple[Ints, Ints]:
        """The places from which moves lead on, and those to which they lead."""
        return self._moves_from(np.arange(self.moves.size))

    def _drive_from(self, places: Ints) -> None:
        """Find the moves from places."""
        places = places[~self._is_driven.ravel()[places]]
        self._is_driven.ravel()[places] = True
        places, ahead = self._moves_from(places)
        i, j, k = np.unravel_index(places, self.moves.shape)
        # Most moves of a robot that is smaller than the blocks end where it tips over: three poses rule them out.
        self._settle_at(np.concatenate([places, ahead]))
        left = np.flatnonzero(self._stands.ravel()[places] & self._stands.ravel()[ahead])
        if steps_on(self.body, self.field.block_width) > _FEW_STEPS:
            middle = self.field.block_width / 2 * _MOVES[k[left]].T
            x, y = self.x[i[left]] + middle[0], self.y[j[left]] + middle[1]
            left = left[has_stood(settle(self.ground, self.body, x, y, k[left] * np.pi / 4))]
        if len(left):
            length = self.field.block_width * np.where(k[left] % 2 == 1, 2**0.5, 1.0)
            starts = self.x[i[left]], self.y[j[left]], k[left] * np.pi / 4
            passed, worst = self._driven(*starts, length, (places[left], ahead[left]))
            self.moves.ravel()[places[left]], self.worst_of_moves.ravel()[places[left]] = passed, worst

    def _turn_at(self, places: Ints) -> None:
        """Find whether the robot can turn from places to their next headings, and back: at both, and half-way."""
        places = places[~self._is_turned.ravel()[places]]
        self._is_turned.ravel()[places] = True
        i, j, k = np.unravel_index(places, self.turns.shape)
        after = np.ravel_multi_index((i, j, (k + 1) % HEADINGS), self.moves.shape)
        self._settle_at(np.concatenate([places, after]))
        able = self._stands.ravel()[places] & self._stands.ravel()[after]
        places, after = places[able], after[able]
        i, j, k = np.unravel_index(places, self.turns.shape)
        rest = settle(self.ground, self.body, self.x[i], self.y[j], (k + 0.5) * np.pi / 4)
        self.turns.ravel()[places] = has_stood(rest)
        ends = self._worst_of_places.ravel()
        self.worst_of_turns.ravel()[places] = np.maximum.reduce([ends[places], ends[after], self._worst_value(rest)])

    def _driven(
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
            count = len(lanes.poses.x) // len(lanes.end)
            values = self._worst_value(lanes.poses.some(np.flatnonzero(np.repeat(lanes.passed, count))))
            worst.append(np.zeros(len(lanes.end)))
            worst[-1][lanes.passed] = values.reshape(-1, count).max(axis=1)
            if self.best == "safe":
                worst[-1] = np.where(lanes.drops.any(axis=1), 1.0, worst[-1])
        return np.concatenate(passed), np.concatenate(worst)

    def _worst_value(self, rest: Settled) -> Array:
        """Return the tilt of each robot, radians, its margin with a minus, or its share of the tilt to tip over."""
        if self.best == "margin":
            return -margins(self.ground, self.body, rest)
        return rest.tilt / self._tips_at if self.best == "safe" else rest.tilt

    def region(self) -> Mask:
        """Return the largest set of blocks on which the robot gets from every place and heading to every other.

        Of several that are as large it is that with the first place. A move is driven only if it may change the set.
        """
        self._turn_everywhere()
        tails, heads = self._all_moves
        able = self._stands.ravel()[tails] & self._stands.ravel()[heads]
        tails, heads = tails[able], heads[able]
        while True:
            may = self.moves.ravel()[tails] | ~self._is_driven.ravel()[tails]
            tails, heads = tails[may], heads[may]
            passed = self._is_driven.ravel()[tails]
            known, possible = self._components(tails[passed], heads[passed]), self._components(tails, heads)
            region = self._largest(known)
            # A move within a part changes nothing, nor does one between parts that will never be one, or be one that is
            # smaller than another.
            matters = (known[tails] != known[heads]) & (possible[tails] == possible[heads])
            matters &= self._sizes(possible)[tails] >= region.sum()
            is_open = matters & ~passed
            if not is_open.any():
                self._tell(1.0)
                return region
            self._tell(_TURNING + (1 - _TURNING) * (1 - float(is_open.sum()) / self.moves.size))
            from_, to = known[tails[matters]], known[heads[matters]]
            chosen = np.flatnonzero(matters)[_connecting(from_, to, tails[matters] % 2, ~passed[matters])]
            self._drive_from(tails[chosen[:_MOVES_AT_ONCE]])

    def _components(self, tails: Ints, heads: Ints) -> Ints:
        """Return for each place the number of its strongly connected component, by all turns and some moves."""
        places, turns = np.arange(self.moves.size).reshape(self.moves.shape), self.turns.ravel()
        low, high = np.append(places.ravel(), tails), np.append(np.roll(places, -1, axis=2).ravel(), heads)
        is_turn = np.arange(len(low)) < places.size
        onward = np.append(turns, np.ones(len(tails), bool))
        group = strongly_connected(places.size, low, high, onward, onward & is_turn)
        # By their first places.
        _, first, number = np.unique(group, return_index=True, return_inverse=True)
        return np.asarray(first[number])

    def _cells(self, group: Ints) -> Ints:
        """Return the components of places and the blocks over which they are in any heading, (n, 2)."""
        cells = np.unique(np.stack([group, np.arange(group.size) // HEADINGS], axis=1), axis=0)
        return np.asarray(cells[~self.field.frame.ravel()[cells[:, 1]]])

    def _sizes(self, group: Ints) -> Ints:
        """Return for each place the number of blocks of its component."""
        return np.asarray(np.bincount(self._cells(group)[:, 0], minlength=group.size)[group])

    def _largest(self, group: Ints) -> Mask:
        """Return the blocks of the component with the most, (n_x, n_y)."""
        cells, region = self._cells(group), np.zeros(self.field.levels.size, bool)
        if len(cells):
            region[cells[cells[:, 0] == np.bincount(cells[:, 0]).argmax(), 1]] = True
        return region.reshape(self.field.shape)

    def at_blocks(self) -> Settled:
        """Return the robot at rest in every heading at every block, by the blocks; known once its region is."""
        return self._rest.some(self._number_of_rest[~self.field.frame].ravel())

    def straight_lines(self, axis: int) -> Array:
        """Return the middles of the lines along an axis, metres, on which nothing is known to end a straight way."""
        fails, ends = (self._is_settled & ~self._stands)[..., 2 * axis], (self._is_driven & ~self.moves)[..., 2 * axis]
        onward = np.arange(self.field.shape[axis] - 1)  # from the last cell no move leads on
        ended = fails.any(axis=axis) | ends.take(onward, axis=axis).any(axis=axis)
        return self.field.middles()[1 - axis][lines_along(self.field, axis) & ~ended]

    def _turn_everywhere(self) -> None:
        """Find all turns."""
        places = np.arange(self.turns.size)
        for begin in range(0, places.size, _TURNS_AT_ONCE):
            self._turn_at(places[begin : begin + _TURNS_AT_ONCE])
            self._tell(_TURNING * float(self._is_turned.mean()))

    def way(self, axis: int, *, checked: bool = True) -> Way | None:
        """Return the best way across along an axis, with straight lanes at both ends; None if there is none.

        checked: whether its straight pieces are driven as a whole too, and the lanes next to them
        """
        starts, goals = self._ends(axis)
        left = self.field.block_width * (self.field.shape[axis] - 1 - np.indices(self.field.shape)[axis])
        for _ in range(_CHECKED):
            best = self._best(starts, goals, left)
            if best is None:
                return None
            places = best[1]
            driven = self._driven_pieces(*self._line(axis, places), checked=checked)
            if isinstance(driven, Lanes):
                return self._way_of(axis, places, driven)
            # The next way is another one: a planner that checks lazily bars edges (Bohlin and Kavraki 2000).
            for ending in driven:
                if ending == 0:
                    del starts[places[0]]
                elif ending == len(places):
                    del goals[places[-1]]
                else:
                    self.moves[places[ending - 1]] = False
        return None

    def _driven_pieces(self, line: Array, heading: Ints, *, checked: bool) -> Lanes | list[int]:
        """Return the lanes of the straight pieces of a way, or on which lanes from place to place it ends.

        0 is the lane that leads to its first place, m that from place m - 1 on. First all pieces are driven: the next
        way mostly has those behind an ending too. Then again as each pose follows from the one before, on which few end
        that were driven before.
        checked: whether it may end at all
        """
        pieces = _straight_pieces(line, heading)
        begins, ends = pieces.T
        (x, y), yaw = line[begins].T, heading[begins] * np.pi / 4
        length = np.hypot(*(line[ends] - line[begins]).T)
        shares = self._surely_driven(line[begins], yaw, length) if checked else np.ones(len(pieces))
        if (shares == 1).all():
            lanes = drive_lanes(self.ground, self.body, x, y, yaw, length, follows=True)
            if lanes.passed.all() or not checked:
                return lanes
            shares = np.where(lanes.passed, 1.0, lanes.last / lanes.count)
        return [_number_at(line, pieces[k], float(shares[k])) for k in np.flatnonzero(shares < 1)]

    def _surely_driven(self, begins: Array, yaw: Array, length: Array) -> Array:
        """Return the shares of straight pieces that are driven, and of lanes next to them; more aside where it drops.

        Where a piece itself ends, nothing next to pieces is driven. Ways that are tried one after the other are mostly
        the same: what is known to be driven is not driven again.
        begins: (n, 2)
        """
        shares, drops = np.ones(len(length)), np.zeros(len(length), bool)
        for aside in ((0.0,), (-BESIDE, BESIDE), (-FALL_ROOM, FALL_ROOM)):
            places = [(x, y, turn, aside[0]) for x, y, turn in np.column_stack([begins, yaw]).tolist()]
            known = np.array([self._driven_on.get(place, (0.0, False)) for place in places])
            asked = np.flatnonzero((length > known[:, 0]) & (drops | (aside[-1] < FALL_ROOM)))
            x, y = (
                (begins[asked, axis, None] + side[asked, None] * aside).ravel()
                for axis, side in enumerate((-np.sin(yaw), np.cos(yaw)))
            )
            turned, long = (np.repeat(values[asked], len(aside)) for values in (yaw, length))
            lanes = drive_lanes(self.ground, self.body, x, y, turned, long)
            driven = np.where(lanes.passed, 1.0, lanes.last / lanes.count).reshape(-1, len(aside)).min(axis=1)
            falls = np.asarray(lanes.drops.any(axis=1).reshape(-1, len(aside)).any(axis=1))
            for number, share, fall in zip(asked.tolist(), driven.tolist(), falls.tolist(), strict=True):
                self._driven_on[places[number]] = share * length[number], fall
            shares[asked], drops[asked] = driven, falls
            drops |= known[:, 1] > 0
            if (shares < 1).any():
                break
        return shares

    def _line(self, axis: int, places: Sequence[_Place]) -> tuple[Array, Ints]:
        """Return the line of a way, its places and both its ends (n + 2, 2), and the heading of each lane, (n + 1,)."""
        i, j, k = np.array(places).T
        points = np.stack([self.x[i], self.y[j]], axis=1)
        ends = points[[0, -1]].copy()
        ends[:, axis] = (
            -entry_distance(self.field, self.body, axis),
            self.field.extent[axis] / 2 - float(self.body.low[0]),
        )
        return np.concatenate([ends[:1], points, ends[1:]]), np.append(k[0], k)

    def between(self, start: tuple[float, float], goal: tuple[float, float]) -> DrivenWay | None:
        """Return the best way between two places, x and y in metres, at any heading; None if there is none.

        They are the centres of the cells in which these places are, or of the nearest ones.
        """
        cells = [
            (int(np.abs(self.x - along_x).argmin()), int(np.abs(self.y - along_y).argmin()))
            for along_x, along_y in (start, goal)
        ]
        starts, goals = (self._standing_at(*cell) for cell in cells)
        if not starts or not goals:
            return None
        best = self._best(starts, goals, self._distance_to(cells[1]))
        return self._driven_way(self._length(best[1]), best[1]) if best else None

    def _standing_at(self, i: int, j: int) -> dict[_Place, float]:
        """Return the places of a cell at which the robot stands, with how bad its pose is there."""
        yaw = np.arange(HEADINGS) * np.pi / 4
        rest = settle(self.ground, self.body, np.full(HEADINGS, self.x[i]), np.full(HEADINGS, self.y[j]), yaw)
        worst = self._worst_value(rest)
        return {(i, j, k): float(worst[k]) for k in np.flatnonzero(has_stood(rest)).tolist()}

    def _distance_to(self, goal: tuple[int, int]) -> Array:
        """Return the distance of all cells from one, metres, which no way to it is shorter than."""
        i, j = np.indices(self.field.shape)
        return np.asarray(self.field.block_width * np.hypot(i - goal[0], j - goal[1]))

    def _best(
        self, starts: Mapping[_Place, float], goals: Mapping[_Place, float], left: Array
    ) -> tuple[float, list[_Place]] | None:
        """Return the cost of the best way from a start to a goal, and its places; None if there is none.

        left: (n_x, n_y), a length from a cell that no way to a goal is shorter than
        """
        if self.best == "safe":
            start = dict.fromkeys(starts, 0.0)

            def risked(cost: float, length: float, worst: float) -> float:
                return cost + length * (1 + _RISK * worst)

            return self._cheapest(start, goals, risked, left)
        limit = np.inf
        if self.best != "length":
            least = self._cheapest(starts, goals, lambda cost, _, worst: max(cost, worst), np.zeros(self.field.shape))
            if least is None:
                return None
            limit = least[0] + 1e-9

        def longer(cost: float, length: float, worst: float) -> float:
            return cost + length if worst <= limit else np.inf

        allowed = {place: 0.0 for place, worst in starts.items() if worst <= limit}
        return self._cheapest(allowed, goals, longer, left)

    def _cheapest(
        self,
        starts: Mapping[_Place, float],
        goals: Mapping[_Place, float],
        cost_of: Callable[..., float],
        left: Array,
    ) -> tuple[float, list[_Place]] | None:
        """Return the least cost from a start to a goal, which have costs too, and the places between.

        The robot is trusted with all that is not known to fail, and nothing is taken to be worse than the poses at its
        ends. What is not known of the best way then is found, until nothing is: no other way is better than that one
        (LazySP, Dellin and Srinivasa 2016). On rough ground that takes two to twenty ways.
        cost_of: the cost after a move, from that before, the length and the worst of it; it never falls
        left: (n_x, n_y), a cost from a cell that no way to a goal is below; it falls by no more than a move costs
        """
        of_place = np.repeat(left.ravel(), HEADINGS).tolist()
        begins, ends = (
            {int(np.ravel_multi_index(place, self.moves.shape)): value for place, value in values.items()}
            for values in (starts, goals)
        )
        while True:
            found = cheapest(begins, ends, self._hopes(), cost_of, of_place)
            if found is None:
                return None
            cost, way = found
            if self._knows(np.array(way)):
                return cost, [self._place(at) for at in way]

    def _place(self, number: int) -> _Place:
        """Return the place of a number in `moves`."""
        cell, k = divmod(number, HEADINGS)
        return (*divmod(cell, self.field.shape[1]), k)

    def _hopes(self) -> Callable[[int], Iterator[tuple[int, float, float]]]:
        """Return what yields the places to which a robot may go on from a place, numbers in `moves`.

        With the length of each move, and the worst on it, or less; a turn moves its sides.
        """
        tails, heads = self._all_moves
        fails = (self._is_settled & ~self._stands).ravel()
        least = np.where(fails, np.inf, self._worst_of_places.ravel())
        leads_to, hoped = np.full(self.moves.size, -1), np.full(self.moves.size, np.inf)
        leads_to[tails], hoped[tails] = heads, np.maximum(least[tails], least[heads])
        known = np.where(self.moves, self.worst_of_moves, np.inf).ravel()
        moves = np.where(self._is_driven.ravel(), known, hoped).tolist()
        least = least.reshape(self.turns.shape)
        known, hoped = np.where(self.turns, self.worst_of_turns, np.inf), np.maximum(least, np.roll(least, -1, axis=2))
        turns, ahead = np.where(self._is_turned, known, hoped).ravel().tolist(), leads_to.tolist()
        lengths = (self.field.block_width, self.field.block_width * 2**0.5) * (HEADINGS // 2)

        def onward(at: int) -> Iterator[tuple[int, float, float]]:
            k = at % HEADINGS
            to_left, to_right = at + 1 - HEADINGS * (k == HEADINGS - 1), at - 1 + HEADINGS * (k == 0)
            if moves[at] < np.inf:
                yield ahead[at], lengths[k], moves[at]
            if turns[at] < np.inf:
                yield to_left, self._turn_length, turns[at]
            if turns[to_right] < np.inf:
                yield to_right, self._turn_length, turns[to_right]

        return onward

    def _knows(self, places: Ints) -> bool:
        """Return whether all along a way, numbers in `moves`, is known; find what is not, first how the robot stands.

        Poses at the places around are found with them: the next ways mostly lead there, and a call for few is as dear.
        """
        i, j, k = np.unravel_index(places, self.moves.shape)
        if not self._is_settled.ravel()[places].all():
            aside = np.arange(-_AROUND, _AROUND + 1)
            x, y = np.broadcast_arrays(i[:, None, None] + aside[:, None], j[:, None, None] + aside)
            inside = (x >= 0) & (x < self.field.shape[0]) & (y >= 0) & (y < self.field.shape[1])
            cells = x[inside] * self.field.shape[1] + y[inside]
            self._settle_at((cells[:, None] * HEADINGS + np.arange(HEADINGS)).ravel())
            return False
        turned = np.diff(k) % HEADINGS
        moves, turns = places[:-1][turned == 0], np.where(turned == 1, places[:-1], places[1:])[turned > 0]
        moves, turns = moves[~self._is_driven.ravel()[moves]], turns[~self._is_turned.ravel()[turns]]
        self._drive_from(moves)
        self._turn_at(turns)
        self._tell(float(self._is_driven.mean()))
        return not len(moves) and not len(turns)

    def _ends(self, axis: int) -> tuple[dict[_Place, float], dict[_Place, float]]:
        """Return the places where the robot comes in, and those where it gets out, with the worst on the lane there."""
        if axis not in self._lanes_at_ends:
            self._lanes_at_ends[axis] = self._drive_ends(axis)
        x, y, length, passed, worst = self._lanes_at_ends[axis]
        numbers, last = np.flatnonzero(lines_along(self.field, axis)), self.field.shape[axis] - 1
        ends: list[dict[_Place, float]] = [{}, {}]
        for number in np.flatnonzero(passed).tolist():
            if not self._is_closed(float(x[number]), float(y[number]), 2 * axis, float(length[number])):
                side, line = number // len(numbers), int(numbers[number % len(numbers)])
                cell = (0, last)[side]
                ends[side][(cell, line, 0) if axis == 0 else (line, cell, 2)] = float(worst[number])
        return ends[0], ends[1]

    def _drive_ends(self, axis: int) -> tuple[Array, Array, Array, Mask, Array]:
        """Return x and y where lanes in begin, then those out, their lengths, whether they are driven, the worst."""
        middles = across(self.field, axis)
        first, edge = self.field.middles()[axis][0], entry_distance(self.field, self.body, axis)
        outward = self.field.extent[axis] / 2 - min(float(self.body.low[0]), 0.0) + step_of(self.body) + first
        along = np.repeat([-edge, -first], len(middles))
        length, aside = np.repeat([edge + first, outward], len(middles)), np.tile(middles, 2)
        x, y = (along, aside) if axis == 0 else (aside, along)
        return x, y, length, *self._driven(x, y, np.full(len(x), axis * np.pi / 2), length)

    def _way_of(self, axis: int, places: list[_Place], lanes: Lanes) -> Way:
        """Return the way over places: what its poses are, on its lanes at both ends too, and where it turns."""
        k = np.array(places)[:, 2]
        line, _ = self._line(axis, places)
        points, ends = line[1:-1], line[[0, -1]]
        length = self._length(places) + float(np.abs(ends[:, axis] - points[[0, -1], axis]).sum())
        turning = np.linspace(k[:-1], k[:-1] + (np.diff(k) + 4) % HEADINGS - 4, 3) * np.pi / 4
        x, y = np.tile(points[:-1], (3, 1)).T
        turned = settle(self.ground, self.body, x, y, turning.ravel())
        kept = np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))
        return Way(
            crosses=True,
            length=length,
            length_ratio=length / float(ends[1, axis] - ends[0, axis]),
            points=np.concatenate([ends[:1], points[kept], ends[1:]]),
            **worst_of(self.ground, self.body, lanes, turned),
        )

    def _length(self, places: list[_Place]) -> float:
        """Return the length of a way over places, metres; a turn by 45 degrees is as long as the path of its sides."""
        turned = np.diff(np.array(places), axis=0)
        moves = float(np.hypot(*turned[:, :2].T).sum()) * self.field.block_width
        return moves + np.count_nonzero(turned[:, 2]) * self._turn_length

    def _driven_way(self, length: float, places: list[_Place]) -> DrivenWay:
        """Return the way over places, pose by pose."""
        pieces = list(self._pieces(np.array(places)))
        poses = [
            of_settled(self.ground, self.body, piece.poses if isinstance(piece, Lanes) else piece) for piece in pieces
        ]
        begins = np.cumsum([0, *(len(piece.x) for piece in poses)])[:-1]
        drops, slips = (
            tuple(
                int(begin) + at
                for begin, piece in zip(begins, pieces, strict=True)
                if isinstance(piece, Lanes)
                for at in _run_starts(getattr(piece, name)[0])
            )
            for name in ("drops", "slips")
        )
        return DrivenWay(length=length, poses=joined(poses), drops=drops, slips=slips)

    def _pieces(self, places: Ints) -> Iterator[Lanes | Settled]:
        """Yield the lanes and the turns of a way over places (n, 3), in their order; a way of one place is a turn."""
        points, yaw = np.stack([self.x[places[:, 0]], self.y[places[:, 1]]], axis=1), places[:, 2] * np.pi / 4
        begin, last = 0, len(places) - 1
        for m in range(len(places)):
            turns_on = m < last and places[m, 2] != places[m + 1, 2]
            if m < last and not turns_on:
                continue
            ahead = points[m] - points[begin]
            if ahead.any():
                x, y = points[begin, :1], points[begin, 1:]
                yield drive_lanes(self.ground, self.body, x, y, yaw[m : m + 1], float(np.hypot(*ahead)), follows=True)
            if turns_on or not last:
                on = (places[min(m + 1, last), 2] - places[m, 2] + 4) % HEADINGS - 4
                headings = yaw[m] + np.linspace(0, 1, _TURN_POSES) * on * np.pi / 4
                x, y = np.tile(points[m], (_TURN_POSES, 1)).T
                yield settle(self.ground, self.body, x, y, headings)
            begin = m + 1


def _straight_pieces(line: Array, heading: Ints) -> Ints:
    """Return from which place of a line to which each straight piece leads, (n, 2), for the headings of its lanes."""
    turns = np.append(np.append(0, np.flatnonzero(np.diff(heading)) + 1), len(heading))
    pieces = np.stack([turns[:-1], turns[1:]], axis=1)
    return np.asarray(pieces[(line[turns[:-1]] != line[turns[1:]]).any(axis=1)])


def _number_at(line: Array, piece: Ints, share: float) -> int:
    """Return the number of the lane at a share of the length of a straight piece, from and to places of a line."""
    first, last = piece
    run = np.hypot(*np.diff(line[first : last + 1], axis=0).T).cumsum()
    return int(first + np.searchsorted(run[:-1], share * run[-1], side="right"))


def _margin_on_level(ground: PaddedGround, body: Body) -> float:
    """Return the tilt at which a robot tips over on level ground, radians."""
    level, rest = settled_on_level(ground, body)
    return float(margins(level, body, rest)[0])


def _run_starts(which: Mask) -> list[int]:
    """Return the numbers of the first of each stretch of a mask."""
    return [int(at) for at in np.flatnonzero(which & ~np.append(False, which[:-1]))]


_TURN_POSES = 7
"""Poses of a turn by 45 degrees that are shown."""


def _connecting(tails: Ints, heads: Ints, is_diagonal: Ints, is_open: Mask) -> Ints:
    """Return the numbers of some of the open moves between parts: few, which are likely to make one part of many.

    tails, heads: the parts that each move leads from and to, of open ones and of those that are known to be passed.
    From each part one move leads to a part before it, by number, and one back, if there may be both; straight moves are
    chosen first, as they are shorter.
    """
    low, high, onward = np.minimum(tails, heads), np.maximum(tails, heads), tails < heads
    _, pair = np.unique(np.stack([high, low], axis=1), axis=0, return_inverse=True)
    pair = pair.ravel()
    leads, back = (np.bincount(pair[side], minlength=len(pair)) > 0 for side in (onward, ~onward))
    number = np.flatnonzero(is_open)
    number = number[np.lexsort((low[number], is_diagonal[number], ~(leads & back)[pair[number]], high[number]))]
    _, first, part = np.unique(high[number], return_index=True, return_inverse=True)
    best = np.flatnonzero(pair[number] == pair[number][first][part])
    _, once = np.unique(2 * part[best] + onward[number][best], return_index=True)
    # Enough of them to be worth the cost of a call.
    order = np.concatenate([best[once], np.delete(np.arange(len(number)), best[once])])
    return np.asarray(number[order[: max(len(once), _LEAST_MOVES)]])


def reach(field: StepField, body: Body, watch: Watch = _unwatched) -> Reach:
    """Return where a robot gets on a field, and its shortest ways across."""
    lattice = Lattice(field, body, watch=watch)
    region, blocks, ways = lattice.region(), int((~field.frame).sum()), []
    for axis in (0, 1):
        watch(1.0)  # the lanes below are a tenth of the work
        direct = straight_way(field, body, axis, lattice.straight_lines(axis))
        ways.append(direct or lattice.way(axis) or no_way(straight(field, body, axis), body))
    cover = float(region.sum() / blocks) if blocks else 0.0
    poses = statistics_of(lattice.ground, body, lattice.at_blocks())
    return Reach(coverage=cover, poses=poses, west_east=ways[0], south_north=ways[1], region=region)


def best_way(field: StepField, body: Body, axis: int, best: str = "length") -> Way:
    """Return the best way across a field along an axis, 0 for x and 1 for y; best: one of BEST.

    The shortest is a straight one if there is one, of these the one with the least tilt; all others are on the lattice.
    """
    direct = straight_way(field, body, axis)
    if direct and best == "length":
        return direct
    way = Lattice(field, body, best, partial(report_share, "a way across")).way(axis)
    report_share("a way across", 1)
    return way or direct or no_way(straight(field, body, axis), body)
