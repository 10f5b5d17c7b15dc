"""A picture of the 3D view in any size, drawn behind the screen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QSize
from PySide6.QtGui import QColor, QImage, QPalette

from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.preview import Preview
from rsegen.gui.model.reach import Reach
from rsegen.gui.model.robot_shape import RobotShape
from rsegen.gui.widgets.legend import Inks
from rsegen.gui.widgets.meshes import Plotter
from rsegen.gui.widgets.scene_actors import SceneActors
from rsegen.gui.widgets.view_camera import Look, ViewCamera
from rsegen.gui.widgets.view_overlay import ViewOverlay

_SMOOTHED = 20_000_000
"""Pixels of a picture up to which edges are smoothed; in larger ones pixels are small, and it would take gigabytes."""


class Shown(NamedTuple):
    """What a view shows: a map, highlighted cells, a robot and what it can do, and the colours of everything else."""

    preview: Preview
    highlighted: CellWindow | None
    robot: RobotShape | None
    reach: Reach | None
    palette: QPalette


def view_picture(shown: Shown, look: Look, size: QSize, scale: float) -> QImage:
    """What a camera that looks so sees, in a size in pixels; any thread may call it.

    scale: how many times larger texts are than on a common screen
    """
    import pyvista

    plotter: Plotter = pyvista.Plotter(off_screen=True, window_size=list(size.toTuple()))
    plotter.render_window.SetMultiSamples(4 if size.width() * size.height() <= _SMOOTHED else 0)
    plotter.render_window.SetDPI(round(72 * scale))
    camera = ViewCamera(plotter, size.toTuple)
    actors, overlay = SceneActors(plotter, camera, scale), ViewOverlay(plotter, camera, scale)
    set_colours(shown.palette, actors, overlay)
    actors.show(shown.preview, shown.highlighted)
    actors.show_robot(shown.robot)
    actors.reach.show(shown.preview.coarse, shown.reach)
    overlay.show_legend(shown.preview)
    camera.look_as(look)
    pixels = np.ascontiguousarray(plotter.screenshot(return_img=True)[..., :3])
    plotter.close()
    height, width = pixels.shape[:2]
    return QImage(pixels.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888).copy()


def set_colours(palette: QPalette, actors: SceneActors, overlay: ViewOverlay) -> None:
    """Give everything that is not the map the colours of a palette."""
    paper, ink = palette.base().color(), palette.text().color()
    actors.set_colours(_floats(paper), _floats(ink))
    overlay.set_inks(Inks(paper, ink))


def _floats(colour: QColor) -> tuple[float, float, float]:
    return colour.redF(), colour.greenF(), colour.blueF()
