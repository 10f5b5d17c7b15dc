"""Paths across many fields at once: percolation steps, and cheapest paths, lowered until they can be crossed.

A cell's value, the highest step or the cost of the best path to it, follows from that of its neighbours. Rows take it
over from the row before, up and down both axes, until no value changes (fast sweeping, Zhao 2005): one operation per
row does it for all maps, which are the last axis of every array, in consecutive memory. The rounds are as many as the
most winding path has bends, so fields of many cells are faster one by one (traversability.py).

A map may have several cheapest paths. The one that is taken is the path of `traversability.cheapest_paths`: its front
settles all cells within a tread of the cheapest one together, and the neighbour that is settled first, or in the same
pass comes first of its four sides, is the one before a cell. Passes follow from the costs alone, so no front is needed.
Heights are multiples of their greatest common divisor, in as few bits as hold them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rsegen.field.stepfield import NO_CAP, Ints, Mask, StepField
from rsegen.field.traversability import cells_to_each_side, highest_levels, widened
from rsegen.params.sorts import NANOMETRE_DIGITS, NANOMETRES

if TYPE_CHECKING:
    from rsegen.field.crossing import StepLimits

LARGE = 10_000
"""Cells of a map, frames counted, from which maps are faster one by one: measured on random maps."""


class Lanes(NamedTuple):
    """The ground of many fields with level ground before and behind them along the first axis.

    heights: (n_x, n_y, maps) in multiples of `unit` [nm]   margin: rows of level ground before and behind
    ahead, aside: |step| to the next cell along either axis, (n_x - 1, n_y, maps) and (n_x, n_y - 1, maps)
    rows, columns: where moves along the first axis, and along the second one, are allowed
    """

    heights: Ints
    unit: int
    margin: int
    rows: Mask
    columns: Mask

    @property
    def ahead(self) -> Ints:
        """The signed step to the next cell along the first axis."""
        return np.diff(self.heights, axis=0)

    @property
    def aside(self) -> Ints:
        """The signed step to the next cell along the second axis."""
        return np.diff(self.heights, axis=1)

    def closed(self, ahead: Ints, aside: Ints, far: int) -> tuple[Ints, Ints]:
        """Return values of moves in which those that are not allowed are `far`."""
        ahead[:, ~self.rows], aside[~self.columns] = far, far
        return ahead, aside


def lanes(levels: Ints, like: StepField, width: float, axis: int) -> Lanes:
    """Return the lanes of fields of these levels (n_x, n_y, maps) that otherwise are equal to `like`, along an axis."""
    metres = np.append(np.arange(int(levels.max(initial=0)) + 1) * like.unit, like.frame_height)
    sizes = np.rint(np.round(metres, NANOMETRE_DIGITS) * NANOMETRES).astype(np.int64)
    unit = int(np.gcd.reduce(sizes)) or 1
    sizes //= unit
    sizes = sizes.astype(np.result_type(np.int16, np.min_scalar_type(-2 * int(sizes.max()) - 2)))
    heights = np.where(like.frame[:, :, None], sizes[-1], sizes[levels])
    margin = cells_to_each_side(like, width) + 1
    along = heights if axis == 0 else heights.swapaxes(0, 1)
    ground = widened(np.pad(along, ((margin, margin), (0, 0), (0, 0))), margin - 1)
    return Lanes(ground, unit, margin, like.inside(1 - axis), np.pad(like.inside(axis), margin, constant_values=True))


def percolation_steps(lanes: Lanes) -> Ints:
    """Return the percolation step of each map along the first axis of its lane, in units of the heights."""
    far = np.iinfo(lanes.heights.dtype).max
    ahead, aside = lanes.closed(np.abs(lanes.ahead), np.abs(lanes.aside), far)
    return np.asarray(
        _least(
            np.maximum,
            _from_first_row(lanes.heights.shape, lanes.heights.dtype.type(far)),
            (ahead, ahead),
            (aside, aside),
        )[-1].min(axis=0)
    )


def lowered_to_cross(levels: Ints, like: StepField, limits: StepLimits, axis: int) -> tuple[Ints, Mask]:
    """Return fields (n_x, n_y, maps) lowered along a path by which they are crossed, and which of them had to be."""
    # Three cases by the percolation step: below both limits a map is crossed, above both it is not, and between them,
    # where climb and drop differ, a path decides.
    ground, (least, most) = lanes(levels, like, limits.width, axis), sorted(limits.limits)
    needed = percolation_steps(ground)
    blocked = needed > least // ground.unit
    between = np.flatnonzero(blocked & (needed <= most // ground.unit))
    if len(between):
        part = ground._replace(heights=ground.heights[:, :, between])
        blocked[between] = ~_are_crossed(part, (limits.limits[0] // part.unit, limits.limits[1] // part.unit))
    if not blocked.any():
        return levels, blocked
    ground = ground._replace(heights=ground.heights[:, :, blocked])
    type(limits).of(int(needed.max()) * ground.unit / NANOMETRES, limits.width)  # that steps are within bounds
    # The cells of the blocked maps' paths get caps, which hold for all cells under the robot.
    path = _cheapest_path(ground, needed[blocked], round(like.block_width * NANOMETRES))
    caps: Any = np.full(ground.heights.shape, NO_CAP, dtype=np.int32)
    along = ground.heights.ravel().take(path) * np.int64(ground.unit)  # from the end, and levels from the start
    caps.ravel()[path] = highest_levels(along[::-1], like, limits)[::-1]
    caps = -widened(-caps, ground.margin - 1, -NO_CAP)[ground.margin : -ground.margin]
    lowered = levels.copy()
    lowered[:, :, blocked] = np.minimum(levels[:, :, blocked], caps if axis == 0 else caps.swapaxes(0, 1))
    return lowered, blocked


def _are_crossed(lanes: Lanes, limits: tuple[int, int]) -> Mask:
    """Return which maps have a path across with steps within limits, up and down, in units of the heights."""
    climb, drop = limits

    def closed(sign: int) -> tuple[Any, Any]:
        rises = (sign * rise for rise in (lanes.ahead, lanes.aside))
        ahead, aside = (((rise > climb) | (-rise > drop)).astype(np.int8) for rise in rises)
        return lanes.closed(ahead, aside, 1)

    (ahead, aside), (back, aside_back) = closed(1), closed(-1)
    start = _from_first_row(lanes.heights.shape, np.int8(1))
    return np.asarray(_least(np.maximum, start, (ahead, back), (aside, aside_back))[-1].min(axis=0) == 0)


def _cheapest_path(lanes: Lanes, limit: Ints, tread: int) -> Ints:
    """Return the cheapest path of each map with steps of up to its limit, from its end to its start.

    Flat indices of heights, (length, maps); shorter paths stay at their start.
    """
    # In units of the heights or, if a tread is no multiple of them, of the greatest common divisor of both.
    unit = int(np.gcd(tread, lanes.unit))
    scale, tread = lanes.unit // unit, tread // unit
    most = lanes.heights[..., 0].size * (tread + int(limit.max()) * scale)  # cost of a path through all cells
    kind = np.result_type(np.int16, np.min_scalar_type(-4 * most - 4)).type
    far = int(np.iinfo(kind).max) // 2
    steps = (np.abs(rise) for rise in (lanes.ahead, lanes.aside))
    ahead, aside = (np.where(own <= limit, own.astype(kind) * kind(scale) + kind(tread), kind(far)) for own in steps)
    ahead, aside = lanes.closed(ahead, aside, far)
    costs = _least(np.add, _from_first_row(lanes.heights.shape, kind(far)), (ahead, ahead), (aside, aside))
    before, row = _before(costs, ahead, aside, tread), costs[0].size
    offsets = np.array([row, row // costs.shape[1], -(row // costs.shape[1]), -row])[before]
    n_x, n_y, maps = costs.shape
    places = ((n_x - 1) * n_y + costs[-1].argmin(axis=0)) * maps + np.arange(maps)
    path = [places]
    while (goes_on := places >= row).any():
        places = np.where(goes_on, places + offsets.ravel().take(places), places)
        path.append(places)
    return np.array(path)


def _before(costs: Any, ahead: Any, aside: Any, tread: int) -> Any:
    """Return the side of each cell on which the cell before it lies, of those across: 0 next along the first axis,
    1 next along the second, 2 and 3 the ones before along the second and the first; the first one that is settled.
    """
    # In which pass of the front each cell would be settled, up to the pass that reaches the end.
    passes, begin, last, far = np.zeros_like(costs), costs[0, 0] * 0, costs[-1].min(axis=0), np.iinfo(costs.dtype).max
    while (begin <= last).any():
        later = costs >= begin + costs.dtype.type(tread)
        passes += later
        begin = np.where(later, costs, far // 2).min(axis=(0, 1))
    first = np.full_like(costs, far)
    up, down = np.s_[1:], np.s_[:-1]
    moves = (
        (down, up, ahead),
        (np.s_[:, :-1], np.s_[:, 1:], aside),
        (np.s_[:, 1:], np.s_[:, :-1], aside),
        (up, down, ahead),
    )
    # Of the neighbours that lead to a cell at its cost, the earliest pass, and in it the first side: one number each.
    for side, (at, of, move) in enumerate(moves):
        leads = costs[of] + move == costs[at]
        np.minimum(first[at], np.where(leads, passes[of] * 4 + side, far), out=first[at])
    return first & 3


def plateaus(levels: Ints) -> Ints:
    """Return the first cell, as a flat index, of the component of equal level of each cell (n_x, n_y, maps)."""
    n_x, n_y, maps = levels.shape
    cells = np.arange(n_x * n_y, dtype=np.min_scalar_type(-n_x * n_y)).reshape(n_x, n_y, 1)
    ahead, aside = (np.where(np.diff(levels, axis=axis) == 0, cells[0, 0], cells[-1, -1]) for axis in (0, 1))
    return _least(np.maximum, np.repeat(cells, maps, axis=2), (ahead, ahead), (aside, aside))  # type: ignore[no-any-return]


def _from_first_row(shape: tuple[int, ...], far: Any) -> Ints:
    """Return the values of paths before any sweep: 0 in the first row, `far` elsewhere."""
    values = np.full(shape, far)
    values[0] = 0
    return values


def _least(join: np.ufunc, values: Any, ahead: tuple[Any, Any], aside: tuple[Any, Any]) -> Any:
    """Lower the value of each cell (n_x, n_y, maps) to the least of any path that leads to it, by sweeps, in place.

    join: the value of a path with its next move: np.add for costs, np.maximum for highest steps
    ahead, aside: values of the moves to the next cell along either axis, and of the moves back
    """
    across = values.swapaxes(0, 1), *(moves.swapaxes(0, 1) for moves in aside)
    while True:
        before = values.copy()
        for own, onward, back in ((values, *ahead), across):
            _swept(own, onward, join)
            _swept(own[::-1], back[::-1], join)
        if (before == values).all():
            return values


def _swept(values: Any, moves: Any, join: np.ufunc) -> None:
    """Update the value of each cell from its predecessor along the first axis."""
    for k in range(len(moves)):
        np.minimum(values[k + 1], join(values[k], moves[k]), out=values[k + 1])
