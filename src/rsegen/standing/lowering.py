"""Lowering of blocks until a robot drives across: the constraint `crossable_by` of a kind of robot.

A lane is straight, and as wide as the robot. If none is driven with room to spare, blocks of some lanes are lowered
where the robot's drive ends, and nowhere else, so a lane stays as rough as the robot can drive:

1. Lanes are cut into pieces that overlap. Each is driven by itself, also to either side, and turned to either side,
   with less momentum and friction than the robot has: what is left is room to spare.
2. Where a piece ends, the largest step between neighbouring blocks under the robot is made smaller by a unit, or, if
   it is one unit, the highest blocks at its front are lowered by one, or else those under all of it.
3. Again, with the pieces that have changed, until each is driven or has been lowered once in each of its ways: what is
   lowered again and again ends level. Then the lane is driven as a whole, from side to side.

Two lanes are lowered at a time, the most even ones first. The first one counts that is driven with room to spare and
has blocks in most of its cells, of two the one with fewer lowered units. If none does, lanes are lowered anew from
blocks of one unit, which a careful robot mostly drives over as they are: steps that become smaller unit by unit may end
lower. Else one with fewer blocks counts; else one that is driven at all. If the robot climbs no block of one unit, or
no lane is driven, or more room is asked for than is usual, a lane is made level.

Cost: some seconds; some thousand poses. What breaks it: what breaks lanes, above all robots that are turned.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import NO_CAP, Array, Ints, Mask, StepField
from rsegen.field.traversability import cells_to_each_side
from rsegen.recipe.constraints.meeting import envelope
from rsegen.standing.body import Body
from rsegen.standing.careful_lanes import careful, room_beside, safely_passed
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import (
    across,
    drive_lanes,
    driven_lanes,
    entry_distance,
    lines_along,
    step_of,
)
from rsegen.standing.settling import outer_radius

_FIRST_LANES, _LANES = 2, 8
"""Straight lanes that are driven at a time, first and then: few, as one of the first, most even ones is mostly
driven to its end, but enough for one call."""

_ON_BLOCKS = 0.6
"""Least share of the cells of a lane that have blocks, where that can be: wheels are then on blocks half of the way."""

_TRIED, _MOST_TRIED = 2, 8
"""Lanes that are lowered at a time, and at most: further ones if none of these has its blocks left."""

_DRIVEN = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
"""Variants in which a piece is driven: on the lane, to either side of it, and turned to either side."""

_TURNED = 0.1
"""Radians by which a robot is turned: blocks under one wheel, or track, turn robots by some ten degrees."""

_ROUNDS = 80
"""Rounds of lowering at most; most lanes take ten to forty."""

_FRONT = 2
"""Lines of cells at the front of a robot: that which it meets, and that half a block before it."""

_PIECE = 1.5
"""Length of a piece in blocks; they begin a block apart, so that no step is only at an end."""


def lane_caps(
    field: StepField, body: Body, axis: int, *, room: float, kind: str, report: Callable[[float], object]
) -> Ints | None:
    """Return the highest levels along a straight lane that a robot of a kind drives; None if it drives one already.

    room: share of the usual room to spare; report: called with the share that is done
    """
    # Along y as along x, on the transposed field.
    turned = field if axis == 0 else replace(field, levels=field.levels.T, frame=field.frame.T)
    aside = cells_to_each_side(field, body.width)
    lines = [
        line for line in np.flatnonzero(lines_along(field, axis)).tolist() if aside <= line < turned.shape[1] - aside
    ]
    lines = lines or [turned.shape[1] // 2]
    # Lanes are driven some at a time, the most even ones first, until one is driven to its end. Each axis is half of
    # the search: up to a half of that for the lanes as they are, the rest for lower and lower ones.
    steps = np.pad(np.abs(np.diff(turned.levels.astype(np.int64), axis=0)).sum(axis=0), aside)
    unevenness = np.lib.stride_tricks.sliding_window_view(steps, 2 * aside + 1).sum(axis=1)[lines_along(field, axis)]
    middles = across(field, axis)[np.argsort(unevenness, kind="stable")]
    driven, count = 0, _FIRST_LANES
    while driven < len(middles) and room <= 1:
        if _is_safe(field, body, axis, driven_lanes(field, body, axis, middles[driven : driven + count]), room):
            return None
        driven, count = min(driven + count, len(middles)), _LANES
        report((axis + driven / len(middles) / 2) / 2)
    # The first lowered lane with room to spare, or the first that is driven at all; the level lane comes last.
    chosen: Ints | None = None
    driver = careful(turned, body, room) if room <= 1 else None
    lowered_lanes = _lowered_lanes(turned, driver, room, lines, aside, partial(_report_lowering, report, axis))
    for line, levels in lowered_lanes:
        lane = slice(max(line - aside, 0), line + aside + 1)
        caps = np.full(turned.shape, NO_CAP)
        caps[:, lane] = np.where(turned.frame[:, lane], NO_CAP, levels)
        caps = caps if axis == 0 else caps.T
        lowered = replace(field, levels=np.minimum(field.levels, caps).astype(np.int16))
        middle = np.array([field.edges()[1 - axis][line] + field.block_width / 2])
        passed = driven_lanes(lowered, body, axis, middle)
        if _is_safe(lowered, body, axis, passed, min(room, 1)):
            chosen = caps
            break
        if chosen is None and len(passed):
            chosen = caps  # between other blocks, even a level lane may have less room than was asked for
    if chosen is None:
        high = f"{100 * field.frame_height:g} cm"
        raise ParameterError("crossable_by", f"{kind} cannot cross frames of {high}; use boundary none or lower frames")
    return chosen if (field.levels > chosen).any() else None


def _is_safe(field: StepField, body: Body, axis: int, driven: Array, room: float) -> bool:
    """Return whether one of the lanes that a robot drives has room to spare; driven: their places across, metres."""
    return bool(len(driven) and safely_passed(field, body, axis, driven, room).any())


def _lowered_lanes(
    field: StepField,
    driven: Body | None,
    room: float,
    lines: list[int],
    aside: int,
    report: Callable[[int, float], object],
) -> Iterator[tuple[int, Ints]]:
    """Yield lines of cells along x with lowered levels of their lanes, the best first; the last lane is a level one.

    driven: the careful robot; None if it climbs none of blocks as high as these
    """
    with_few_blocks: list[_Lowered] = []
    if driven is not None:
        # Lanes that take the fewest units to have steps of one unit; first all as they are, then from one unit high.
        least = sorted((_units(field, line, aside, _lane_levels(field, line, aside, 1)), line) for line in lines)
        best = [line for _, line in least[:_MOST_TRIED]]
        low = replace(field, levels=np.minimum(field.levels, 1))
        for done, (ground, first) in enumerate(product((field, low), range(0, len(best), _TRIED))):
            tried = best[first : first + _TRIED]
            strips = _Strips.of(ground, tried, aside).smoothed(driven, room, partial(report, done))
            lanes = [_lowered(field, line, strip, aside) for line, strip in zip(tried, strips, strict=True)]
            for lane in sorted(lanes, key=_preference):
                if (lane.levels > 0).mean() < _ON_BLOCKS:
                    with_few_blocks.append(lane)
                else:
                    yield lane.line, lane.levels
    yield from ((lane.line, lane.levels) for lane in sorted(with_few_blocks, key=_preference))
    _, line = min((_units(field, line, aside, _lane_levels(field, line, aside, 0)), line) for line in lines)
    yield line, _lane_levels(field, line, aside, 0)


class _Lowered(NamedTuple):
    """A lane about a line of cells along x with lower levels, and by how many units in all its blocks are lower."""

    units: int
    line: int
    levels: Ints


def _preference(lane: _Lowered) -> tuple[int, int]:
    """Return the key by which lanes are sorted: the fewest units first, and of equals the first line."""
    return lane.units, lane.line


def _lowered(field: StepField, line: int, strip: Ints, aside: int) -> _Lowered:
    """Return a lane out of a strip, without the cells beside it and those outside the field."""
    first, count = max(aside - line, 0), len(field.levels[0, max(line - aside, 0) : line + aside + 1])
    levels = strip[:, 1:-1][:, first : first + count]
    return _Lowered(_units(field, line, aside, levels), line, levels)


def _report_lowering(report: Callable[[float], object], axis: int, before: int, share: float) -> None:
    """Report how much of the search is done: lowering is the second half of an axis, and the first lanes are half of
    that, the next ones half of the rest; `before` of them are done.
    """
    report((axis + 1 - (1 - share / 2) / 2 ** (before + 1)) / 2)


def _units(field: StepField, line: int, aside: int, levels: Ints) -> int:
    """Return by how many units in all the blocks of a lane are lowered to levels."""
    own = field.levels[:, max(line - aside, 0) : line + aside + 1].astype(np.int64)
    return int((own - np.minimum(own, levels)).sum())


def _lane_levels(field: StepField, line: int, aside: int, limit: int) -> Ints:
    """Return the highest levels along x, about a line of cells, whose steps are within a limit, from the ground on."""
    lane = slice(max(line - aside, 0), line + aside + 1)
    levels = field.levels[:, lane].astype(np.int64)
    # Steps to each cell from the ground at the nearer end.
    steps = np.minimum(np.arange(len(levels)), np.arange(len(levels))[::-1]) + 1
    levels = np.minimum(levels, limit * steps[:, None])
    part = replace(field, levels=levels.astype(np.int16), frame=field.frame[:, lane])
    return np.where(part.frame, NO_CAP, envelope(part.levels, part, limit))


@dataclass(slots=True, eq=False)
class _Strips:
    """Lanes with the cells next to them, one next to the other as their own field, S of them.

    levels: (S, n, w), frame: (S, n, w), with a cell to each side of a lane that stays as it is
    """

    field: StepField
    levels: Ints
    frame: Mask

    @classmethod
    def of(cls, field: StepField, lines: list[int], aside: int) -> _Strips:
        """Return the strips of lanes about lines of cells."""
        width = 2 * (aside + 1) + 1
        levels, frame = (np.pad(values, ((0, 0), (aside + 1, aside + 1))) for values in (field.levels, field.frame))
        return cls(
            field=field,
            levels=np.stack([levels[:, line : line + width] for line in lines]).astype(np.int64),
            frame=np.stack([frame[:, line : line + width] for line in lines]),
        )

    def smoothed(self, body: Body, room: float, progress: Callable[[float], object]) -> Ints:
        """Return the levels with which all pieces of the lanes are driven, as far as lowering helps, (S, n, w)."""
        width, begin = self.field.block_width, -entry_distance(self.field, body, 0)
        end = self.field.extent[0] / 2 - min(float(body.low[0]), 0.0) + step_of(body)
        starts = np.arange(begin, end - width / 2, width)
        shape = (len(self.levels), len(starts), len(_DRIVEN))
        # What is to be driven, and what was lowered; each piece first as it last ended, then in all other ways.
        is_open, is_lowered, last = np.ones(shape, bool), np.zeros(shape, bool), np.zeros(shape[:2], int)
        for turn in range(_ROUNDS):
            progress(turn / _ROUNDS)
            first = is_open & ~is_lowered & (np.arange(len(_DRIVEN)) == last[..., None])
            chosen = np.argwhere(first if first.any() else is_open & ~is_lowered)
            if not len(chosen):
                break
            ends = self._ends(body, room, chosen, starts)
            is_open[tuple(chosen.T)] = ~np.isnan(ends)
            changed = np.zeros((shape[0], self.levels.shape[1] + 2), bool)
            for (strip, piece, way), x in zip(chosen.tolist(), ends.tolist(), strict=True):
                if np.isnan(x):
                    continue
                last[strip, piece] = way
                window = self._window(x, body)
                # Lowered in this round already: that may be enough, so it is driven again first.
                if changed[strip, window].any():
                    continue
                self._lower(strip, window)
                is_lowered[strip, piece, way] = changed[strip, window] = True
            # All pieces along which the robot is above changed cells are driven again.
            for strip, piece in np.ndindex(shape[:2]):
                near = slice(
                    self._window(float(starts[piece]), body).start,
                    self._window(float(starts[piece] + _PIECE * width), body).stop,
                )
                is_open[strip, piece] |= changed[strip, near].any()
        return self.levels

    def _window(self, x: float, body: Body) -> slice:
        """Return the lines of cells under a robot with its origin at x, metres, and half a block ahead of it.

        Lines count from the ground before the field, 0, to the ground behind it.
        """
        width, count = self.field.block_width, self.levels.shape[1]
        low, high = x + float(body.low[0]), x + float(body.high[0]) + width / 2
        first, last = (int(np.floor(at / width + count / 2)) + 1 for at in (low, high))
        return slice(min(max(first, 0), count + 1), min(max(last, 0), count + 1) + 1)

    def _ends(self, body: Body, room: float, pieces: Ints, starts: Array) -> Array:
        """Return where pieces end, x of the robot's origin, metres; NaN for those that are driven.

        pieces: (n, 3) strip, index of the start, and index of the variant in `_DRIVEN`
        """
        wide, width = self.levels.shape[2], self.field.block_width
        levels, frame = (np.concatenate(list(values), axis=1) for values in (self.levels, self.frame))
        field = replace(self.field, levels=levels.astype(np.int16), frame=frame)
        side, turn = room * np.array(_DRIVEN)[pieces[:, 2]].T
        y = ((pieces[:, 0] + 0.5) * wide - levels.shape[1] / 2) * width + side * room_beside(body)
        ground = PaddedGround.of(field, outer_radius(body))
        lanes = drive_lanes(ground, body, starts[pieces[:, 1]], y, turn * _TURNED, _PIECE * width)
        ended, ends = np.flatnonzero(~lanes.passed), np.full(len(pieces), np.nan)
        ends[ended] = lanes.ends_of(ended, body)[0]
        return ends

    def _lower(self, strip: int, window: slice) -> None:
        """Make the largest step of the lane in a window of lines smaller by a unit, or its highest blocks lower.

        window: lines of cells along x, counted from the ground before the field
        """
        # The cells next to the lane stay. Frames are walls: no step to them counts, and none of them is lowered.
        inner = slice(1, -1)
        own, frame = self.levels[strip, :, inner], self.frame[strip, :, inner]
        padded, walls = np.pad(own, ((1, 1), (0, 0))), np.pad(frame, ((1, 1), (0, 0)))
        part, wall = padded[window], walls[window]
        largest = max(int((np.abs(np.diff(part, axis=axis)) * ~_either(wall, axis)).max(initial=0)) for axis in (0, 1))
        if largest > 1:
            lower = envelope(part, replace(self.field, levels=part.astype(np.int16), frame=wall), largest - 1)
            lower = np.minimum(part, lower)
        else:
            is_high = (part == part[~wall].max(initial=0)) & ~wall & (part > 0)
            at_front = is_high & (np.arange(len(part)) >= len(part) - _FRONT)[:, None]
            lower = part - (at_front if at_front.any() else is_high)
        padded[window] = np.maximum(lower, 0)
        self.levels[strip, :, inner] = np.where(frame, own, padded[1:-1])


def _either(mask: Mask, axis: int) -> Mask:
    """Return which pairs of neighbours along an axis have at least one cell in a mask."""
    first, second = (slice(-1), slice(1, None))
    return mask[first] | mask[second] if axis == 0 else mask[:, first] | mask[:, second]


def lane_cells(field: StepField, body: Body) -> Mask:
    """Return the cells of the straight lanes along x and y that a body drives, one more to each side, (n_x, n_y)."""
    lanes, aside = np.zeros(field.shape, bool), cells_to_each_side(field, body.width) + 1
    for axis in (0, 1):
        driven = driven_lanes(field, body, axis)
        line = int(driven[0] / field.block_width + field.shape[1 - axis] / 2) if len(driven) else 0
        beside = slice(max(line - aside, 0), line + aside + 1)
        lanes[(slice(None), beside) if axis == 0 else (beside, slice(None))] = True
    return lanes
