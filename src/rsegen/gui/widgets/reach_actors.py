"""The actors that show in the 3D view what a robot can do on the map, in the colours of the plan."""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.gui.model.reach import EASTWARD, NORTHWARD, Reach
from rsegen.gui.model.reach_shape import ReachShape, SpotShape, coloured, reach_shape
from rsegen.gui.model.solid import Lines, Solid
from rsegen.gui.widgets.meshes import Drawn, Plotter, faces_in, fill_faces, fill_lines, lines_in

_PAPER, _INK = (1.0, 1.0, 1.0), (0.08, 0.08, 0.08)
_WHITE = (255, 255, 255)
_VEILED, _STANDING = 0.72, 0.67
"""The opacity of what hides blocks that the robot does not reach, and of its outline on a spot."""

_LABELS = "spots"


class ReachActors:
    """A veil over blocks that a robot does not reach, its ways across, its start and goal.

    reach: what is shown
    """

    def __init__(self, plotter: Plotter, scale: float) -> None:
        self._plotter = plotter
        self._veil = _flat_in(plotter, nearer=1)
        self._veil.actor.prop.opacity = _VEILED
        self._standing = _flat_in(plotter, nearer=3)
        self._standing.actor.prop.opacity = _STANDING
        self._casing = lines_in(plotter, _PAPER, width=6 * scale, nearer=20)
        colours = [tuple(np.array(colour) / 255) for colour in (EASTWARD, NORTHWARD)]
        self._ways = [lines_in(plotter, colour, width=3 * scale, nearer=30) for colour in colours]
        self._ends, self._holes = _flat_in(plotter, nearer=40), _flat_in(plotter, nearer=50)
        self._outlines = lines_in(plotter, _INK, width=2 * scale, nearer=24)
        self._fronts = lines_in(plotter, _INK, width=5 * scale, nearer=24)
        self.reach: Reach | None = None

    def show(self, scene: Scene | None, reach: Reach | None) -> None:
        """Show what a robot can do on a scene; None hides all."""
        self.reach = reach if scene else None
        shape = reach_shape(scene, reach) if scene and reach else None
        for each in self._all():
            each.actor.SetVisibility(shape is not None)
        self._plotter.remove_actor(_LABELS, reset_camera=False, render=False)
        if shape:
            self._fill(shape)

    def _all(self) -> list[Any]:
        lines = [self._casing, *self._ways, self._outlines, self._fronts]
        return [self._veil, self._standing, *lines, self._ends, self._holes]

    def _fill(self, shape: ReachShape) -> None:
        fill_faces(self._veil, shape.veil)
        fill_lines(self._casing, _joined([way.lines for way in shape.ways]))
        for lines, is_eastward in zip(self._ways, (True, False), strict=True):
            fill_lines(lines, _joined([way.lines for way in shape.ways if way.is_eastward is is_eastward]))
        fill_faces(self._ends, _together([way.ends for way in shape.ways]))
        fill_faces(self._holes, _together([way.hole for way in shape.ways]))
        rings = [Lines(spot.outline, np.array([(0, 1), (1, 2), (2, 3), (3, 0)])) for spot in shape.spots]
        fill_lines(self._outlines, _joined(rings))
        fill_lines(self._fronts, _joined([Lines(spot.front, np.array([(0, 1)])) for spot in shape.spots]))
        fill_faces(
            self._standing, _together([coloured(spot.outline.astype(np.float32), _WHITE) for spot in shape.spots])
        )
        if shape.spots:
            self._label(shape.spots)

    def _label(self, spots: tuple[SpotShape, ...]) -> None:
        self._plotter.add_point_labels(
            np.array([spot.middle for spot in spots]),
            [spot.name for spot in spots],
            name=_LABELS,
            text_color=_INK,
            font_size=14,
            bold=True,
            shape="rounded_rect",
            shape_color=_PAPER,
            shape_opacity=0.85,
            margin=3,
            show_points=False,
            always_visible=True,
            justification_horizontal="center",
            justification_vertical="center",
            reset_camera=False,
            render=False,
        )


def _joined(parts: list[Lines]) -> Lines:
    if not parts:
        return Lines(np.empty((0, 3)), np.empty((0, 2), dtype=np.int64))
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    pairs = [part.pairs + start for part, start in zip(parts, starts[:-1], strict=True)]
    return Lines(np.concatenate([part.points for part in parts]), np.concatenate(pairs))


def _together(parts: list[Solid]) -> Solid:
    """All faces, each of four points, in one value."""
    if not parts:
        return coloured(np.empty((0, 3), dtype=np.float32), _WHITE)
    points, colours = (np.concatenate([part[at] for part in parts]) for at in (0, 2))
    return Solid(points, np.arange(len(points), dtype=np.int32).reshape(-1, 4), colours, np.zeros_like(points[:, :2]))


def _flat_in(plotter: Plotter, *, nearer: int) -> Drawn:
    """Add an empty mesh of faces; nearer: how far it is drawn in front of other faces at the same place."""
    drawn = faces_in(plotter)
    drawn.actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-nearer, -nearer)
    return drawn
