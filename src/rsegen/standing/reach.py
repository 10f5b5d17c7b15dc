"""Reach of a robot on a field: its largest region, its poses there, and its shortest ways across.

The largest region needs all turns, but few moves. The moves known to be driven form strongly connected components that
can only grow; with all moves that may be driven the components can only shrink. A move is driven only if it leads
between two known components within one possible component, and that one is as large as the largest known. Moves that
connect each component with one before it, as a tree, come first. So edges are looked at as lazily as in lazy searches
(Bohlin and Kavraki 2000).

    (a b)--?->(c d)           known: a and b, c and d are each one part; that a move leads from b to c is possible
      ^---?-----'             and one from d to a: all four may be one part, so both are driven
    (e)                       no move leads to e and back: whether others do need not be known

Cost: half of the moves where the robot gets nearly everywhere, but nearly all where it gets nowhere: a second to ten on
10 x 10 to 40 x 40 blocks. What breaks it: what breaks lanes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rsegen.field.graphs import strongly_connected
from rsegen.field.stepfield import Array, Ints, Mask, StepField, make_read_only, read_only_copies
from rsegen.standing.body import Body
from rsegen.standing.lanes import lines_along, straight
from rsegen.standing.lattice import HEADINGS, Lattice, Watch, unwatched
from rsegen.standing.planner import Planner
from rsegen.standing.pose_statistics import PoseStatistics, statistics_of
from rsegen.standing.ways import Way, no_way, straight_way


@read_only_copies
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
        make_read_only(self.region)


_TURNS_AT_ONCE, _MOVES_AT_ONCE, _LEAST_MOVES = 8192, 2048, 128
"""Places whose turns are found together in the search for a region, and moves at most: a second of work; and moves at
least, as fewer cost as much."""

_TURNING = 0.2
"""Share of the search for a region that turns take; the others are moves."""


def reach(field: StepField, body: Body, watch: Watch = unwatched) -> Reach:
    """Return where a robot gets on a field, and its shortest ways across."""
    lattice = Lattice(field, body, watch=watch)
    region, blocks = region_of(lattice), int((~field.frame).sum())
    planner, ways = Planner(lattice), []
    for axis in (0, 1):
        watch(1.0)  # the lanes below are a tenth of the work
        direct = straight_way(field, body, axis, _straight_lines(lattice, axis))
        ways.append(direct or planner.way(axis) or no_way(straight(field, body, axis), body))
    cover = float(region.sum() / blocks) if blocks else 0.0
    poses = statistics_of(lattice.ground, body, lattice.at_blocks())
    return Reach(coverage=cover, poses=poses, west_east=ways[0], south_north=ways[1], region=region)


def region_of(lattice: Lattice) -> Mask:
    """Return the largest set of blocks on which the robot gets from every place and heading to every other.

    Of several largest sets it is the one with the first place. A move is driven only if it may change the set.
    """
    _turn_everywhere(lattice)
    tails, heads = lattice.all_moves
    able = lattice.stands.ravel()[tails] & lattice.stands.ravel()[heads]
    tails, heads = tails[able], heads[able]
    while True:
        may = lattice.moves.ravel()[tails] | ~lattice.is_driven.ravel()[tails]
        tails, heads = tails[may], heads[may]
        passed = lattice.is_driven.ravel()[tails]
        known, possible = _components(lattice, tails[passed], heads[passed]), _components(lattice, tails, heads)
        region = _largest(lattice, known)
        # A move within a part changes nothing, nor does one between parts that will never be one, or be one that is
        # smaller than another.
        matters = (known[tails] != known[heads]) & (possible[tails] == possible[heads])
        matters &= _sizes(lattice, possible)[tails] >= region.sum()
        is_open = matters & ~passed
        if not is_open.any():
            lattice.tell(1.0)
            return region
        lattice.tell(_TURNING + (1 - _TURNING) * (1 - float(is_open.sum()) / lattice.moves.size))
        from_, to = known[tails[matters]], known[heads[matters]]
        chosen = np.flatnonzero(matters)[_connecting(from_, to, tails[matters] % 2, ~passed[matters])]
        lattice.drive_from(tails[chosen[:_MOVES_AT_ONCE]])


def _straight_lines(lattice: Lattice, axis: int) -> Array:
    """Return the middles of the lines along an axis, metres, on which nothing is known to end a straight way."""
    field, heading = lattice.field, 2 * axis
    fails = (lattice.is_settled & ~lattice.stands)[..., heading]
    ends = (lattice.is_driven & ~lattice.moves)[..., heading]
    onward = np.arange(field.shape[axis] - 1)  # from the last cell no move leads on
    ended = fails.any(axis=axis) | ends.take(onward, axis=axis).any(axis=axis)
    return field.middles()[1 - axis][lines_along(field, axis) & ~ended]


def _turn_everywhere(lattice: Lattice) -> None:
    """Find all turns of a lattice, and so all poses at its places."""
    places = np.arange(lattice.turns.size)
    for begin in range(0, places.size, _TURNS_AT_ONCE):
        lattice.turn_at(places[begin : begin + _TURNS_AT_ONCE])
        lattice.tell(_TURNING * float(lattice.is_turned.mean()))


def _components(lattice: Lattice, tails: Ints, heads: Ints) -> Ints:
    """Return for each place the number of its strongly connected component, with all turns and some moves."""
    places, turns = np.arange(lattice.moves.size).reshape(lattice.moves.shape), lattice.turns.ravel()
    low, high = np.append(places.ravel(), tails), np.append(np.roll(places, -1, axis=2).ravel(), heads)
    is_turn = np.arange(len(low)) < places.size
    onward = np.append(turns, np.ones(len(tails), bool))
    group = strongly_connected(places.size, low, high, onward, onward & is_turn)
    # A component is numbered by its first place.
    _, first, rank = np.unique(group, return_index=True, return_inverse=True)
    return np.asarray(first[rank])


def _cells(lattice: Lattice, group: Ints) -> Ints:
    """Return the components of places and the blocks over which they are in any heading, (n, 2)."""
    cells = np.unique(np.stack([group, np.arange(group.size) // HEADINGS], axis=1), axis=0)
    return np.asarray(cells[~lattice.field.frame.ravel()[cells[:, 1]]])


def _sizes(lattice: Lattice, group: Ints) -> Ints:
    """Return for each place the number of blocks of its component."""
    return np.asarray(np.bincount(_cells(lattice, group)[:, 0], minlength=group.size)[group])


def _largest(lattice: Lattice, group: Ints) -> Mask:
    """Return the blocks of the component with the most, (n_x, n_y)."""
    cells, region = _cells(lattice, group), np.zeros(lattice.field.levels.size, bool)
    if len(cells):
        region[cells[cells[:, 0] == np.bincount(cells[:, 0]).argmax(), 1]] = True
    return region.reshape(lattice.field.shape)


def _connecting(tails: Ints, heads: Ints, is_diagonal: Ints, is_open: Mask) -> Ints:
    """Return the indices of a few open moves between parts that are likely to join many parts.

    From each part one move leads to a part before it, by number, and one back, if both are possible; straight moves are
    chosen first, as they are shorter.
    tails, heads: the parts that each move leads from and to, both of open moves and of those known to be passed
    """
    # A pair is two parts with moves between them; it may become one part only if moves lead there and back.
    low, high, onward = np.minimum(tails, heads), np.maximum(tails, heads), tails < heads
    _, pair = np.unique(np.stack([high, low], axis=1), axis=0, return_inverse=True)
    pair = pair.ravel()
    leads, back = (np.bincount(pair[side], minlength=len(pair)) > 0 for side in (onward, ~onward))
    moves = np.flatnonzero(is_open)
    moves = moves[np.lexsort((low[moves], is_diagonal[moves], ~(leads & back)[pair[moves]], high[moves]))]
    # Of each later part the best pair, and of that one move in each direction.
    _, first, part = np.unique(high[moves], return_index=True, return_inverse=True)
    best = np.flatnonzero(pair[moves] == pair[moves][first][part])
    _, once = np.unique(2 * part[best] + onward[moves][best], return_index=True)
    # Enough of them to be worth the cost of a call.
    order = np.concatenate([best[once], np.delete(np.arange(len(moves)), best[once])])
    return np.asarray(moves[order[: max(len(once), _LEAST_MOVES)]])
