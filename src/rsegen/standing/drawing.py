"""A robot as it settled, drawn on the plan of a map and in its 3D view: the outline of each of its parts.

The outline of a part is the convex hull of its samples as they are seen, too large for a mesh that is not convex. In
the view the robot is between the blocks behind it and those in front of it. What breaks it: a block next to the robot,
within the rectangle along the axes around it, counts as behind it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from rsegen.field.stepfield import Array, Mask, StepField
from rsegen.geometry.poses import rotation
from rsegen.standing.body import Body
from rsegen.standing.resting import REASONS, Poses

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DRIVEN, _UNDRIVEN = "#00a3ff", "#ff2d95"
"""Colours of outlines, which no level and no map has."""


@dataclass(frozen=True, kw_only=True, slots=True)
class RobotDrawing:
    """A robot at rest at one place in one of its stable poses, for a picture of a map (`pictures/preview.py`)."""

    body: Body
    rests: Poses
    stable: int

    def draw(self, plan: Axes) -> None:
        """Draw the robot on a plan."""
        draw_robot(plan, self.body, self.rests)

    def in_front(self, field: StepField) -> Mask:
        """Return which cells of a field are east or south of it, so in front of it as seen from there, (n_x, n_y)."""
        placed = _placed(self.body, self.rests)
        east, south = placed[:, 0].max(), placed[:, 1].min()
        edges_x, edges_y = field.edges()
        return np.asarray(np.logical_or.outer(edges_x[:-1] > east, edges_y[1:] < south))

    def silhouettes(
        self, project: Callable[[Array, Array, Array], Array], toward: Array
    ) -> Iterator[tuple[Array, str]]:
        """Yield outline and colour of each part in a view, the farthest first.

        project: from x, y, z to the plane of the picture, (n, 2); toward: the direction to the viewer, (3,)
        """
        parts = self.body.by_part(_placed(self.body, self.rests))
        for index in np.argsort([float((part @ toward).mean()) for part in parts], kind="stable"):
            yield hull(project(*parts[index].T)), _DRIVEN if self.body.parts[index].drives else _UNDRIVEN

    def describe(self) -> str:
        """Return a sentence on how the robot stands."""
        reason = REASONS[int(self.rests.reason[0])]
        if not self.rests.stands[0]:
            return f"the robot {reason}"
        tilt, margin = (degrees(float(angles[0])) for angles in (self.rests.tilt, self.rests.tip_angle))
        weakness = f", and {reason}" if reason else ""
        others = f"; one of {self.stable} stable poses" if self.stable > 1 else ""
        return f"the robot tilts by {tilt:.1f} degrees, {margin:.0f} degrees from tipping over{weakness}{others}"


def draw_robot(axes: Axes, body: Body, rests: Poses, index: int = 0) -> None:
    """Draw the outlines of a robot's parts at one of its poses, driven ones in another colour, and an arrow forward."""
    turned, at = axes_of(rests, index), np.array([rests.x[index], rests.y[index]])
    for part, known in enumerate(body.parts):
        own = body.points[body.part == part]
        if len(own):
            outline = hull((own @ turned.T)[:, :2] + at)
            colour = _DRIVEN if known.drives else _UNDRIVEN
            axes.fill(*outline.T, facecolor=(colour, 0.25), edgecolor="white", linewidth=2.6)
            axes.fill(*outline.T, facecolor="none", edgecolor=colour, linewidth=1.2)
    middle = (body.low + body.high) / 2
    ends = np.array([middle, [body.high[0] + 0.1 * body.length, middle[1], middle[2]]]) @ turned.T
    tail, head = ends[:, :2] + at
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=head, xytext=tail, arrowprops=arrow)


def axes_of(rests: Poses, index: int) -> Array:
    """Return the axes of a robot at one of its poses as columns, (3, 3)."""
    return rotation(*(float(angle[index]) for angle in (rests.roll, rests.pitch, rests.yaw)))


def hull(points: Array) -> Array:
    """Return the corners of the convex hull of points (n, 2), counterclockwise (Andrew's monotone chain, 1979)."""
    ordered = sorted(set(map(tuple, _without_inner(np.round(points, 6)).tolist())))
    if len(ordered) < 3:
        return np.array(ordered)

    def chain(along: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        corners: list[tuple[float, ...]] = []
        for x, y in along:
            while len(corners) > 1:
                (a, b), (c, d) = corners[-2:]
                if (c - a) * (y - b) - (d - b) * (x - a) > 0:  # a turn to the left
                    break
                corners.pop()
            corners.append((x, y))
        return corners[:-1]  # the last one is the first of the other chain

    return np.array(chain(ordered) + chain(ordered[::-1]))


_MANY, _WAYS = 1000, 32
"""Points up to which inner ones are left in, as it is faster, and directions in which outer points are looked for."""


def _without_inner(points: Array) -> Array:
    """Return points (n, 2) without those inside the polygon of the outermost points (Akl, Toussaint 1978)."""
    if len(points) <= _MANY:
        return points
    ways = np.arange(_WAYS) * 2 * np.pi / _WAYS
    corners = np.unique([points[(points @ (np.cos(way), np.sin(way))).argmax()] for way in ways], axis=0)
    corners = hull(corners)
    # To the right of a side, or on it: its ends are corners of the hull and stay.
    outside = np.zeros(len(points), bool)
    for (a, b), (c, d) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        outside |= (c - a) * (points[:, 1] - b) - (d - b) * (points[:, 0] - a) <= 0
    return points[outside]


def _placed(body: Body, rests: Poses) -> Array:
    """Return the surface of a robot at its one pose, in the world, (m, 3)."""
    return np.asarray(body.surface @ axes_of(rests, 0).T + np.array([rests.x[0], rests.y[0], rests.z[0]]))
