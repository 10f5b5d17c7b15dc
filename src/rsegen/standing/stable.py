"""All poses in which a robot may rest at a place: which one it takes depends on how it got there.

A robot on four wheels stands on three of them and rocks onto another three at a push, or stands level on two opposite
ones, if these are wide. So it is put down level and tilted to all sides, and settles from each tilt (settling.py);
poses that a simulator would not tell apart count as one. Cost: seventeen times one pose, one for each tilt. What breaks
it: a pose so narrow that none of the tilts leads to it, and a part against the side of a block, with which a pose is
never still.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rsegen.field.stepfield import Array, Ints, StepField
from rsegen.standing.body import Body
from rsegen.standing.ground import PaddedGround
from rsegen.standing.resting import Poses, has_stood, of_settled, places
from rsegen.standing.settling import Settled, centre_at, outer_radius, settle_from

_SLOPES, _SIDES = (0.2, 0.4), 8
"""Slopes at which a robot is put down, besides level, and number of sides: 11 and 22 degrees, about as steep as a robot
stands on blocks that it can climb."""

APART = (0.005, 1.5)
"""Metres of height, and degrees of orientation, from which on two poses are not the same."""

_STILL = 1e-3
"""Turn in the last round, as a slope, below which a pose is at rest."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class StablePoses:
    """All poses in which a robot may rest at each of n places.

    Attributes
    ----------
    poses : Poses
        All of them, m, in the order of the places; at each place the lowest centre of mass comes first.
    place : ndarray of int, shape (m,)
        The number of the place of each pose.
    count : ndarray of int, shape (n,)
        Number of poses at each place: 0 where the robot tips over however it is put down.
    level : Poses
        The pose at each place that it takes when it is put down level, n of them, as `rsegen.poses` returns them.
    """

    poses: Poses
    place: Ints
    count: Ints
    level: Poses


def stable_poses(field: StepField, body: Body, x: ArrayLike, y: ArrayLike, heading: ArrayLike) -> StablePoses:
    """Return all poses in which a robot may rest at each x, y [m] and heading [rad], as in `resting_poses`."""
    at_x, at_y, yaw = places(field, body, x, y, heading)
    ground = PaddedGround.of(field, outer_radius(body))
    stable = stable_at(ground, body, *centre_at(body, at_x, at_y, yaw), yaw)
    poses, level = (of_settled(ground, body, rests) for rests in (stable.rests, stable.level))
    return StablePoses(poses=poses, place=stable.place, count=stable.counts, level=level)


class StableRests(NamedTuple):
    """All rests at n places, m of them; the place of each, their counts, and the rest of a robot put down level."""

    rests: Settled
    place: Ints
    counts: Ints
    level: Settled


def stable_at(ground: PaddedGround, body: Body, x: Array, y: Array, yaw: Array) -> StableRests:
    """Return all rests with the centre of mass at x, y [m] and a heading, (n,) each."""
    level = np.zeros((len(x), 1, 2))
    starts = np.concatenate([level, *(slope * _sides(yaw) for slope in _SLOPES)], axis=1)
    count, tilts = starts.shape[:2]
    at_x, at_y, heading = (np.repeat(of_place, tilts) for of_place in (x, y, yaw))
    rest = settle_from(ground, body, at_x, at_y, heading, starts.reshape(-1, 2))
    stands = has_stood(rest).reshape(count, tilts)
    is_stable = stands & (rest.turn.reshape(count, tilts) < _STILL)
    is_stable[:, 0] |= stands[:, 0] & ~is_stable.any(axis=1)  # where none is still, the one that was put down level
    # From here on a row for each tilt, the lowest rest of each place first: of equal poses that one stays.
    order = np.argsort(np.where(is_stable, rest.z.reshape(count, tilts), np.inf), axis=1, kind="stable")
    rows = (np.arange(count)[:, None] * tilts + order).T
    is_own, height, upright = is_stable.ravel()[rows], rest.z[rows], rest.axes[rows, :, 2]
    for later in range(1, tilts):
        is_near = np.abs(height[:later] - height[later]) <= APART[0]
        is_alike = np.einsum("kni,ni->kn", upright[:later], upright[later]) >= np.cos(np.radians(APART[1]))
        is_own[later] &= ~(is_own[:later] & is_near & is_alike).any(axis=0)
    rows = rows.T[is_own.T]
    level_rest = rest.some(np.arange(count) * tilts)
    return StableRests(rest.some(rows), rows // tilts, is_own.sum(axis=0), level_rest)


def _sides(yaw: Array) -> Array:
    """Return the horizontal directions to all sides of robots with headings [rad], (n, sides, 2)."""
    angles = yaw[:, None] + np.arange(_SIDES) * 2 * np.pi / _SIDES
    return np.stack([np.cos(angles), np.sin(angles)], axis=2)
