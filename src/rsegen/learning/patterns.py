"""Patterns of points around a robot, in its frame, at which the ground under it is scanned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.params.sorts import Float, ListOf

_SIDES, _DISTANCE = ListOf(Float(0, 1000, unit="m"), 2), Float(0.001, 1000, unit="m")


def scan_points(size: Sequence[float] | Array = (1.6, 1.0), distance: float = 0.1) -> Array:
    """Return a grid of points around a robot, x first, by default as in legged_gym: 17 x 11 points.

    Parameters
    ----------
    size : sequence of float, default (1.6, 1.0)
        Length and width of the grid, metres.
    distance : float, default 0.1
        Distance of the points, metres: the nearest one that divides each side.

    Returns
    -------
    ndarray, shape (points, 2)
        x and y of each point, metres, in the frame of the robot.
    """
    sides, distance = sides_of(size), _DISTANCE.check("distance", distance)
    x, y = (np.linspace(-side / 2, side / 2, round(side / distance) + 1) for side in sides)
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


def check_pattern(pattern: Any) -> None:
    """Raise a ParameterError unless an array has x and y of points: (points, 2)."""
    if pattern.ndim != 2 or pattern.shape[1] != 2:
        raise ParameterError("pattern", f"of shape {tuple(pattern.shape)}; expected (points, 2)")


def sides_of(size: Sequence[float] | Array) -> Any:
    """Return the length and width of a rectangle around a robot, metres; ParameterError if they are none."""
    return _SIDES.check("size", size.tolist() if isinstance(size, np.ndarray) else size)
