"""The belts of tracks: the surface of a shape moves although the shape does not, and friction takes the difference.

The velocity of a belt at a contact is added to the slip that friction is to stop. MuJoCo 4.0 has a `surfacevel` for
that, but adds it in the frame that a contact had before it was turned along the belt (`_Shapes.turn`), so a robot on
tracks that headed north was driven east. Cost: some arrays as long as the contacts. What breaks it: nothing known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from rsegen.field.stepfield import Array
from rsegen.mujoco.robot_model import RobotModel
from rsegen.mujoco.sliding import TANGENTS


class Belts:
    """The belts of all robots, and the speeds at which they run."""

    def __init__(self, model: Any, robots: Sequence[RobotModel]) -> None:
        belts = [
            (number, shape, model.geom(shape.name).id)
            for number, robot in enumerate(robots)
            for shape in robot.shapes
            if shape.surface is not None
        ]
        self._owner = np.array([(number, shape.belt) for number, shape, _ in belts], dtype=int).reshape(-1, 2)
        self._geoms = np.array([geom for *_, geom in belts], dtype=int)
        self._at_one = np.array(
            [_in_geom(model, geom, shape.surface) for _, shape, geom in belts if shape.surface is not None]
        ).reshape(-1, 2, 3)
        self._velocities = np.zeros((model.ngeom, 2, 3))
        self._is_belt = np.zeros(model.ngeom, dtype=bool)
        self._is_belt[self._geoms] = True
        self.any = bool(belts)

    def command(self, robot: int, left: float, right: float) -> None:
        """Set the speeds of a robot's belts, m/s."""
        own = self._owner[:, 0] == robot
        speeds = np.where(self._owner[own, 1] == 0, left, right)
        self._velocities[self._geoms[own]] = self._at_one[own] * speeds[:, None, None]

    def move(self, data: Any) -> None:
        """Add the velocities of belts to the references of their contacts, after MuJoCo has made the constraints."""
        contact = data.contact
        geoms, first = contact.geom, contact.efc_address
        are_belts = self._is_belt[geoms] & (first >= 0)[:, None]
        for side, sign in ((0, -1.0), (1, 1.0)):  # the slip is that of the second shape relative to the first
            rows = are_belts[:, side].nonzero()[0]
            if not len(rows):
                continue
            own = geoms[rows, side]
            turns = data.geom_xmat[own].reshape(-1, 3, 3)
            linear, angular = (turns @ self._velocities[own].swapaxes(1, 2)).transpose(2, 0, 1)
            velocity = linear + cross(angular, contact.pos[rows] - data.geom_xpos[own])
            slip = (contact.frame[rows].reshape(-1, 3, 3)[:, 1:] @ velocity[:, :, None])[:, :, 0]
            tangents = first[rows][:, None] + TANGENTS
            data.efc_aref[tangents] -= sign * data.efc_KBIP[tangents, 1] * slip


def cross(a: Array, b: Array) -> Array:
    """Return the cross products of rows; numpy's own takes ten times as long for a few."""
    return a[:, (1, 2, 0)] * b[:, (2, 0, 1)] - a[:, (2, 0, 1)] * b[:, (1, 2, 0)]


def _in_geom(model: Any, geom: int, surface: Array) -> Array:
    """Return a velocity, linear and angular, of the frame of a link in that of a shape as it was compiled, (2, 3)."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return surface.reshape(2, 3) @ turn.reshape(3, 3)
