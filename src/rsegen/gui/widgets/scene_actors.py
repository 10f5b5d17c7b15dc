"""The actors of the 3D view, created once and filled with the points, faces and colours of every scene."""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow, coarse_window
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.reach import (
    EASTWARD,
    NORTHWARD,
    Reach,
    ReachShape,
    RobotShape,
    SpotShape,
    coloured,
    place_next_to,
    reach_shape,
)
from rsegen.gui.model.solid import Bounds, Lines, Solid, block_edges, border, bounds, box_edges, tick_marks
from rsegen.gui.widgets.meshes import (
    Drawn,
    Plotter,
    faces_in,
    fill_faces,
    fill_light,
    fill_lines,
    fill_robot,
    light_map,
    lines_in,
    robot_in,
)
from rsegen.gui.widgets.view_camera import ViewCamera

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
    """The faces, each of four points, in one value."""
    if not parts:
        return coloured(np.empty((0, 3), dtype=np.float32), _WHITE)
    points, colours = (np.concatenate([part[at] for part in parts]) for at in (0, 2))
    return Solid(points, np.arange(len(points), dtype=np.int32).reshape(-1, 4), colours, np.zeros_like(points[:, :2]))


def _flat_in(plotter: Plotter, *, nearer: int) -> Drawn:
    """Add an empty mesh of faces; nearer: how far it is drawn in front of other faces at the same place."""
    drawn = faces_in(plotter)
    drawn.actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-nearer, -nearer)
    return drawn


EDGED = 120
"""The blocks of maps up to this many cells a side are outlined."""

_DARK_EDGES = 45
"""Up to this many cells a side outlines are dark; beyond, the paler the more cells."""

_HIGHLIGHT = (0.95, 0.0, 0.75)
_EDGE = (0.1, 0.1, 0.1)
_SKY = (0.62, 0.72, 0.84)
_HAZE = (0.12, 0.45)
"""The share of the sky's colour in the background, at the bottom and at the top."""
_GHOSTLY = 0.45
"""The opacity of an obstacle that is not yet in the list."""


class SceneActors:
    """What a plotter shows: the map, the edges of its blocks, the highlighted cells, the ground, the axes.

    camera: the plotter's; robot: the one that is shown; reach: what it can do on the map
    scale: how many times wider lines are than a pixel; texts are as large as the window's dots per inch say
    """

    def __init__(self, plotter: Plotter, camera: ViewCamera, scale: float) -> None:
        self._plotter, self.camera = plotter, camera
        self._light = light_map()
        self._ground, self._blocks = faces_in(plotter, self._light), faces_in(plotter, self._light)
        self._ghost = faces_in(plotter)
        self._ghost.actor.prop.opacity = _GHOSTLY
        self._edges = lines_in(plotter, _EDGE, width=scale, nearer=2)
        self._tick_marks = lines_in(plotter, _EDGE, width=scale, nearer=2)
        self._box = lines_in(plotter, _HIGHLIGHT, width=3 * scale, nearer=40)
        self._robot_drawn = robot_in(plotter)
        self.robot: RobotShape | None = None
        self.reach = ReachActors(plotter, scale)
        self._shown: tuple[Bounds, float] | None = None
        self._ink = (0.0, 0.0, 0.0)

    def show(self, preview: Preview, highlighted: CellWindow | None) -> None:
        """Show a map and a box around some of its cells; the camera moves if the map has another size."""
        field, lit = preview.coarse.field, preview.lit
        cells = coarse_window(preview.scene.field, highlighted, preview.factor) if highlighted else None
        fill_light(self._light, lit.light)
        fill_faces(self._ground, lit.ground)
        fill_faces(self._blocks, lit.blocks)
        self._show_ghost(preview.ghost_solid)
        if is_edged := max(field.shape) <= EDGED:
            fill_lines(self._edges, block_edges(field))
            self._edges.actor.prop.opacity = min((_DARK_EDGES / max(field.shape)) ** 2, 1)
        self._edges.actor.SetVisibility(is_edged)
        if cells:
            fill_lines(self._box, box_edges(field, cells))
        self._box.actor.SetVisibility(cells is not None)
        self._show_bounds(bounds(preview.coarse), border(field))
        self._plotter.renderer.ResetCameraClippingRange()

    def show_robot(self, shape: RobotShape | None) -> None:
        """Show a robot on the ground next to the map, to compare sizes; None shows none."""
        if shape and shape is not self.robot:
            fill_robot(self._robot_drawn, shape)
        self.robot = shape
        self._robot_drawn.actor.SetVisibility(shape is not None)
        if self._shown:
            self._place_robot(*self._shown)

    def _show_ghost(self, made: Solid | None) -> None:
        """Show the blocks of an obstacle that is not yet in the list, pale; None hides them."""
        if made:
            fill_faces(self._ghost, made)
        self._ghost.actor.SetVisibility(made is not None)

    def set_colours(self, background: tuple[float, float, float], ink: tuple[float, float, float]) -> None:
        """Set the colours of the background and of the axes."""
        shares = _HAZE if sum(background) > 1.5 else (0, _HAZE[0])
        bottom, top = (tuple((1 - share) * np.array(background) + share * np.array(_SKY)) for share in shares)
        self._plotter.set_background(bottom, top=top)
        self._ink = ink
        if self._shown:
            self._show_axes(*self._shown)

    def _show_bounds(self, found: Bounds, rim: float) -> None:
        """Show axes and the whole map for these bounds, if they have changed."""
        if (found, rim) == self._shown:
            return
        self._shown = found, rim
        self._show_axes(found, rim)
        self._place_robot(found, rim)

    def _place_robot(self, found: Bounds, rim: float) -> None:
        """Put the robot next to the map, and show the whole of both."""
        margin = 2.6 * rim
        if self.robot:
            x, y = place_next_to(found, rim, self.robot)
            self._robot_drawn.actor.position = (x, y, 0.0)
            length, width, _ = self.robot.size
            margin = max(margin, x + length / 2 - found[1], found[2] - y + width / 2)
        self.camera.fit_bounds(found, margin)

    def _show_axes(self, found: Bounds, rim: float) -> None:
        """Show tick marks with metres along the map's sides."""
        ruled = tick_marks(found, rim)
        fill_lines(self._tick_marks, ruled.lines)
        self._plotter.add_point_labels(
            ruled.places,
            ruled.texts,
            name="metres",
            text_color=self._ink,
            font_size=12,  # of a window of 72 dots per inch, times the scale
            bold=False,
            shape=None,
            show_points=False,
            always_visible=True,
            justification_horizontal="center",
            justification_vertical="center",
            reset_camera=False,
            render=False,
        )
