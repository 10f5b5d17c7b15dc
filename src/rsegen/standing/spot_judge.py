"""The conditions on a place at which a robot starts: level, firm, on its feet alone, and able to drive away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from enum import IntEnum
from math import degrees, pi, tan

import numpy as np

from rsegen.field.stepfield import Array, Ints, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.lanes import drive_lanes
from rsegen.standing.outlines import EXACT, Spot
from rsegen.standing.pushing import TOUCHING, sample_heights
from rsegen.standing.resting import GRAVITY, Poses, has_stood, of_settled
from rsegen.standing.settling import Settled, outer_radius, settle
from rsegen.standing.stance import stance_on

_SPARE = 0.002
"""Metres that stay free below all that does not bear the robot on level ground: a TurtleBot3's wheel sinks 1 mm into
the floor in Gazebo Classic (decision 8)."""

_FIRM = 0.5
"""Share of its angle to tip over on level ground that a robot must have left, at a spot, and on the lane from it: it
starts and stops there."""

_FEW = 3
"""Feet that are looked at first: on rough ground they differ already."""

_BINS = 8
"""Squares along a robot of which the lowest point is looked at first."""

_LANE = 1.25
"""Lengths of a robot that it drives away: its own, and some more, as it must not stop on a brink."""

_LOOKS = 4
"""Poses on a lane that are looked at before it is driven in small steps: steep ones need no more."""

_ROOM = tuple((lengths, turn * pi / 8) for lengths in (1, 2) for turn in (-1, 0, 1))
"""Lanes of these lengths of a robot, and turned to a side, are looked at for level ground: robots also steer, and where
there is more room they go farther before something happens."""


class Fault(IntEnum):
    """Reason why a place is no spot, in the order of the checks."""

    TIPS = 0
    TILTS = 1
    FRAME = 2
    HANGS = 3
    UNSTEADY = 4
    STUCK = 5
    CAUGHT = 6
    NONE = 7

    def reason(self, tilt: float, tip_angle: float) -> str:
        """Return it in words that follow "there it"; angles in degrees."""
        return (
            "tips over",
            f"tilts by {tilt:.3g} degrees",
            "stands on a frame",
            "touches a block with more than it stands on",
            f"tips over as soon as it is turned by {tip_angle:.2g} degrees",
            "cannot push itself on",
            "cannot drive away: a little more than its length ahead it would fall, tip over or be stopped",
            "",
        )[self]


Place = tuple[Fault, Spot]
At = tuple[Array, Array, Array]
"""x, y [m] and yaw [rad] of n robots."""


def some(at: At, chosen: Ints | Mask | slice) -> At:
    """Return some of the robots."""
    x, y, yaw = (values[chosen] for values in at)
    return x, y, yaw


class SpotJudge:
    """The conditions on a place on a field, for one body.

    feet: (k, 2), its outermost contacts on level ground, about its origin, metres; coarse: (m, 3), its lowest points
    lowest, highest: heights of all cells that it may be above at each place; sunk: its depth in level ground, metres
    hanging: the samples that must touch nothing; level: the largest unevenness at a spot, metres
    lane, steep, fall: length of a lane, metres, the largest tilt on it, radians, and the highest fall in a step, metres
    """

    def __init__(self, field: StepField, body: Body, most_tilt: float) -> None:
        self.field, self.body, self.most_tilt = field, body, most_tilt
        self.lane = _LANE * body.length
        self.ground = PaddedGround.of(field, outer_radius(body) + self.lane)
        frame = np.pad(field.frame, self.ground.border).ravel()
        self.blocks = replace(self.ground, heights=np.where(frame, np.nan, self.ground.heights))
        # All else follows from how it stands on level ground.
        stance = stance_on(self.ground, body)
        pose = stance.pose
        self.feet = np.unique(np.nan_to_num(pose.support[0, :, :2]), axis=0)
        self.level = tan(most_tilt) * float(np.ptp(self.feet, axis=0).max()) + TOUCHING
        self.coarse = _coarse(body, max(field.block_width / 2, body.length / _BINS))
        self.hanging = np.flatnonzero(~body.drives & ~stance.bearing[body.part])
        self.sunk = max(-float(self.coarse[:, 2].min()), 0.0)
        cells = int(np.ceil(np.linalg.norm(body.points[:, :2], axis=1).max() / field.block_width)) + 1
        self.lowest, self.highest = (_extreme(self.blocks, cells, best) for best in (np.minimum, np.maximum))
        self.steep = _FIRM * float(pose.tip_angle[0])
        self.fall = float(pose.tip_energy[0]) / (body.mass * GRAVITY)

    def is_level(self, at: At, along: Sequence[float] | Array = (0.0,), turn: float = 0.0) -> Mask:
        """Return where the ground is level below the feet, nowhere too high, at places and `along` ahead of them, (n,).

        False with a foot on a frame; turn: to which side ahead is, radians. Few look-ups decide most places: level
        for sure if all cells around are, and not level if the feet differ.
        """
        # Cheapest first: the cells around, some feet, all feet; each only for the places that the last one left open.
        around = np.zeros((1, 2))
        low, high = (self._below(ground, around, at, along, turn) for ground in (self.lowest, self.highest))
        level = np.asarray(high.max(axis=1) - low.min(axis=1) + self.sunk <= self.level)
        (rest,) = np.nonzero(~level)
        for points in (self.feet[:: max(len(self.feet) // _FEW, 1)], self.feet):
            feet = self._below(self.blocks, points, some(at, rest), along, turn)
            differs = np.ptp(feet, axis=1)
            even = differs <= self.level
            rest, feet, differs = rest[even], feet[even], differs[even]
        over = self._below(self.ground, self.coarse, some(at, rest), along, turn) - np.tile(
            self.coarse[:, 2], len(along)
        )
        level[rest] = differs + np.maximum(over.max(axis=1) - feet.max(axis=1), 0.0) <= self.level
        return level

    def _below(self, ground: PaddedGround, points: Array, at: At, along: Sequence[float] | Array, turn: float) -> Array:
        """Return the heights of the ground below points of the robot at places, and so far ahead, (n, k points)."""
        x, y, yaw = (values[:, None] for values in at)
        c, s = np.cos(yaw + turn), np.sin(yaw + turn)
        ahead, aside = np.add.outer(np.asarray(along), points[:, 0]).ravel(), np.tile(points[:, 1], len(along))
        return np.asarray(ground.below(x + c * ahead - s * aside, y + s * ahead + c * aside))

    def level_lanes(self, at: At) -> Ints:
        """Return on how many of some lanes ahead the ground is level, for each place, (n,)."""
        room = np.zeros(len(at[0]), np.intp)
        for lengths, turn in _ROOM:
            room += self.is_level(at, np.linspace(0, lengths * self.lane, _LOOKS * lengths + 1), turn)
        return room

    def least_uneven(self, at: At) -> Ints:
        """Return all places, those first with even ground below the feet."""
        differs = np.ptp(self._below(self.blocks, self.feet, at, (0.0,), 0.0), axis=1)
        return np.argsort(differs, kind="stable")

    def put_down(self, at: At) -> Iterator[Place]:
        """Yield how a robot rests at each place, and what is wrong about standing there."""
        rest = settle(self.ground, self.body, *at)
        poses = of_settled(self.ground, self.body, rest)
        _, above = sample_heights(self.ground, self.body, rest, np.arange(len(rest.x)))
        wrong = {
            Fault.TIPS: ~has_stood(rest),
            Fault.TILTS: poses.tilt > self.most_tilt + EXACT,
            Fault.FRAME: self._on_frame(poses),
            Fault.HANGS: above[:, self.hanging].min(axis=1, initial=np.inf) < _SPARE,
            Fault.UNSTEADY: poses.tip_angle < self.steep,
            Fault.STUCK: ~poses.pushes,
        }
        faults = np.select(list(wrong.values()), list(wrong), Fault.NONE)
        (left,) = np.nonzero(faults == Fault.NONE)
        faults[left[~self._is_open(some(at, left))]] = Fault.CAUGHT
        columns = (poses.x, poses.y, poses.z, poses.yaw, poses.roll, poses.pitch, poses.tilt, poses.tip_angle)
        for fault, row in zip(faults.tolist(), np.round(np.stack(columns, axis=1), 6) + 0.0, strict=True):
            yield _place(Fault(fault), row.tolist())

    def _on_frame(self, poses: Poses) -> Mask:
        corners = np.nan_to_num(poses.support[..., :2])
        cells = np.floor(corners / self.field.block_width + np.array(self.field.shape) / 2).astype(np.intp)
        i, j = (np.clip(cells[..., axis], 0, self.field.shape[axis] - 1) for axis in (0, 1))
        return np.asarray(self.field.frame[i, j].any(axis=1))

    def _is_open(self, at: At) -> Mask:
        """Return from which places the robot is nowhere steep at a few poses of the lane ahead."""
        x, y, yaw = (np.repeat(values, _LOOKS) for values in at)
        along = np.tile(np.arange(1, _LOOKS + 1) * self.lane / _LOOKS, len(at[0]))
        looks = settle(self.ground, self.body, x + np.cos(yaw) * along, y + np.sin(yaw) * along, yaw)
        return np.asarray(~self._is_steep(looks).reshape(-1, _LOOKS).any(axis=1))

    def left(self, place: Spot) -> Spot | None:
        """Return the spot of a place, if a lane ahead is driven to its end from there, never steep, without a fall.

        It is put down once more, where it rests: a place at the very edge of a block is none, and of two ways to stand
        there the spot has the one in which it stands then.
        """
        at = np.array([place.x]), np.array([place.y]), np.array([place.yaw])
        ((fault, rest),) = self.put_down(at)
        # Only from where it still rests as a spot must is a lane driven, the dearest of the checks.
        if fault is not Fault.NONE:
            return None
        lanes = drive_lanes(self.ground, self.body, *at, self.lane)
        fall = -np.diff(lanes.poses.z).min(initial=0.0)
        is_left = lanes.passed[0] and not self._is_steep(lanes.poses).any() and fall <= self.fall
        return replace(rest, x=place.x, y=place.y, yaw=place.yaw) if is_left else None

    def _is_steep(self, rest: Settled) -> Mask:
        return np.asarray(~has_stood(rest) | (rest.tilt > self.steep))


def _extreme(ground: PaddedGround, cells: int, best: np.ufunc) -> PaddedGround:
    """Return the least or largest height of the cells around each, up to `cells` away; NaN where one is on a frame."""
    heights = ground.heights.reshape(ground.shape)
    for axis in range(2):
        padded = np.pad(heights, [(cells, cells) if axis == side else (0, 0) for side in range(2)])
        heights = best.reduce(np.lib.stride_tricks.sliding_window_view(padded, 2 * cells + 1, axis=axis), axis=-1)
    return replace(ground, heights=heights.ravel())


def _coarse(body: Body, width: float) -> Array:
    """Return the lowest sample of a body in each square of a width, (m, 3), metres."""
    lowest_first = body.points[np.argsort(body.points[:, 2], kind="stable")]
    _, first = np.unique(np.floor(lowest_first[:, :2] / width), axis=0, return_index=True)
    return lowest_first[first]


def _place(fault: Fault, row: Sequence[float]) -> Place:
    x, y, z, yaw, roll, pitch, tilt, tip_angle = row
    reason = fault.reason(degrees(tilt), degrees(tip_angle))
    return fault, Spot(x=x, y=y, z=z, yaw=yaw, roll=roll, pitch=pitch, tilt=tilt, tip_angle=tip_angle, reason=reason)
