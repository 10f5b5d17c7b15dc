"""A picture of what a robot is: its visual shapes, and next to them its collision shapes, which alone touch the blocks.

Both halves are seen by one camera, from the front and the right, on the ground on which its lowest collision shape
stands. A ruler lies there, in the middle of which the robot stands. Joints are as its model has them.
"""

from __future__ import annotations

import os
from math import ceil, hypot, log10, sin
from typing import TYPE_CHECKING, Literal

import numpy as np

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.params.numbers import decimal
from rsegen.pictures.camera import Camera, Pixels, Triangles, View
from rsegen.pictures.preview import encoded, figure_of
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.robots.visuals import Known, PlacedShapes, Visual, placed_shapes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HALVES: tuple[Literal["visual"], Literal["collision"]] = ("visual", "collision")

_SIDE = 900
"""Pixels along a side of a half before what is empty above and below the robot is cut off."""

_PITCH, _YAW = 0.35, 2.3
"""Radians by which the camera looks down, and its heading: from the front and the right of the robot."""

_VIEW = 0.6
"""Horizontal angle that it sees, radians: so narrow that near and far parts are nearly of one size."""

_ROOM = 1.08
"""Share of the robot's half diagonal, with its ruler, that is seen around its middle."""

_MARGIN = 12
"""Pixels above and below what is seen."""

_GROUND = (0.86, 0.86, 0.86)
_MARKS = ((0.15, 0.15, 0.15), (1.0, 1.0, 1.0))
"""Colours of the ground, and of the parts of the ruler in turn."""

_FEWEST = 4
"""Parts along the robot, at least: more than twice as many are never needed."""


def robot_picture(robot: str | os.PathLike[str] | DrivableRobot, format: str = "png") -> bytes:  # noqa: A002  # matplotlib's word
    """Draw the visual shapes of a robot next to its collision shapes; only these touch blocks.

    Parameters
    ----------
    robot : str, path or robot
        A kind, the file of one, or a robot.
    format : {'png', 'svg', 'pdf', 'jpg', 'webp'}, default 'png'
        Format of the file.

    Returns
    -------
    bytes
        The image file.

    Raises
    ------
    ParameterError
        If it has neither visual nor collision shapes that can be drawn.
    """
    return picture_and_gaps(robot_of(robot), format)[0]


def picture_and_gaps(robot: DrivableRobot, format: str) -> tuple[bytes, list[str]]:  # noqa: A002  # matplotlib's word
    """Return the picture as the bytes of an image file, and a sentence for each file or kind that is not in it."""
    known: Known = {}  # a mesh is often both
    halves = {half: placed_shapes(robot, half, known) for half in _HALVES}
    points = [shape.points[shape.corners].reshape(-1, 3) for half in halves.values() for shape in half.shapes]
    if not any(map(len, points)):
        raise ParameterError(robot.kind, "has no shapes that can be drawn")
    # One camera sees the shapes of both halves and the ruler, and rows that are empty in both are cut off.
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    step = _step(float(high[0] - low[0]))
    ruler = _ruler(low, high, step)
    camera = _camera(np.concatenate([every, ruler.corners.reshape(-1, 3)]))
    rows = _rows(camera, [every, ruler.corners.reshape(-1, 3)])
    figure = figure_of(15, 7.2 * (rows.stop - rows.start) / _SIDE + 1.2, 3, 9)
    for axes, (half, drawn) in zip(figure.subplots(1, 2), halves.items(), strict=True):
        axes.imshow(_drawn(drawn.shapes, ruler, camera)[rows])
        axes.set(xticks=[], yticks=[], title=f"{half}: {_in_words(drawn)}")
        _label_ruler(axes, camera, ruler, step, rows.start)
    figure.suptitle(robot.kind)
    gaps = [
        f"not in the picture, of the {half} of {', '.join(dict.fromkeys(links))}: {why}"
        for half, drawn in halves.items()
        for why, links in drawn.not_drawn.items()
    ]
    return encoded(figure, format), gaps


def _in_words(drawn: PlacedShapes) -> str:
    """Return how many shapes are drawn and how large they are together, and how many are not."""
    missing = sum(map(len, drawn.not_drawn.values()))
    points = [shape.points[shape.corners].reshape(-1, 3) for shape in drawn.shapes if len(shape.corners)]
    left_out = f", {missing} not drawn" if missing else ""
    if not points:
        return f"none{left_out}"
    every = np.concatenate(points)
    size = " x ".join(f"{side:.3f}" for side in np.ptp(every, axis=0))
    return f"{len(points)} shapes, {size} m, lowest at {every[:, 2].min():.3f} m{left_out}".replace("-0.000", "0.000")


def _drawn(shapes: list[Visual], ruler: Triangles, camera: Camera) -> Pixels:
    triangles = Triangles.joined([ruler, *(shape.triangles for shape in shapes)])
    radius = float(np.linalg.norm(triangles.corners, axis=-1).max())
    return View(camera, triangles, radius, _GROUND).picture(Triangles.joined([]))


def _step(length: float) -> float:
    """Return the length of a part of the ruler, 1, 2 or 5 times a power of ten, metres."""
    most = max(length, 1e-3) / _FEWEST
    power = 10.0 ** np.floor(log10(most))
    return float(max(times * power for times in (1, 2, 5) if times * power <= most * (1 + 1e-9)))


def _ruler(low: Array, high: Array, step: float) -> Triangles:
    """Return the ruler: squares of the ground along x, in front of a box as the camera sees it."""
    count = ceil((high[0] - low[0]) / step - 1e-9)
    width, start = step / 4, (low[0] + high[0] - count * step) / 2
    y, z = low[1] - 2 * width, hypot(*(high - low)[:2]) / 1000  # above the ground, which would hide it
    x = start + step * np.arange(count + 1)
    left, right = x[:-1, None], x[1:, None]
    flat = np.full_like(left, 1.0)
    corners = [
        np.concatenate([at_x, at_y * flat, z * flat], axis=1)
        for at_x, at_y in ((left, y - width), (right, y - width), (right, y), (left, y))
    ]
    triangles = np.stack(corners, axis=1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    return Triangles(triangles, np.array([_MARKS[part % 2] for part in range(count)]).repeat(2, axis=0))


def _camera(points: Array) -> Camera:
    """Return a camera that sees all points, (n, 3)."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    # From this distance the ball around all points just fills the angle of view.
    away = _ROOM * float(np.linalg.norm(points - middle, axis=1).max()) / sin(_VIEW / 2)
    toward = np.array([np.cos(_PITCH) * np.cos(_YAW), np.cos(_PITCH) * np.sin(_YAW), -np.sin(_PITCH)])
    x, y, z = (middle - away * toward).tolist()
    return Camera(place=(x, y, z), pitch=_PITCH, yaw=_YAW, view=_VIEW, pixels=(_SIDE, _SIDE))


def _rows(camera: Camera, parts: list[Array]) -> slice:
    """Return the rows of the picture that are not empty."""
    rows = camera.projected(np.concatenate(parts))[:, 1]
    low, end = (int(np.clip(row, 0, _SIDE)) for row in (rows.min() - _MARGIN, rows.max() + _MARGIN))
    return slice(low, end)


def _label_ruler(axes: Axes, camera: Camera, ruler: Triangles, step: float, first: int) -> None:
    """Write how long a part of the ruler is, below its middle."""
    x, y, _ = camera.projected(ruler.corners.reshape(-1, 3)).mean(axis=0)
    style = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    axes.text(x, y - first + 0.03 * _SIDE, f"a part is {decimal(step)} m", ha="center", va="top", bbox=style)
