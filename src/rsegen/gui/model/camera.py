"""The camera pose from which the whole map is in view."""

from __future__ import annotations

import itertools

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.gui.model.bounds import Bounds

SOUTH_EAST: Array = np.array([0.45, -0.85, 0.75])
"""The default direction from the map to the camera."""

VIEW_ANGLE = 16.0
"""Degrees, from the lower to the upper rim; narrow, so that near blocks are hardly larger than far ones."""


def viewpoint(bounds: Bounds, direction: Array, *, margin: float, aspect: float) -> tuple[Array, Array]:
    """Position and focal point, from where bounds, widened by a margin, fill the view.

    aspect: width by height. With r and u across and up, f away from the camera, t the tangent of half the angle, a
    corner p is seen from the distance d where |p r| <= (d + p f) t aspect and |p u| <= (d + p f) t.
    """
    low, high = np.array(bounds[::2]), np.array(bounds[1::2])
    focus = (low + high) / 2
    widened = (low - focus) - (margin, margin, 0), (high - focus) + (margin, margin, 0)
    corners = np.array(
        [[widened[side][axis] for axis, side in enumerate(at)] for at in itertools.product((0, 1), repeat=3)]
    )
    back = direction / np.linalg.norm(direction)
    across = np.cross((0.0, 0.0, 1.0), back)
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-6 else np.array([1.0, 0.0, 0.0])
    up = np.cross(back, across)
    tangent = np.tan(np.radians(VIEW_ANGLE / 2))
    beside, above = np.abs(corners @ across) / (tangent * aspect), np.abs(corners @ up) / tangent
    distance = float(np.max(corners @ back + np.maximum(beside, above)))
    return focus + distance * back, focus
