"""The 3D view of the map, or the reason why this display cannot show one."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import (
    QCloseEvent,
    QColor,
    QFocusEvent,
    QGuiApplication,
    QKeyEvent,
    QOffscreenSurface,
    QOpenGLContext,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
)
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from rsegen.errors import FileError
from rsegen.exporters.scene import Scene
from rsegen.field.coarse import coarse_window
from rsegen.field.stepfield import CellWindow
from rsegen.gui.model.preview import Preview, preview_of
from rsegen.gui.widgets.legend import Legend
from rsegen.gui.widgets.scene_actors import Plotter, SceneActors

_WITHOUT_GL = ("offscreen", "minimal", "linuxfb", "vnc")
_OPENGL = (3, 2)
_FRAME = 2
_KEYS = "Arrow keys turn the map, + and - zoom, 0 shows the whole map."
_TURNS: dict[int, tuple[float, float]] = {
    Qt.Key.Key_Left: (10.0, 0.0),
    Qt.Key.Key_Right: (-10.0, 0.0),
    Qt.Key.Key_Up: (0.0, 10.0),
    Qt.Key.Key_Down: (0.0, -10.0),
}
"""Degrees; the map turns in the direction of the arrow."""
_ZOOMS: dict[int, float] = {Qt.Key.Key_Plus: 1.2, Qt.Key.Key_Equal: 1.2, Qt.Key.Key_Minus: 1 / 1.2}


def unavailable() -> str:
    """Why this display cannot show a 3D view; empty if it can."""
    platform = QGuiApplication.platformName()
    if platform in _WITHOUT_GL:
        return f"The 3D view needs a display: Qt's platform '{platform}' has none."
    try:
        import pyvistaqt  # noqa: F401  # whether it can be
    except ImportError as error:
        return f"The 3D view needs pyvista and pyvistaqt: {error}."
    return _opengl_missing()


class FieldView(QWidget):
    """A 3D view of a scene with a legend of its heights; the mouse turns, pans and zooms it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("View of the map in three dimensions")
        self.setAccessibleDescription(_KEYS)
        self.setToolTip(_KEYS)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._actors: SceneActors | None = None
        self._plotter: Plotter = None
        self._legend, self._note = Legend(self), QLabel(self)
        row = QHBoxLayout(self)
        row.setContentsMargins(_FRAME, _FRAME, _FRAME, _FRAME)
        row.addWidget(_unavailable_label(why) if (why := unavailable()) else self._plotter_widget(), stretch=1)
        row.addLayout(self._legend_column())

    def show(self, scene: Scene | None = None, highlighted: CellWindow | None = None) -> None:
        """Show a scene, with some of its cells highlighted; without a scene, show the widget."""
        if scene is None:
            super().show()
            return
        self.show_preview(preview_of(scene), highlighted)

    def show_preview(self, preview: Preview, highlighted: CellWindow | None = None) -> None:
        """Show the preview of a scene, with some of its cells highlighted; the camera stays where it is."""
        self._legend.show_rows(preview.legend)
        self._note.setText(f"each column the highest\nof {preview.factor} x {preview.factor} cells")
        self._note.setVisible(preview.factor > 1)
        if self._actors:
            window = coarse_window(preview.scene.field, highlighted, preview.factor) if highlighted else None
            self._actors.show(preview.coarse, preview.solid, window)
            self._actors.show_ghost(preview.ghost_solid)
            QWidget.update(self._plotter)

    def reset_camera(self) -> None:
        """Look at the whole map from the south-east, above."""
        if self._actors:
            self._actors.reset_camera()
            QWidget.update(self._plotter)

    def save_picture(self, path: Path) -> None:
        """Save the view and its legend as a picture in the format of the suffix; a FileError if that fails."""
        if not self.grab().save(str(path)):
            raise FileError(f"{path}: cannot be written as a picture; give a name in an existing folder, such as x.png")

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows turn, + and - zoom, 0 shows the whole map."""
        key = event.key()
        if not self._actors or key not in {*_TURNS, *_ZOOMS, Qt.Key.Key_0}:
            super().keyPressEvent(event)
        elif key == Qt.Key.Key_0:
            self.reset_camera()
        else:
            self._actors.turn(*_TURNS.get(key, (0.0, 0.0)))
            self._actors.zoom(_ZOOMS.get(key, 1.0))
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
            self._actors.fit_to_size()
        if event.type() == QEvent.Type.MouseButtonPress:
            self.setFocus()
        return super().eventFilter(watched, event)

    def _legend_column(self) -> QVBoxLayout:
        """The legend, and below it a note if the map is shown coarser."""
        column = QVBoxLayout()
        column.addWidget(self._legend, stretch=1)
        self._note.setMargin(8)
        column.addWidget(self._note)
        self._note.setVisible(False)
        return column

    def _plotter_widget(self) -> QWidget:
        self._plotter = _plotter(self)
        self._plotter.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its keys close it, and hide faces
        self._plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)  # up stays up
        self._plotter.setAcceptDrops(False)  # it would show any file
        self._plotter.installEventFilter(self)
        self._actors = SceneActors(self._plotter)
        self._set_colours()
        if program := QGuiApplication.instance():
            program.aboutToQuit.connect(self._end)
        widget: QWidget = self._plotter
        return widget

    def _set_colours(self) -> None:
        if self._actors:
            self._actors.set_colours(_floats(self.palette().base().color()), _floats(self.palette().text().color()))

    def _end(self) -> None:
        if self._actors:
            self._actors = None
            self._plotter.close()


def _opengl_missing() -> str:
    """Why this display has no sufficient OpenGL; empty if it has."""
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not context.create() or not context.makeCurrent(surface):
        return "The 3D view needs OpenGL, and this display has none."
    found = context.format().version()
    context.doneCurrent()
    needed, given = (".".join(map(str, version)) for version in (_OPENGL, found))
    return "" if found >= _OPENGL else f"The 3D view needs OpenGL {needed} or later; this display has {given}."


def _plotter(parent: QWidget) -> Plotter:
    from pyvistaqt import QtInteractor

    return QtInteractor(parent, auto_update=False, multi_samples=4)


def _floats(colour: QColor) -> tuple[float, float, float]:
    return colour.redF(), colour.greenF(), colour.blueF()


def _unavailable_label(why: str) -> QLabel:
    """A label with the reason, in place of the view."""
    label = QLabel(f"{why}\nThe plan and all files are the same without it.")
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    return label
