"""A live view of a scene in three dimensions, where there is a display that can draw one."""

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
from rsegen.gui.legend import Legend
from rsegen.gui.look import Look, look_of
from rsegen.gui.stage import Plotter, Stage

_WITHOUT_GL = ("offscreen", "minimal", "linuxfb", "vnc")
_OPENGL = (3, 2)
_FRAME = 2
_KEYS = "Arrow keys turn the map, + and - come nearer and go away, 0 shows the whole map."
_TURNS: dict[int, tuple[float, float]] = {
    Qt.Key.Key_Left: (10.0, 0.0),
    Qt.Key.Key_Right: (-10.0, 0.0),
    Qt.Key.Key_Up: (0.0, 10.0),
    Qt.Key.Key_Down: (0.0, -10.0),
}
"""Degrees: the map goes the way of the arrow, as it does under the mouse."""
_NEARER: dict[int, float] = {Qt.Key.Key_Plus: 1.2, Qt.Key.Key_Equal: 1.2, Qt.Key.Key_Minus: 1 / 1.2}


def unavailable() -> str:
    """Why there can be no 3D view here, for people; empty where there can be one."""
    platform = QGuiApplication.platformName()
    if platform in _WITHOUT_GL:
        return f"The 3D view needs a display: Qt's platform '{platform}' has none."
    try:
        import pyvistaqt  # noqa: F401  # whether it can be
    except ImportError as error:
        return f"The 3D view needs pyvista and pyvistaqt: {error}."
    return _opengl_missing()


class FieldView(QWidget):
    """A scene in three dimensions, beside a legend of its heights; turned, shifted and zoomed with the mouse."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("View of the map in three dimensions")
        self.setAccessibleDescription(_KEYS)
        self.setToolTip(_KEYS)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._stage: Stage | None = None
        self._plotter: Plotter = None
        self._legend, self._note = Legend(self), QLabel(self)
        row = QHBoxLayout(self)
        row.setContentsMargins(_FRAME, _FRAME, _FRAME, _FRAME)
        row.addWidget(_sorry(why) if (why := unavailable()) else self._plotter_widget(), stretch=1)
        row.addLayout(self._beside())

    def show(self, scene: Scene | None = None, highlighted: CellWindow | None = None) -> None:
        """Show a scene with a window of its cells outlined, the camera where it was; without a scene, the widget."""
        if scene is None:
            super().show()
            return
        self.show_look(look_of(scene), highlighted)

    def show_look(self, look: Look, highlighted: CellWindow | None = None) -> None:
        """Show what was made of a scene before."""
        self._legend.show_rows(look.legend)
        self._note.setText(f"each column the highest\nof {look.factor} x {look.factor} cells")
        self._note.setVisible(look.factor > 1)
        if self._stage:
            window = coarse_window(look.scene.field, highlighted, look.factor) if highlighted else None
            self._stage.show(look.coarse, look.solid, window)
            QWidget.update(self._plotter)

    def reset_camera(self) -> None:
        """Look at the whole map from the south-east, above."""
        if self._stage:
            self._stage.reset_camera()
            QWidget.update(self._plotter)

    def save_picture(self, path: Path) -> None:
        """Write the view and its legend as a picture, in the format of the path's ending, or raise a FileError."""
        if not self.grab().save(str(path)):
            raise FileError(f"{path}: cannot be written as a picture; give a name in a folder that is there, as x.png")

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows turn, + and - come nearer and go away, 0 shows the whole map."""
        key = event.key()
        if not self._stage or key not in {*_TURNS, *_NEARER, Qt.Key.Key_0}:
            super().keyPressEvent(event)
        elif key == Qt.Key.Key_0:
            self.reset_camera()
        else:
            self._stage.turn(*_TURNS.get(key, (0.0, 0.0)))
            self._stage.come_nearer(_NEARER.get(key, 1.0))
            QWidget.update(self._plotter)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show that keys go here."""
        super().focusInEvent(event)
        self.update()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Show that keys go elsewhere."""
        super().focusOutEvent(event)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """A frame while keys go here."""
        if self.hasFocus():
            painter = QPainter(self)
            painter.setPen(QPen(self.palette().color(QPalette.ColorRole.Highlight), 2 * _FRAME))
            painter.drawRect(self.rect())

    def closeEvent(self, event: QCloseEvent) -> None:
        """Give back what the graphics card holds."""
        self._end()
        super().closeEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the desktop from light to dark and back."""
        super().changeEvent(event)
        if event.type() in {QEvent.Type.PaletteChange, QEvent.Type.StyleChange} and self._stage:
            self._paint_stage()
            QWidget.update(self._plotter)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep the whole map in sight while the widget becomes larger or smaller; a click brings the keys here."""
        if self._stage and event.type() == QEvent.Type.Resize:
            self._stage.follow_size()
        if event.type() == QEvent.Type.MouseButtonPress:
            self.setFocus()
        return super().eventFilter(watched, event)

    def _beside(self) -> QVBoxLayout:
        """The legend, and below it a note on what is not shown."""
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
        self._stage = Stage(self._plotter)
        self._paint_stage()
        if program := QGuiApplication.instance():
            program.aboutToQuit.connect(self._end)
        widget: QWidget = self._plotter
        return widget

    def _paint_stage(self) -> None:
        if self._stage:
            self._stage.paint(_floats(self.palette().base().color()), _floats(self.palette().text().color()))

    def _end(self) -> None:
        if self._stage:
            self._stage = None
            self._plotter.close()


def _opengl_missing() -> str:
    """Why this display cannot draw in three dimensions; empty where it can."""
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


def _sorry(why: str) -> QLabel:
    """The reason, in the view's place."""
    label = QLabel(f"{why}\nThe plan, and every file, are the same without it.")
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setWordWrap(True)
    return label
