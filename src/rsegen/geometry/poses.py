"""Poses and rotations as matrices: from roll, pitch and yaw, as in SDF and URDF, and back."""

from __future__ import annotations

from math import atan2, hypot

import numpy as np
from numpy.typing import ArrayLike

from rsegen.field.stepfield import Array


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Return the matrix (3, 3) of a rotation about x, then y, then z, radians."""
    (a, b, c), (p, q, r) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, a, -p], [0, p, a]])
    about_y = np.array([[b, 0, q], [0, 1, 0], [-q, 0, b]])
    about_z = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def pose_matrix(place: ArrayLike, turn: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1))) -> Array:
    """Return the pose (4, 4) of a frame that is at a place, (3,), metres, and turned by a rotation, (3, 3)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, place
    return pose


_TURNED_UP = 1e-9
"""Cosine of the pitch below which roll and yaw turn about one axis: the yaw is then 0."""


def angles(turn: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw, radians, of a matrix (3, 3) of a rotation: the inverse of `rotation`."""
    level = hypot(turn[0, 0], turn[1, 0])
    if level > _TURNED_UP:
        roll, yaw = atan2(turn[2, 1], turn[2, 2]), atan2(turn[1, 0], turn[0, 0])
    else:
        roll, yaw = atan2(-turn[1, 2], turn[1, 1]), 0.0
    return roll, atan2(-turn[2, 0], level), yaw


def turn_about(axis: tuple[float, float, float], angle: float) -> Array:
    """Return the matrix (3, 3) of a turn about a unit axis, radians (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
