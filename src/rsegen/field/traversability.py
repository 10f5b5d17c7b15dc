"""Traversability within limits of steps: like NIST's coverability and crossability, by formulas of our own.

1. Ground: a path of some width, centred on a cell, is as high as the highest of the cells below it. So the ground is
   the maximum over (2 aside + 1)^2 cells, by doubling runs along each axis. Frames count. A path crosses frames but
   does not go along them, which would lead around every obstacle: there are no moves along x in a row of only frame
   cells, and none along y in such a column.
2. Coverage: moves within climb and drop are a directed graph; the largest strongly connected component (graphs.py) is
   the area in which the robot can drive from every block to every other.
3. Crossing: the cheapest path between the level ground on two opposite sides, where a move costs its length plus its
   rise or drop. It is Dijkstra's algorithm (1959), by fronts: no move costs less than a tread (a block width),
   so all cells of the front that cost less than the cheapest one plus a tread are settled, and expanded together. The
   loop is as long as the most expensive path has treads, each pass one numpy operation per direction.
4. Percolation step: the smallest step at which a path from side to side exists, by bisection over the steps of the
   field, with union of the components below the middle one; half of the edges are left after each round.

Heights are whole nanometres, so comparisons are exact. Nothing stands, tips or hangs on its belly here: how a robot
gets across is in standing.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsegen.field.graphs import component_labels, strongly_connected
from rsegen.field.stepfield import NO_CAP, Array, Ints, Mask, StepField, make_read_only, read_only_copies
from rsegen.field.steps import steps
from rsegen.params.sorts import NANOMETRES

if TYPE_CHECKING:  # they find paths here
    from rsegen.field.crossing import StepLimits

Heights = NDArray[np.int64]


class PathGround(NamedTuple):
    """Heights (n_x, n_y) in nanometres; rows j in which moves along x are allowed, columns i for moves along y."""

    heights: Heights
    rows: Mask
    columns: Mask

    def moves(self) -> tuple[Ints, Ints]:
        """Return every move between two neighbours once, as flat indices: the cell of smaller x or y, and the other."""
        cells = np.arange(self.heights.size).reshape(self.heights.shape)
        along_x, along_y = cells[:, self.rows], cells[self.columns]
        low = np.concatenate([along_x[:-1].ravel(), along_y[:, :-1].ravel()])
        high = np.concatenate([along_x[1:].ravel(), along_y[:, 1:].ravel()])
        return low, high


def ground(field: StepField, width: float) -> PathGround:
    """Return the ground of a field, frames counted, for robots of a width in metres whose middle is on a cell."""
    heights = widened(field_heights(field), cells_to_each_side(field, width))
    return PathGround(heights, rows=field.inside(1), columns=field.inside(0))


def lane(field: StepField, width: float, axis: int) -> PathGround:
    """Return the ground with level ground before and behind the field along an axis, which becomes the first axis."""
    margin = cells_to_each_side(field, width) + 1
    heights = field_heights(field) if axis == 0 else field_heights(field).T
    ground = widened(np.pad(heights, ((margin, margin), (0, 0))), margin - 1)
    columns = np.pad(field.inside(axis), margin, constant_values=True)
    return PathGround(ground, rows=field.inside(1 - axis), columns=columns)


def field_heights(field: StepField) -> Heights:
    """Return the heights of a field's cells (n_x, n_y) in nanometres."""
    return np.rint(field.heights * NANOMETRES).astype(np.int64)


def widened(heights: Any, aside: int, around: int = 0) -> Any:
    """Return the maximum over the (2 aside + 1)^2 cells around each cell (n_x, n_y, ...).

    around: height of the ground outside the field.
    """
    for _axis in (0, 1):
        margins = ((aside, aside), *[(0, 0)] * (heights.ndim - 1))
        heights, covered = np.pad(heights, margins, constant_values=around), 1
        while covered <= 2 * aside:  # rows over which each is the maximum: doubled, up to 2 aside + 1
            ahead = min(covered, 2 * aside + 1 - covered)
            heights = np.maximum(heights[:-ahead], heights[ahead:])
            covered += ahead
        heights = heights.swapaxes(0, 1)
    return heights


