"""The 3D view of the map, or the reason why this display cannot show it, and pictures of it in any size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, QSize, Qt, Signal
from PySide6.QtGui import (
    QCloseEvent,
    QColor,
    QFocusEvent,
    QGuiApplication,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
)
from PySide6.QtWidgets import QApplication, QHBoxLayout, QLabel, QWidget

from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.painting import cell_hit
from rsegen.gui.model.preview import Preview, preview_of
from rsegen.gui.model.reach import Reach, RobotShape
from rsegen.gui.widgets.meshes import Plotter
from rsegen.gui.widgets.opengl import unavailable
from rsegen.gui.widgets.scene_actors import SceneActors
from rsegen.gui.widgets.view_camera import Inks, Look, Side, ViewCamera, ViewOverlay
from rsegen.gui.workers import write_picture
from rsegen.params.sorts import Cell

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


_FRAME = 2
_KEYS = (
    "Arrow keys turn the map, + and - zoom, 0 shows the whole map; 1 in perspective, 2 from above, 3 from the south. "
    "A click chooses an obstacle."
)
_TURNS: dict[int, tuple[float, float]] = {
    Qt.Key.Key_Left: (10.0, 0.0),
    Qt.Key.Key_Right: (-10.0, 0.0),
    Qt.Key.Key_Up: (0.0, 10.0),
    Qt.Key.Key_Down: (0.0, -10.0),
}
"""Degrees; the map turns in the direction of the arrow."""
_ZOOMS: dict[int, float] = {Qt.Key.Key_Plus: 1.2, Qt.Key.Key_Equal: 1.2, Qt.Key.Key_Minus: 1 / 1.2}
_SIDES: dict[int, Side] = {Qt.Key.Key_1: Side.PERSPECTIVE, Qt.Key.Key_2: Side.TOP, Qt.Key.Key_3: Side.SOUTH}


class FieldView(QWidget):
    """A 3D view of a scene with a legend of its heights; the mouse turns, pans and zooms it.

    clicked: the field cell that was clicked, None outside the map.
    """

    clicked = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("View of the map in three dimensions")
        self.setAccessibleDescription(_KEYS)
        self.setToolTip(_KEYS)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._actors: SceneActors | None = None
        self._plotter: Plotter = None
        self._preview: Preview | None = None
        self._highlighted: CellWindow | None = None
        self._pressed: QPointF | None = None
        self._overlay: ViewOverlay | None = None
        row = QHBoxLayout(self)
        row.setContentsMargins(_FRAME, _FRAME, _FRAME, _FRAME)
        row.addWidget(_unavailable_label(why) if (why := unavailable()) else self._plotter_widget(), stretch=1)

    def show(self, scene: Scene | None = None, highlighted: CellWindow | None = None) -> None:
        """Show a scene, with some of its cells highlighted; without a scene, show the widget."""
        if scene is None:
            super().show()
            return
        self.show_preview(preview_of(scene), highlighted)

    def show_preview(self, preview: Preview, highlighted: CellWindow | None = None) -> None:
        """Show the preview of a scene, with some of its cells highlighted; the camera stays where it is."""
        self.setAccessibleDescription(f"{_KEYS} Colours: {', '.join(name for _, name in preview.legend)}.")
        self._preview, self._highlighted = preview, highlighted
        if self._actors and self._overlay:
            self._actors.show(preview, highlighted)
            self._overlay.show_legend(preview)
            QWidget.update(self._plotter)

    def show_robot(self, shape: RobotShape | None) -> None:
        """Show a robot next to the map, to compare sizes; None shows none."""
        if self._actors:
            self._actors.show_robot(shape)
            QWidget.update(self._plotter)

    def show_reach(self, reach: Reach | None) -> None:
        """Show the largest area of a robot on the map, its ways across, a start and a goal; None shows none."""
        if self._actors:
            self._actors.reach.show(self._preview.coarse if self._preview else None, reach)
            QWidget.update(self._plotter)

    def fit(self) -> None:
        """Look at the whole map from the present direction."""
        if self._actors:
            self._actors.camera.fit()
            QWidget.update(self._plotter)

    def look_from(self, side: Side) -> None:
        """Look at the whole map from a side."""
        if self._actors:
            self._actors.camera.look_from(side)
            QWidget.update(self._plotter)

    @property
    def direction(self) -> tuple[float, float, float] | None:
        """From the map to the camera; None without a view."""
        return self._actors.camera.direction if self._actors else None

    def look_along(self, direction: tuple[float, float, float]) -> None:
        """Look at the whole map from any direction, in perspective."""
        if self._actors and any(direction):
            self._actors.camera.look_along(direction)
            QWidget.update(self._plotter)

    def cell_at(self, point: QPointF) -> Cell | None:
        """The field cell that is seen at a point of the view; of a map that is shown coarser, the middle of several."""
        if not self._actors or not self._preview:
            return None
        ratio, factor = self.devicePixelRatioF(), self._preview.factor
        ray = self._actors.camera.ray(point.x() * ratio, (self._plotter.height() - 1 - point.y()) * ratio)
        cell = cell_hit(self._preview.coarse.field, *ray)
        return (cell[0] * factor + factor // 2, cell[1] * factor + factor // 2) if cell else None

    @property
    def pixels(self) -> QSize:
        """The size of the view in pixels of the screen."""
        return self.size() * self.devicePixelRatioF()

    def save_picture(self, path: Path, size: QSize | None = None) -> None:
        """Save the view, in a size in pixels if one is given, as a picture in the format of the suffix.

        Its texts grow with its height. A FileError if it cannot be written.
        """
        write_picture(self.drawing(size)() if size else self.grab().toImage(), path)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows turn, + and - zoom, 0 shows the whole map, 1, 2 and 3 look from a side."""
        key = event.key()
        if not self._actors or key not in {*_TURNS, *_ZOOMS, *_SIDES, Qt.Key.Key_0}:
            super().keyPressEvent(event)
        elif key == Qt.Key.Key_0:
            self.fit()
        elif key in _SIDES:
            self.look_from(_SIDES[key])
        elif key in _TURNS:
            self._actors.camera.turn(*_TURNS[key])
            QWidget.update(self._plotter)
        else:
            self._actors.camera.zoom(_ZOOMS[key])
            QWidget.update(self._plotter)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show the keyboard focus."""
        super().focusInEvent(event)
        self.update()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Hide the keyboard focus."""
        super().focusOutEvent(event)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint a frame while the view has the keyboard focus."""
        if self.hasFocus():
            painter = QPainter(self)
            painter.setPen(QPen(self.palette().color(QPalette.ColorRole.Highlight), 2 * _FRAME))
            painter.drawRect(self.rect())

    def closeEvent(self, event: QCloseEvent) -> None:
        """Free the memory of the graphics card."""
        self._end()
        super().closeEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Update the colours when the desktop switches between light and dark."""
        super().changeEvent(event)
        if event.type() in {QEvent.Type.PaletteChange, QEvent.Type.StyleChange} and self._actors:
            self._set_colours()
            QWidget.update(self._plotter)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep the whole map in view when the widget is resized; a click takes the keyboard focus."""
        if self._actors and event.type() == QEvent.Type.Resize:
            self._actors.camera.fit_to_size()
        if event.type() == QEvent.Type.MouseButtonPress:
            self.setFocus()
        if isinstance(event, QMouseEvent):
            self._watch_clicks(event)
        if self._actors and isinstance(event, QMouseEvent) and _turns(event):
            self._actors.camera.leave_side()
        return super().eventFilter(watched, event)

    def _watch_clicks(self, event: QMouseEvent) -> None:
        """Emit the cell under a press of the left button that was no drag."""
        if event.type() == QEvent.Type.MouseButtonPress:
            self._pressed = event.position() if event.button() == Qt.MouseButton.LeftButton else None
        elif self._pressed and event.type() == QEvent.Type.MouseMove:
            is_far = (event.position() - self._pressed).manhattanLength() >= QApplication.startDragDistance()
            self._pressed = None if is_far else self._pressed
        elif self._pressed and event.type() == QEvent.Type.MouseButtonRelease:
            self._pressed = None
            self.clicked.emit(self.cell_at(event.position()))

    def _plotter_widget(self) -> QWidget:
        self._plotter = _plotter(self)
        self._plotter.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its keys close it, and hide faces
        self._plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)  # up stays up
        self._plotter.setAcceptDrops(False)  # it would show any file
        self._plotter.installEventFilter(self)
        scale = self.devicePixelRatioF()
        camera = ViewCamera(self._plotter, lambda: self._plotter.size().toTuple())
        self._actors, self._overlay = (
            SceneActors(self._plotter, camera, scale),
            ViewOverlay(self._plotter, camera, scale),
        )
        self._set_colours()
        if program := QGuiApplication.instance():
            program.aboutToQuit.connect(self._end)
        widget: QWidget = self._plotter
        return widget

    def drawing(self, size: QSize) -> Callable[[], QImage]:
        """What draws the view as it is now in a size in pixels, in any thread; without a view what the widget shows."""
        if not self._actors or not self._preview:
            image = self.grab().toImage()
            return lambda: image
        shown = Shown(self._preview, self._highlighted, self._actors.robot, self._actors.reach.reach, self.palette())
        growth = min(size.width() / max(self.pixels.width(), 1), size.height() / max(self.pixels.height(), 1))
        scale = max(self.devicePixelRatioF() * growth, 0.2)
        look = self._actors.camera.look
        return lambda: view_picture(shown, look, size, scale)

    def _set_colours(self) -> None:
        if self._actors and self._overlay:
            set_colours(self.palette(), self._actors, self._overlay)

    def _end(self) -> None:
        if self._actors:
            self._actors = self._overlay = None
            self._plotter.close()


def _plotter(parent: QWidget) -> Plotter:
    from pyvistaqt import QtInteractor

    return QtInteractor(parent, auto_update=False, multi_samples=4)


def _unavailable_label(why: str) -> QLabel:
    """A label with the reason, in place of the view."""
    label = QLabel(f"{why}\nThe plan and all files are the same without it.")
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    return label


def _turns(event: QMouseEvent) -> bool:
    """Return whether the mouse is dragged so that it turns the map."""
    is_left = event.buttons() == Qt.MouseButton.LeftButton
    return (
        is_left and event.type() == QEvent.Type.MouseMove and not event.modifiers() & Qt.KeyboardModifier.ShiftModifier
    )
