"""The actors of the 3D view, created once and filled with the points, faces and colours of every scene."""

from __future__ import annotations

import numpy as np

from rsegen.field.coarse import coarse_window
from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.axes import tick_marks
from rsegen.gui.model.bounds import Bounds, border, bounds
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.robot_shape import RobotShape, place_next_to
from rsegen.gui.model.solid import Solid, block_edges, box_edges
from rsegen.gui.widgets.meshes import (
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
from rsegen.gui.widgets.reach_actors import ReachActors
from rsegen.gui.widgets.view_camera import ViewCamera

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
