"""The plan of a scene, on which obstacles are drawn, chosen and moved with the mouse and the keyboard."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QSize, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPixmap, QResizeEvent
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from rsegen.exporters.scene import Scene
from rsegen.gui import sheet
from rsegen.gui.cells import Layout, fit
from rsegen.gui.colours import centimetres
from rsegen.gui.handles import ENDS, Grip, Handle, cell_of, grip_at, moved
from rsegen.gui.painting import BARE, beside, stroke
from rsegen.params.places import Cell

__all__ = ["Handle", "PlanView", "spoken"]

_STEPS = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Down: (0, -1),
    Qt.Key.Key_Up: (0, 1),
}


class PlanView(QWidget):
    """A scene from above, north up, with the ends of its obstacles.

    hovered: what is under the cursor, empty beside the map. chosen: the row of the obstacle whose handle was pressed.
    moved: row, "first" or "last", x, y. drawn: x and y of the first end, x and y of the last. painted: cells, the level
    they are to have (BARE: none), and the number of the stroke. All in block cells.
    """

    hovered = Signal(str)
    chosen = Signal(int)
    moved = Signal(int, str, int, int)
    drawn = Signal(int, int, int, int)
    painted = Signal(object, int, int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._scene: Scene | None = None
        self._layout: Layout | None = None
        self._handles: tuple[Handle, ...] = ()
        self._selected: int | None = None
        self._ground: QPixmap | None = None
        self._touched: Grip | None = None
        self._held: Grip | None = None
        self._pressed: QPointF | None = None
        self._band: tuple[Cell, Cell] | None = None
        self._switched = False
        self._brush: int | None = None
        self._wet: int | None = None
        self._cursor: Cell = (0, 0)
        self._strokes = 0
        self._introduce()

    def show(self, scene: Scene | None = None, handles: Sequence[Handle] = (), selected: int | None = None) -> None:
        """Show a scene, the ends of its obstacles, and the row of the one that can be moved; or the widget."""
        if scene is None:
            super().show()
            return
        if scene is not self._scene:
            self._scene, self._ground, self._layout = scene, None, None
        self._handles, self._selected = tuple(handles), selected
        if self._touched and (self._touched.row != selected or not cell_of(handles, self._touched)):
            self._touched = None
        if self._held and not cell_of(handles, self._held):
            self._held = None
        self.update()

    def take_brush(self, level: int | None) -> None:
        """Paint cells of this level from now on; with None, draw and move obstacles again."""
        self._let_go()
        self._brush = level
        self.setCursor(Qt.CursorShape.ArrowCursor if level is None else Qt.CursorShape.CrossCursor)

    def sizeHint(self) -> QSize:
        """Room for heights in a map of twenty cells a side."""
        return QSize(480, 480)

    def minimumSizeHint(self) -> QSize:
        """Room for a map that can be made out."""
        return QSize(160, 160)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the ground, which is kept, and on it what changes with the mouse."""
        layout = self._placed()
        if not self._scene or not layout:
            return
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._painted_ground(self._scene, layout))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self._brush is None:
            sheet.paint_handles(painter, layout, self._handles, self._selected)
        if self.hasFocus() and (cell := self._at_keys(layout)):
            sheet.paint_touched(painter, layout, cell, self.palette().color(QPalette.ColorRole.Highlight))
        if self._band:
            sheet.paint_band(painter, layout, *self._band)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of a handle, or begin to draw."""
        layout = self._placed()
        if layout and self._brush is not None:
            self._dip(layout, event)
            return
        if not layout or event.button() != Qt.MouseButton.LeftButton:
            return
        point = event.position().toTuple()
        self._held = grip_at(self._handles, self._selected, layout, point)
        self._switched = False
        if self._held:
            self._touched = self._held
            if self._held.row != self._selected:
                self.chosen.emit(self._held.row)
        elif layout.cell_at(point):
            self._pressed = event.position()
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move what is held, stretch what is drawn, or say what is under the cursor."""
        layout = self._placed()
        if not layout:
            return
        point = event.position().toTuple()
        self._say(layout.cell_at(point))
        if self._wet is not None:
            self._paint_to(layout.nearest_block(point), self._wet)
        elif self._held:
            self._move(self._held, layout.nearest_block(point))
        elif self._pressed and self._far(event.position()):
            self._band = layout.nearest_block(self._pressed.toTuple()), layout.nearest_block(point)
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go; what was drawn becomes an obstacle."""
        if event.button() != Qt.MouseButton.LeftButton and self._wet is None:
            return
        band = self._band
        self._let_go()
        if band and self._brush is None:
            self.drawn.emit(*band[0], *band[1])

    def leaveEvent(self, event: QEvent) -> None:
        """Say that nothing is under the cursor."""
        self._say(None)
        super().leaveEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows move the handle that was touched last by a cell; Escape gives up what is being drawn."""
        if self._brush is not None and self._paint_by_key(event, self._brush):
            return
        step, grip, layout = _STEPS.get(Qt.Key(event.key())), self._at_hand(), self._placed()
        cell = cell_of(self._handles, grip) if grip else None
        if event.key() == Qt.Key.Key_Escape and (self._band or self._held):
            self._let_go()
        elif step and grip and cell and layout:
            self._touched, self._switched = grip, False
            self._move(grip, layout.moved(cell, step))
        else:
            super().keyPressEvent(event)

    def focusNextPrevChild(self, next: bool) -> bool:  # noqa: A002, FBT001  # Qt's word
        """Tab goes to the selected obstacle's other end; a second Tab in a row, and Shift+Tab, leave the plan."""
        grip = self._at_hand() if self._brush is None else None
        other = Grip(grip.row, ENDS[grip.end == "first"]) if grip else None
        if not next or self._switched or not other or not cell_of(self._handles, other):
            return super().focusNextPrevChild(next)
        self._touched, self._switched = other, True
        self.update()
        return True

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show which handle the keyboard moves."""
        self._switched = False
        super().focusInEvent(event)
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the map anew."""
        self._layout = self._ground = None
        super().resizeEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Follow the desktop from light to dark, and its fonts."""
        self._ground = None
        super().changeEvent(event)

    def _introduce(self) -> None:
        self.setAccessibleName("Plan of the map")
        self.setAccessibleDescription(
            "The map from above, x to the right and y up. Drag across cells to draw an obstacle, drag a handle to move "
            "an end of one. Arrow keys move the end touched last by one cell; Tab switches between first and last."
        )
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def _placed(self) -> Layout | None:
        """Where the map lies in the widget as large as it is."""
        if not self._layout and self._scene:
            self._layout = fit(self._scene.field, sheet.room(self.width(), self.height()), self.devicePixelRatio())
        return self._layout

    def _painted_ground(self, scene: Scene, layout: Layout) -> QPixmap:
        ratio = self.devicePixelRatio()
        if self._ground is None or self._ground.devicePixelRatio() != ratio:
            self._ground = QPixmap(self.size() * ratio)
            self._ground.setDevicePixelRatio(ratio)
            self._ground.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._ground)
            painter.setFont(self.font())
            sheet.paint_ground(painter, scene, layout)
            sheet.paint_rulers(painter, layout, self.palette().color(QPalette.ColorRole.WindowText))
            painter.end()
        return self._ground

    def _at_hand(self) -> Grip | None:
        """The handle that the keyboard moves: the one touched last, or else the selected obstacle's."""
        if self._touched or self._selected is None:
            return self._touched
        ends = (Grip(self._selected, end) for end in ENDS)
        return next((grip for grip in ends if cell_of(self._handles, grip)), None)

    def _at_keys(self, layout: Layout) -> Cell | None:
        """The block cell that the keyboard works on."""
        if self._brush is not None:
            return layout.moved(self._cursor, (0, 0))
        grip = self._at_hand()
        return cell_of(self._handles, grip) if grip else None

    def _dip(self, layout: Layout, event: QMouseEvent) -> None:
        """Begin a stroke of paint, or with another button than the left one of taking it off."""
        cell = layout.cell_at(event.position().toTuple())
        if cell and (block := layout.block_of(cell)):
            self._wet = self._brush if event.button() == Qt.MouseButton.LeftButton and self._brush is not None else BARE
            self._cursor, self._strokes = block, self._strokes + 1
            self._paint_to(block, self._wet)

    def _paint_to(self, block: Cell, level: int) -> None:
        """All cells from the last one on, so that a quick stroke has no gaps."""
        cells = stroke(self._cursor, block)
        self._cursor = block
        self.painted.emit(cells, level, self._strokes)
        self.update()

    def _paint_by_key(self, event: QKeyEvent, level: int) -> bool:
        """Arrows move, a digit is the level of the cell and goes on, Space paints, Backspace takes off."""
        layout, key, typed = self._placed(), Qt.Key(event.key()), event.text()
        levels = {" ": level, "\b": BARE} | {str(digit): digit for digit in range(10)}
        if not layout or not (key in _STEPS or typed in levels):
            return False
        self._cursor = layout.moved(self._cursor, _STEPS.get(key, (0, 0)))
        if key not in _STEPS:
            self._strokes += 1
            self._paint_to(self._cursor, levels[typed])
            if typed.isdigit():
                self._cursor = beside(self._cursor, (len(layout.blocks[0]), len(layout.blocks[1])))
        self.update()
        return True

    def _move(self, grip: Grip, cell: Cell) -> None:
        if cell != cell_of(self._handles, grip):
            self._handles = moved(self._handles, grip, cell)
            self.update()
            self.moved.emit(grip.row, grip.end, *cell)

    def _far(self, point: QPointF) -> bool:
        """Whether a press has become a drag."""
        start = self._pressed or point
        return self._band is not None or (point - start).manhattanLength() >= QApplication.startDragDistance()

    def _let_go(self) -> None:
        self._held = self._pressed = self._band = self._wet = None
        self.update()

    def _say(self, cell: Cell | None) -> None:
        text = spoken(self._scene, self._layout, cell) if self._scene and self._layout and cell else ""
        if text != self.toolTip():
            self.setToolTip(text)
            self.hovered.emit(text)


def spoken(scene: Scene, layout: Layout, cell: Cell) -> str:
    """What stands in a field cell: `block 3, 4: level 2, 20 cm`, or `frame: 10 cm`."""
    if scene.field.frame[cell]:
        return f"frame: {centimetres(scene.field.frame_height)}"
    x, y = layout.block_of(cell) or cell
    level = int(scene.field.levels[cell])
    return f"block {x}, {y}: level {level}, {centimetres(level * scene.field.unit)}"
