"""Rotations as SDF gives them."""

from __future__ import annotations

import numpy as np

from rsegen.field.stepfield import Array


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """The matrix (3, 3) of a rotation about x, then y, then z, radians."""
    (a, b, c), (p, q, r) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, a, -p], [0, p, a]])
    about_y = np.array([[b, 0, q], [0, 1, 0], [-q, 0, b]])
    about_z = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)
