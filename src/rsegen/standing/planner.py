"""Plans of ways over the lattice of a robot on a field: the best across, and the best between two places.

    o---o---o                 the best way over moves that are driven one by one (lattice.py)
            |
    ========+                 its straight pieces, driven as a whole: a robot that spends its momentum stops
    - - - - -  3 mm           the lanes next to them; where it falls, 2 cm aside
            o   o---o         where one ends, that move is barred, and the next best way is planned

What drives have shown (evidence.py) weighs on the ways that are planned after them.

Cost: a second for each twenty ways that are planned anew; on rough ground that takes one to twenty. What breaks it:
what breaks lanes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.params.watch import report_share
from rsegen.standing.body import Body
from rsegen.standing.evidence import IN, MOVE, OUT, Evidence
from rsegen.standing.lanes import (
    BESIDE,
    FALL_ROOM,
    Lanes,
    across,
    drive_lanes,
    entry_distance,
    lines_along,
    step_of,
    straight,
)
from rsegen.standing.lattice import HEADINGS, MOVES, Lane, Lattice, Place
from rsegen.standing.resting import of_settled
from rsegen.standing.settling import Settled, joined, settle
from rsegen.standing.ways import DrivenWay, Way, ends_across, no_way, straight_way, worst_of

_CHECKED = 64
"""Ways whose straight pieces are driven as a whole at most, before the search ends without a way."""

_HELD_TOO = {-1: 0.5, 0: 1.0, 1: 0.5}
"""Share in which a place holds a robot that comes to it turned by -1, 0 or 1 headings."""

_TURN_POSES = 7
"""Poses of a turn by 45 degrees that are shown."""


class Planner:
    """A planner of ways over a lattice; it bars the moves of the lattice at which a way turns out to end."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice, self.field, self.body, self.ground = lattice, lattice.field, lattice.body, lattice.ground
        self._lanes_at_ends: dict[int, tuple[Array, Array, Array, Mask, Array]] = {}
        # Metres that are driven from x, y in a heading so far aside, and whether the robot falls there.
        self._driven_on: dict[tuple[float, float, float, float], tuple[float, bool]] = {}

    def way(self, axis: int, *, checked: bool = True) -> Way | None:
        """Return the best way across along an axis, with straight lanes at both ends; None if no way leads across.

        checked: whether its straight pieces are driven as a whole too, and the lanes next to them
        """
        starts, goals = self._ends(axis)
        left = self.field.block_width * (self.field.shape[axis] - 1 - np.indices(self.field.shape)[axis])
        for _ in range(_CHECKED):
            best = self.lattice.best_way(starts, goals, left)
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
                    self.lattice.moves[places[ending - 1]] = False
        return None

    def between(self, start: tuple[float, float], goal: tuple[float, float]) -> DrivenWay | None:
        """Return the best way between two places, x and y in metres, at any heading; None if no way leads there.

        It begins and ends at the centres of the nearest cells.
        """
        cells = [
            (int(np.abs(self.lattice.x - along_x).argmin()), int(np.abs(self.lattice.y - along_y).argmin()))
            for along_x, along_y in (start, goal)
        ]
        starts, goals = (self.lattice.standing_at(*cell) for cell in cells)
        if not starts or not goals:
            return None
        best = self.lattice.best_way(starts, goals, self._distance_to(cells[1]))
        return self._driven_way(self._length(best[1]), best[1]) if best else None

    def learn(self, way: Array, end: tuple[float, float] | None, held: float = 1.0) -> None:
        """Take into account how far a drive along a way got: later ways lead where drives got on, not where they ended.

        Moves whose middle is less than a block from the end count as held too, and moves turned by 45 degrees by half.

        way: (n, 2), its points, each apart from the one before
        end: where the robot was held, metres; None if it crossed
        held: number of drives as which that counts; infinite to close the place
        """
        # `reached` is the piece of the way nearest to the end; all pieces before it were passed.
        evidence = self.lattice.evidence = self.lattice.evidence or Evidence(self.lattice.moves.shape)
        begins, along = way[:-1], np.diff(way, axis=0)
        reached, at = len(along), np.zeros(2)
        if end is not None:
            share = ((end - begins) * along).sum(axis=1) / (along**2).sum(axis=1)
            nearest = begins + np.clip(share, 0, 1)[:, None] * along
            reached = int(np.hypot(*(nearest - end).T).argmin())
            at = nearest[reached]
        middles = self.lattice.x, self.lattice.y
        i, j = (np.abs(middles[axis][:, None] - begins[:, axis]).argmin(axis=0) for axis in (0, 1))
        k = np.rint(np.arctan2(along[:, 1], along[:, 0]) / (np.pi / 4)).astype(int) % HEADINGS
        # The first piece is the lane onto the map, which is kept at the place to which it leads.
        parts = np.full(len(along), MOVE)
        parts[[0, -1]], i[0], j[0] = (IN, OUT), i[1], j[1]
        if np.isfinite(held):
            evidence.passed[parts[:reached], i[:reached], j[:reached], k[:reached]] += 1
        if end is not None:
            self._add_held(evidence.held, at, int(k[reached]), held)

    def _add_held(self, counts: Array, at: Array, heading: int, held: float) -> None:
        """Add drives that were held at a place to the counts of moves past it, and of lanes in and out over it."""
        width = self.field.block_width
        for turned, share in _HELD_TOO.items():
            k = (heading + turned) % HEADINGS
            x, y = self.lattice.x + MOVES[k, 0] * width / 2, self.lattice.y + MOVES[k, 1] * width / 2
            near = np.hypot(x[:, None] - at[0], y - at[1]) < width
            counts[MOVE, near, k] += share * held
        for axis, (*starts, length, _, _) in self._lanes_at_ends.items():
            if heading == 2 * axis:
                parts, i, j = self._places_at_ends(axis)
                along, aside = at[axis] - starts[axis], at[1 - axis] - starts[1 - axis]
                on = (along >= 0) & (along <= length) & (np.abs(aside) < width / 2)
                counts[parts[on], i[on], j[on], heading] += held

    def _driven_pieces(self, line: Array, heading: Ints, *, checked: bool) -> Lanes | list[int]:
        """Return the lanes of the straight pieces of a way, or the numbers of its lanes between places that end it.

        Lane 0 leads to the first place, lane m leads on from place m - 1. All pieces are driven, also behind one that
        ends, as the next way mostly has these too; then again with poses that follow each other, where few more end.
        checked: False to take all pieces as driven
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
            shares = lanes.driven_shares
        return [_number_at(line, pieces[k], float(shares[k])) for k in np.flatnonzero(shares < 1)]

    def _surely_driven(self, begins: Array, yaw: Array, length: Array) -> Array:
        """Return the share of each straight piece that is driven, also a little to either side, (n,).

        Ways that are tried one after the other are mostly the same: what is known to be driven is not driven again.
        begins: (n, 2)
        """
        shares, drops = np.ones(len(length)), np.zeros(len(length), bool)
        # The pieces themselves, then lanes next to them, then farther ones where the robot falls; the first that end
        # settle it.
        for aside in ((0.0,), (-BESIDE, BESIDE), (-FALL_ROOM, FALL_ROOM)):
            places = [(x, y, turn, aside[0]) for x, y, turn in np.column_stack([begins, yaw]).tolist()]
            far, falls = np.array([self._driven_on.get(place, (0.0, False)) for place in places]).T
            asked = np.flatnonzero((length > far) & (drops | (aside[-1] < FALL_ROOM)))
            drops |= falls > 0
            if not len(asked):
                continue
            x, y = (
                (begins[asked, axis, None] + side[asked, None] * aside).ravel()
                for axis, side in enumerate((-np.sin(yaw), np.cos(yaw)))
            )
            turned, long = (np.repeat(values[asked], len(aside)) for values in (yaw, length))
            lanes = drive_lanes(self.ground, self.body, x, y, turned, long)
            shares[asked] = lanes.driven_shares.reshape(-1, len(aside)).min(axis=1)
            drops[asked] |= lanes.drops.any(axis=1).reshape(-1, len(aside)).any(axis=1)
            for piece in asked.tolist():
                self._driven_on[places[piece]] = shares[piece] * length[piece], bool(drops[piece])
            if (shares < 1).any():
                break
        return shares

    def _line(self, axis: int, places: Sequence[Place]) -> tuple[Array, Ints]:
        """Return the points of a way, both ends and its places, (n + 2, 2), and the heading of each lane, (n + 1,)."""
        points, k = self._points(np.array(places)), np.array(places)[:, 2]
        ends = points[[0, -1]].copy()
        ends[:, axis] = ends_across(self.field, self.body, axis)
        return np.concatenate([ends[:1], points, ends[1:]]), np.append(k[0], k)

    def _points(self, places: Ints) -> Array:
        """Return x and y of places (n, 3), metres, (n, 2)."""
        return np.stack([self.lattice.x[places[:, 0]], self.lattice.y[places[:, 1]]], axis=1)

    def _distance_to(self, goal: tuple[int, int]) -> Array:
        """Return the distance of each cell from a goal, metres, (n_x, n_y): a lower bound of the length of a way."""
        i, j = np.indices(self.field.shape)
        return np.asarray(self.field.block_width * np.hypot(i - goal[0], j - goal[1]))

    def _ends(self, axis: int) -> tuple[dict[Place, Lane], dict[Place, Lane]]:
        """Return the places where the robot comes in, and those where it gets out, with the lane there."""
        if axis not in self._lanes_at_ends:
            self._lanes_at_ends[axis] = self._drive_ends(axis)
        _, _, length, passed, worst = self._lanes_at_ends[axis]
        parts, i, j = self._places_at_ends(axis)
        ends: list[dict[Place, Lane]] = []
        for part in (IN, OUT):
            which = np.flatnonzero(passed & (parts == part))
            at = i[which], j[which], np.full(len(which), 2 * axis)
            numbers = np.ravel_multi_index(at, self.lattice.moves.shape)
            counted = self.lattice.counted(part, numbers, length[which], worst[which])
            lanes = zip(*(values.tolist() for values in (*at, counted, worst[which])), strict=True)
            ends.append({(x, y, k): (far, bad) for x, y, k, far, bad in lanes if far < np.inf})
        return ends[0], ends[1]

    def _places_at_ends(self, axis: int) -> tuple[Ints, Ints, Ints]:
        """Return for all lanes at both ends whether they lead in or out, and their cells i and j at the edge."""
        numbers = np.flatnonzero(lines_along(self.field, axis))
        lines, cells = np.tile(numbers, 2), np.repeat([0, self.field.shape[axis] - 1], len(numbers))
        i, j = (cells, lines) if axis == 0 else (lines, cells)
        return np.repeat([IN, OUT], len(numbers)), i, j

    def _drive_ends(self, axis: int) -> tuple[Array, Array, Array, Mask, Array]:
        """Return for lanes in, then lanes out: x and y of the begin, length, whether it is driven, and the worst."""
        middles = across(self.field, axis)
        first, edge = self.field.middles()[axis][0], entry_distance(self.field, self.body, axis)
        outward = self.field.extent[axis] / 2 - min(float(self.body.low[0]), 0.0) + step_of(self.body) + first
        along = np.repeat([-edge, -first], len(middles))
        length, aside = np.repeat([edge + first, outward], len(middles)), np.tile(middles, 2)
        x, y = (along, aside) if axis == 0 else (aside, along)
        return x, y, length, *self.lattice.driven(x, y, np.full(len(x), axis * np.pi / 2), length)

    def _way_of(self, axis: int, places: list[Place], lanes: Lanes) -> Way:
        """Return the way over places, with the worst of its poses, also on its lanes at both ends and in its turns."""
        k = np.array(places)[:, 2]
        line, _ = self._line(axis, places)
        points, ends = line[1:-1], line[[0, -1]]
        length = self._length(places) + float(np.abs(ends[:, axis] - points[[0, -1], axis]).sum())
        # At each turn by -1 or 1 headings (-4..3 after the remainder) the poses at both ends and half-way.
        turning = np.linspace(k[:-1], k[:-1] + (np.diff(k) + 4) % HEADINGS - 4, 3) * np.pi / 4
        x, y = np.tile(points[:-1], (3, 1)).T
        turned = settle(self.ground, self.body, x, y, turning.ravel())
        moved = np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))
        return Way(
            crosses=True,
            length=length,
            length_ratio=length / float(ends[1, axis] - ends[0, axis]),
            points=np.concatenate([ends[:1], points[moved], ends[1:]]),
            **worst_of(self.ground, self.body, lanes, turned),
        )

    def _length(self, places: list[Place]) -> float:
        """Return the length of a way over places, metres; a turn by 45 degrees is as long as the path of its sides."""
        turned = np.diff(np.array(places), axis=0)
        moves = float(np.hypot(*turned[:, :2].T).sum()) * self.field.block_width
        return moves + np.count_nonzero(turned[:, 2]) * self.lattice.turn_length

    def _driven_way(self, length: float, places: list[Place]) -> DrivenWay:
        """Return the way over places, pose by pose."""
        # Drops and slips count from the first pose of their lane; turns have none.
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
        points, yaw = self._points(places), places[:, 2] * np.pi / 4
        begin, last = 0, len(places) - 1
        for m in range(len(places)):
            turns_on = m < last and places[m, 2] != places[m + 1, 2]
            if m < last and not turns_on:
                continue
            # The straight piece ends here: it is one lane from where it began, and a turn may follow.
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
    """Return the first and last point of each straight piece of a line, indices (n, 2); heading: of its lanes."""
    turns = np.append(np.append(0, np.flatnonzero(np.diff(heading)) + 1), len(heading))
    pieces = np.stack([turns[:-1], turns[1:]], axis=1)
    return np.asarray(pieces[(line[turns[:-1]] != line[turns[1:]]).any(axis=1)])


def _number_at(line: Array, piece: Ints, share: float) -> int:
    """Return the number of the lane at a share of the length of a straight piece; piece: its first and last point."""
    first, last = piece
    run = np.hypot(*np.diff(line[first : last + 1], axis=0).T).cumsum()
    return int(first + np.searchsorted(run[:-1], share * run[-1], side="right"))


def _run_starts(which: Mask) -> list[int]:
    """Return the index of the first element of each run in a mask."""
    return [int(at) for at in np.flatnonzero(which & ~np.append(False, which[:-1]))]


def best_way(field: StepField, body: Body, axis: int, best: str = "length") -> Way:
    """Return the best way across a field along an axis, 0 for x and 1 for y; best: one of BEST.

    The shortest way is the straight one with the least tilt, if a straight lane is driven; else it is on the lattice.
    """
    direct = straight_way(field, body, axis)
    if direct and best == "length":
        return direct
    way = Planner(Lattice(field, body, best, partial(report_share, "a way across"))).way(axis)
    report_share("a way across", 1)
    return way or direct or no_way(straight(field, body, axis), body)
