"""Ways of a robot across a field, and the straight ones: how long and how steep they are, and where the robot falls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rsegen.field.stepfield import Array, StepField, make_read_only, read_only_copies
from rsegen.params.numbers import counted
from rsegen.standing.body import Body
from rsegen.standing.careful_lanes import safely_passed
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import (
    End,
    Lanes,
    across,
    entry_distance,
    steps_on,
    straight,
    straight_length,
    surely_passed,
)
from rsegen.standing.resting import Poses, has_stood, of_settled
from rsegen.standing.settling import Settled, joined, outer_radius, settle


@read_only_copies
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Way:
    """The best way of a robot across a field, between the level ground on two opposite sides.

    crosses: whether a way leads across
    length: metres, where a turn counts as the path of the robot's sides; length_ratio: to straight across
    tilt: the largest, and margin: the least turn that tips the robot over, radians, at the place margin_at, metres
    points: (k, 2), x and y of the robot's origin, metres, empty without a way
    drops, slips: the places where the robot falls, or slides by itself, metres; they do not end a way
    reason: without a way, what ends the straight lane that gets farthest; at: the place where it ends, metres
    """

    crosses: bool
    length: float | None
    length_ratio: float | None
    tilt: float | None
    margin: float | None
    points: Array
    margin_at: tuple[float, float] | None = None
    drops: tuple[tuple[float, float], ...] = ()
    slips: tuple[tuple[float, float], ...] = ()
    reason: str | None = None
    at: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        make_read_only(self.points)


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DrivenWay:
    """A way between two places, pose by pose.

    length: metres, where a turn counts as the path of the robot's sides
    drops, slips: indices of the poses at which the robot begins to fall, or to slide by itself
    """

    length: float
    poses: Poses
    drops: tuple[int, ...]
    slips: tuple[int, ...]


_STRAIGHT, _APART = 4, 8
"""Straight lanes that are driven together at first, and steps between the few poses of a lane that bound its tilt."""

_PLACES = 3
"""Places that a sentence names at most."""


def events(way: Any) -> list[str]:
    """Return sentences on the drops of a way, and on its slides; way: anything with `drops` and `slips`."""
    sentences = []
    for verb, at in (("drops", way.drops), ("slides", way.slips)):
        named = "; ".join(f"{x:.2f}, {y:.2f}" for x, y in at[:_PLACES])
        more = len(at) - _PLACES
        others = f" and {counted(more, 'other place')}" if more > 0 else ""
        if at:
            sentences.append(f"{verb} at {named} m{others}")
    return sentences


def worst_of(ground: PaddedGround, body: Body, lanes: Lanes, turned: Settled | None = None) -> dict[str, Any]:
    """Return the report of a way: the worst of its poses, and where the robot falls or slides."""
    rests = of_settled(ground, body, joined([turned, lanes.poses]) if turned else lanes.poses)
    least = int(rests.tip_angle.argmin())
    return {
        "tilt": float(rests.tilt.max()),
        "margin": float(rests.tip_angle[least]),
        "margin_at": (float(rests.x[least]), float(rests.y[least])),
        "drops": tuple(lanes.starts_of(lanes.drops, body)),
        "slips": tuple(lanes.starts_of(lanes.slips, body)),
    }


def straight_way(field: StepField, body: Body, axis: int, middles: Array | None = None) -> Way | None:
    """Return the straight way with the least tilt, with room to spare if a lane has it; None if no lane is driven.

    middles: of the lanes that may be driven, metres, by default of all
    """
    # A few poses of each lane bound its largest tilt from below. Lanes are driven in the order of these bounds, in
    # growing batches, until the best one that is driven tilts no more than any lane left can.
    middles = across(field, axis) if middles is None else middles
    passed, end = dict[int, Lanes](), 0
    narrow: Way | None = None
    bounds = _least_tilts(field, body, axis, middles)
    order = np.argsort(bounds, kind="stable")[: np.isfinite(bounds).sum()]
    while end < len(order):
        begin, end = end, max(2 * end, _STRAIGHT)
        batch, left = np.sort(order[begin:end]), bounds[order[end:]].min(initial=np.inf)
        lanes = straight(field, body, axis, middles[batch])
        passed |= {int(batch[m]): lanes.lane(m) for m in np.flatnonzero(lanes.passed).tolist()}
        while passed:
            best = min(passed, key=lambda m: (float(passed[m].tilt[0]), m))
            lane = passed[best]
            if lane.tilt[0] >= left:
                break
            # An answer is driven again, with poses that follow each other, to either side, and by a careful robot.
            middle = middles[best : best + 1]
            lane = straight(field, body, axis, middle, follows=True)
            if lane.passed.all() and surely_passed(lane, field, body, axis, middle).all():
                way = _way_along(lane, field, body, axis, float(middle[0]))
                if safely_passed(field, body, axis, middle).all():
                    return way
                narrow = narrow or way
            del passed[best]
    return narrow


def _least_tilts(field: StepField, body: Body, axis: int, middles: Array) -> Array:
    """Return a lower bound of the largest tilt on straight lanes, (L,), from some poses; infinite if one tips over."""
    length = straight_length(field, body, axis)
    steps = int(steps_on(body, length))
    along = np.arange(0, steps, _APART) * (length / steps) - entry_distance(field, body, axis)
    at: Array = np.array([np.tile(along, len(middles)), np.repeat(middles, len(along))])
    ground = PaddedGround.of(field, outer_radius(body))
    rest = settle(ground, body, at[axis], at[1 - axis], np.full(at.shape[1], axis * np.pi / 2))
    return np.asarray(np.where(has_stood(rest), rest.tilt, np.inf).reshape(len(middles), len(along)).max(axis=1))


def ends_across(field: StepField, body: Body, axis: int) -> tuple[float, float]:
    """Return where a way across begins and ends along an axis: before the field, and just behind it, metres."""
    return -entry_distance(field, body, axis), field.extent[axis] / 2 - float(body.low[0])


def _way_along(lane: Lanes, field: StepField, body: Body, axis: int, middle: float) -> Way:
    """Return the way along a straight lane across, at a place across [m]."""
    low, high = ends_across(field, body, axis)
    points = np.array([(low, middle), (high, middle)])
    return Way(
        crosses=True,
        length=high - low,
        length_ratio=1.0,
        points=points if axis == 0 else points[:, ::-1].copy(),
        **worst_of(PaddedGround.of(field, outer_radius(body)), body, lane),
    )


def lane_way(lanes: Lanes, number: int, field: StepField, body: Body) -> Way:
    """Return the way along the straight lane of a number from west to east, or what ends it."""
    if not lanes.passed[number]:
        return no_way(lanes, body, number)
    return _way_along(lanes.lane(number), field, body, 0, float(across(field, 0)[number]))


def no_way(lanes: Lanes, body: Body, number: int | None = None) -> Way:
    """Return what ends a straight lane, by default the one that gets farthest."""
    best = int(lanes.last.argmax()) if number is None else number
    x, y = lanes.ends_of(np.array([best]), body)
    return Way(
        crosses=False,
        length=None,
        length_ratio=None,
        tilt=None,
        margin=None,
        points=np.empty((0, 2)),
        reason=End(int(lanes.end[best])).words,
        at=(float(x[0]), float(y[0])),
    )