UNREACHABLE = np.iinfo(np.int64).max
"""Cost of a cell to which no path leads."""

_WALL = 2**62
"""Height of the border, nanometres: no robot climbs it, and its difference to any height still fits into 64 bits."""


class CheapestPaths(NamedTuple):
    """The cheapest path from the first row to each cell: its cost, or UNREACHABLE; its moves; the cell before."""

    costs: Heights
    moves: NDArray[np.int64]
    predecessors: NDArray[np.int64]

    def path_to(self, place: int) -> NDArray[np.int64]:
        """Return the path to the cell of a flat index, as indices along both axes: (n, 2)."""
        cells = [place]
        while (place := int(self.predecessors.flat[place])) >= 0:
            cells.append(place)
        return np.stack(np.unravel_index(cells[::-1], self.predecessors.shape), axis=1)


def cheapest_paths(ground: PathGround, tread: int, limits: tuple[int, int], *, shortest: bool) -> CheapestPaths:
    """Return the cheapest paths from the first row to each cell; a move costs tread + |dh|, within (climb, drop).

    shortest: of equally cheap paths, the one with the fewest moves; else any, but the same in every run. All lengths
    are in the same unit.
    """
    # On a flat array with a border of walls the neighbours of a cell are at -row, -1, 1 and row. Of the front, cells
    # are settled that no path through another one can make cheaper; these are expanded, the others wait.
    flat, row = np.pad(ground.heights, 1, constant_values=_WALL).ravel(), ground.heights.shape[1] + 2
    rows, columns = (np.pad(open_, 1) for open_ in (ground.rows, ground.columns))
    costs, moves, predecessors = (np.full(flat.size, value) for value in (UNREACHABLE, 0, -1))
    front = np.arange(row + 1, 2 * row - 1)
    costs[front] = 0
    while len(front):
        settled = costs[front] < costs[front].min() + tread
        nodes, fronts = np.unique(front[settled]), [front[~settled]]
        may_go = {row: rows[nodes % row], 1: columns[nodes // row]}
        for side in (-row, -1, 1, row):
            rise = flat[nodes + side] - flat[nodes]
            cost = costs[nodes] + tread + np.abs(rise)
            better = cost < costs[nodes + side]
            if shortest:
                better |= (cost == costs[nodes + side]) & (moves[nodes] + 1 < moves[nodes + side])
            better &= may_go[abs(side)] & (rise <= limits[0]) & (-rise <= limits[1])
            before = nodes[better]
            reached = before + side
            costs[reached], moves[reached], predecessors[reached] = cost[better], moves[before] + 1, before
            fronts.append(reached)
        front = np.concatenate(fronts)
    # Without the border: the values, and the flat indices of predecessors.
    costs, moves, places = (values.reshape(-1, row)[1:-1, 1:-1] for values in (costs, moves, predecessors))
    return CheapestPaths(costs, moves, np.where(places < 0, -1, (places // row - 1) * (row - 2) + places % row - 1))


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Crossing:
    """The cheapest path between the level ground on two opposite sides, of equally cheap ones the shortest.

    Lengths are None if no path leads across.

    length: in the plan   cost: length + every rise and drop on it, metres   ratios: to the straight and level path
    path: (n, 2), its cells i, j; those on the ground are outside the field   costs: (n_x, n_y), inf if unreachable
    """

    crosses: bool
    length: float | None
    length_ratio: float | None
    cost: float | None
    cost_ratio: float | None
    path: Ints
    costs: Array

    def __post_init__(self) -> None:
        make_read_only(self.path, self.costs)


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Traversability:
    """The traversability of a field within limits of steps: passable steps, coverage and crossings.

    climbable, droppable: share of the steps between blocks within the limit up, or down; None without a step
    coverage: the share of the blocks in the largest traversable area, in which paths lead from every block to
    every other, measured by the blocks that carry it; region: (n_x, n_y), the mask of that area
    """

    limits: StepLimits
    climbable: float | None
    droppable: float | None
    coverage: float
    west_east: Crossing
    south_north: Crossing
    region: Mask

    def __post_init__(self) -> None:
        make_read_only(self.region)


def cells_to_each_side(field: StepField, width: float) -> int:
    """Return the number of cells under a robot of a width [m], to each side of the cell that it is centred on."""
    # Rounded to a millionth of a cell first, so that a robot of exactly three cells does not cover a fourth.
    aside = ceil(round((width / field.block_width - 1) / 2, 6))
    return min(max(aside, 0), max(field.shape))


def traversability(field: StepField, limits: StepLimits) -> Traversability:
    """Return the traversability of a field within limits; frames are obstacles, but are not counted as area."""
    too_high, too_deep = (steps(field).share_above(limit / NANOMETRES) for limit in limits.limits)
    region = _largest_region(field, limits)
    return Traversability(
        limits=limits,
        climbable=None if too_high is None else 1 - too_high,
        droppable=None if too_deep is None else 1 - too_deep,
        coverage=float(region.sum() / (~field.frame).sum()),
        west_east=crossing(field, limits, 0),
        south_north=crossing(field, limits, 1),
        region=region,
    )


def _largest_region(field: StepField, limits: StepLimits) -> Mask:
    """Return the mask of the blocks of the largest strongly connected component; of two equal ones, of the first.

    The largest component has the most blocks that carry the robot, as no cell below it is higher; of equal ones, the
    most blocks. So it is the floor, and not the surroundings of a barrier, on which a wide robot would stand.
    """
    carrying = ground(field, limits.width)
    (low, high), (climb, drop) = carrying.moves(), limits.limits
    rise = carrying.heights.flat[high] - carrying.heights.flat[low]
    onward, back = (rise <= climb) & (-rise <= drop), (-rise <= climb) & (rise <= drop)
    group = strongly_connected(field.levels.size, low, high, onward, back).reshape(field.shape)
    blocks = ~field.frame
    carries = blocks & (field_heights(field) == carrying.heights)
    carried, size = (np.bincount(group[cells], minlength=group.size) for cells in (carries, blocks))
    return np.asarray(blocks & (group == (carried * (group.size + 1) + size).argmax()))


def crossing(field: StepField, limits: StepLimits, axis: int, *, shortest: bool = True) -> Crossing:
    """Return the cheapest crossing of a field, along x for axis 0, along y for axis 1; the shortest of equal ones."""
    carrying = lane(field, limits.width, axis)
    paths = cheapest_paths(carrying, round(field.block_width * NANOMETRES), limits.limits, shortest=shortest)
    margin = (len(paths.costs) - field.shape[axis]) // 2  # rows of level ground before and behind the field
    costs = np.where(paths.costs == UNREACHABLE, np.inf, paths.costs / NANOMETRES)[margin:-margin]
    costs = costs if axis == 0 else costs.T
    end = int(np.lexsort((paths.moves[-1] * shortest, paths.costs[-1]))[0])
    if (cost := int(paths.costs[-1, end])) == UNREACHABLE:
        none = np.empty((0, 2), dtype=np.int64)
        return Crossing(
            crosses=False, length=None, length_ratio=None, cost=None, cost_ratio=None, path=none, costs=costs
        )
    path = paths.path_to(paths.costs.size - paths.costs.shape[1] + end) - (margin, 0)
    length, straight = ((cells - 1) * field.block_width for cells in (len(path), len(paths.costs)))
    return Crossing(
        crosses=True,
        length=length,
        length_ratio=length / straight,
        cost=cost / NANOMETRES,
        cost_ratio=cost / NANOMETRES / straight,
        path=path if axis == 0 else path[:, ::-1],
        costs=costs,
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Percolation:
    """The percolation step in metres: over all paths from side to side, the smallest of their highest steps."""

    west_east: float
    south_north: float


def percolation(field: StepField, width: float = 0.0) -> Percolation:
    """Return the percolation step for robots of a width in metres, from the ground on one side to that on the other."""
    west_east, south_north = (percolation_step(field, width, axis) for axis in (0, 1))
    return Percolation(west_east=west_east, south_north=south_north)


def percolation_step(field: StepField, width: float, axis: int) -> float:
    """Return the percolation step in metres along x for axis 0, along y for axis 1."""
    return _minimax(lane(field, width, axis)) / NANOMETRES


def _minimax(ground: PathGround) -> int:
    """Return the smallest step that connects both sides, by bisection over the steps with union of components."""
    # If the middle step opens a way, larger steps are dropped; if not, all that it connects becomes one node.
    heights, (low, high) = ground.heights, ground.moves()
    steps = np.abs(heights.flat[high] - heights.flat[low])
    first, last, limits = 0, heights.size - 1, np.unique(steps)
    while len(limits) > 1:
        limit = limits[(len(limits) - 1) // 2]
        root = component_labels(heights.size, low[steps <= limit], high[steps <= limit])
        opens = root[first] == root[last]
        limits = limits[limits <= limit] if opens else limits[limits > limit]
        if not opens:
            low, high, first, last = root[low], root[high], root[first], root[last]
        left = steps <= limit if opens else low != high
        low, high, steps = low[left], high[left], steps[left]
    return int(limits[0])


def path_caps(field: StepField, limits: StepLimits, axis: int) -> Ints | None:
    """Return the highest levels along the cheapest path of the least highest step; None if one leads across."""
    step, (least, most) = percolation_step(field, limits.width, axis), sorted(limits.limits)
    needed = round(step * NANOMETRES)
    # A path is searched only if the percolation step is between both limits.
    if needed <= least or (needed <= most and crossing(field, limits, axis).crosses):
        return None
    # Any of the cheapest: another would be another map.
    path = crossing(field, type(limits).of(step, limits.width), axis, shortest=False).path
    aside = cells_to_each_side(field, limits.width)
    caps = np.full(field.shape, NO_CAP)
    for (i, j), top in zip(path, _tops(field, limits, axis, path), strict=True):
        under = slice(max(i - aside, 0), max(i + aside + 1, 0)), slice(max(j - aside, 0), max(j + aside + 1, 0))
        caps[under] = np.minimum(caps[under], top)
    return caps


def _tops(field: StepField, limits: StepLimits, axis: int, path: Ints) -> Ints:
    """Return the highest level below the robot at each cell of its path from which it can go on."""
    margin = cells_to_each_side(field, limits.width) + 1
    along = (path if axis == 0 else path[:, ::-1]) + (margin, 0)
    return highest_levels(lane(field, limits.width, axis).heights[along[:, 0], along[:, 1]], field, limits)


def highest_levels(heights: Heights, field: StepField, limits: StepLimits) -> Ints:
    """Return the highest levels of the ground [nm] along paths (length, ...) from which a robot can go on."""
    # Lowered forward until no rise, and then backward until no drop, exceeds the limit; backward keeps the rises.
    tops, unit = heights.copy(), round(field.unit * NANOMETRES)
    climb, drop = (0 if limit < unit else limit for limit in limits.limits)  # less than a block is no step at all
    for k in range(1, len(tops)):
        tops[k] = np.minimum(tops[k], tops[k - 1] + climb)
    for k in range(len(tops) - 2, -1, -1):
        tops[k] = np.minimum(tops[k], tops[k + 1] + drop)
    return np.asarray(tops // unit)
