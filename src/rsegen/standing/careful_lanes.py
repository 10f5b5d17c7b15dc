"""Lanes with room to spare: a careful robot drives them, with less momentum and friction, also a little to either side.

How careful it may be follows from blocks of one unit, over which it still has to get, side by side and as on a
chessboard.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.standing.body import Body
from rsegen.standing.lanes import straight

_CARE = ((0.3, 0.71, 0.71), (0.3, 1.0, 0.4), (0.3, 1.0, 1.0), (0.6, 1.0, 1.0), (1.0, 1.0, 1.0))
"""Shares of its kinetic energy, and of its friction along and across, with which a robot drives a lane with room to
spare, the most careful first. Of ways that spend 0.3 of the energy 8 of 8 were crossed in Gazebo Classic, of the others
16 of 40. With 0.71 of both frictions their pyramids are within the cones; wheels that slip forward have little across,
and a block under one of them turns the robot."""

_ROOM = 1 / 20
"""Share of a robot's width by which it is driven to either side of a lane with room to spare: blocks under one wheel
turn a robot, and it comes back."""


def careful(field: StepField, body: Body, room: float = 1.0) -> Body | None:
    """Return a robot with the least momentum and friction with which it drives over blocks of one unit.

    A lane has room to spare if that robot drives it. It still gets over a few blocks side by side, and over every other
    one, as on a chessboard, if the robot does so at all. None if no such robot climbs blocks side by side, or only one
    with more momentum than it keeps when its wheels hit a block.

    room: share of the usual room to spare; with 0 the robot has all its momentum and friction
    """
    places = room_beside(body) * room * np.array([-1.0, 0.0, 1.0])
    most = max(_energy_left(body, field.unit), _CARE[0][0])
    robots = [_with_less(body, room, *shares) for shares in _CARE if shares[0] <= most]

    def first(ground: StepField) -> int | None:
        passed = (index for index, robot in enumerate(robots) if straight(ground, robot, 0, places).passed.all())
        return next(passed, None)

    together = first(_small_field(field, body, is_rough=False))
    if together is None:
        return None
    # Robots are in the order of less and less care. If none gets over the chessboard, blocks side by side decide alone.
    return robots[max(together, first(_small_field(field, body, is_rough=True)) or 0)]


def _energy_left(body: Body, height: float) -> float:
    """Return the share of its kinetic energy that a robot keeps when its wheels hit an edge of some height, metres.

    The hit is inelastic: a wheel of radius r turns on about an edge of height h. Of its velocity the part across the
    line from the edge to the axle is left, (1 - h / r) v; the factor is the downward part of the normal at that height.
    """
    ahead = body.drives & (body.normals[:, 0] > 0)
    above = body.points[:, 2] - body.low[2]
    if not ahead.any() or height > above[ahead].max():
        return 0.0
    at = np.abs(above[ahead] - height).argmin()
    return float(body.normals[ahead][at, 2] ** 2)


def _with_less(body: Body, room: float, *shares: float) -> Body:
    """Return a robot with shares of its kinetic energy, and of its friction along and across; larger for less room."""
    energy, along, across = (1 - room + room * share for share in shares)
    parts = tuple(
        part._replace(mu=part.mu * along, mu2=part.mu2 * across) if part.drives else part for part in body.parts
    )
    return replace(body, speed=body.speed * energy**0.5, parts=parts)


def _small_field(field: StepField, body: Body, *, is_rough: bool) -> StepField:
    """Return a field a little larger than a robot, of blocks of one unit, or of every other one."""
    shape = [int(np.ceil(size / field.block_width)) + 2 for size in (body.length, body.width)]
    levels = np.indices(shape).sum(axis=0) % 2 if is_rough else np.ones(shape)
    return replace(field, levels=levels.astype(np.int16), frame=np.zeros(shape, bool))


def room_beside(body: Body) -> float:
    """Return how far to either side a lane with room to spare is driven, metres."""
    return _ROOM * body.width


def safely_passed(field: StepField, body: Body, axis: int, middles: Array, room: float = 1.0) -> Mask:
    """Return which lanes at places across, metres, are driven with room to spare; room: as in `careful`."""
    places = middles + room_beside(body) * room * np.array([[0.0], [-1.0], [1.0]])
    robot = careful(field, body, room) or _with_less(body, room, *_CARE[0])
    passed = straight(field, robot, axis, places.ravel()).passed
    return np.asarray(passed.reshape(3, -1).all(axis=0))
