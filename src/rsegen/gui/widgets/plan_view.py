"""The plan of a map, on which obstacles are drawn, selected and moved, and cells painted."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QSize, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPixmap, QResizeEvent
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from rsegen.exporters.scene import Scene
from rsegen.gui.model.ghost import Ghost
from rsegen.gui.model.handles import ENDS, Grip, Handle, cell_of, grip_at, moved
from rsegen.gui.model.painting import UNPAINTED, next_cell, stroke
from rsegen.gui.model.plan_layout import PlanLayout, describe_cell, fit
from rsegen.gui.widgets import plan_painting
from rsegen.params.places import Cell

_STEPS = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Down: (0, -1),
    Qt.Key.Key_Up: (0, 1),
}


class PlanView(QWidget):
    """A scene from above, north up, with the ends of its obstacles.

    hovered: what is under the cursor, empty outside the map. chosen: the row of the obstacle whose handle was pressed.
    moved: row, "first" or "last", x, y. drawn: x and y of the first end, x and y of the last. painted: cells, their
    new level (UNPAINTED to erase), and the number of the stroke. All in block cells.
    """

    hovered = Signal(str)
    chosen = Signal(int)
    moved = Signal(int, str, int, int)
    drawn = Signal(int, int, int, int)
    painted = Signal(object, int, int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._scene: Scene | None = None
        self._ghost: Ghost | None = None
        self._layout: PlanLayout | None = None
        self._handles: tuple[Handle, ...] = ()
        self._selected: int | None = None
        self._cells_pixmap: QPixmap | None = None
        self._active_grip: Grip | None = None
        self._dragged: Grip | None = None
        self._pressed: QPointF | None = None
        self._rubber_band: tuple[Cell, Cell] | None = None
        self._end_switched = False
        self._brush: int | None = None
        self._stroke_level: int | None = None
        self._cursor: Cell = (0, 0)
        self._strokes = 0
        self._set_up()

    def show(self, scene: Scene | None = None, handles: Sequence[Handle] = (), selected: int | None = None) -> None:
        """Show a scene with the ends of its obstacles and the selected row; without a scene, show the widget."""
        if scene is None:
            super().show()
            return
        if scene is not self._scene:
            self._scene, self._cells_pixmap, self._layout = scene, None, None
        self.show_handles(handles, selected)

    def show_ghost(self, ghost: Ghost | None) -> None:
        """Show an obstacle that is not yet in the list; None hides it."""
        self._ghost = ghost
        self.update()

    @property
    def cells(self) -> Cell | None:
        """The number of block cells along x and y of the scene that is shown."""
        return self._scene.recipe.grid.shape if self._scene else None

    def show_handles(self, handles: Sequence[Handle], selected: int | None) -> None:
        """Show the ends of the obstacles and the selected row; a handle that was moved by others is let go."""
        before, self._handles, self._selected = self._handles, tuple(handles), selected
        if self._active_grip and (self._active_grip.row != selected or not cell_of(handles, self._active_grip)):
            self._active_grip = None
        if self._dragged and cell_of(handles, self._dragged) != cell_of(before, self._dragged):
            self._dragged = None
        self.update()

    def set_brush(self, level: int | None) -> None:
        """Paint cells of this level from now on; None switches painting off."""
        self._end_drag()
        self._brush = level
        self.setCursor(Qt.CursorShape.ArrowCursor if level is None else Qt.CursorShape.CrossCursor)

    def sizeHint(self) -> QSize:
        """Large enough to write heights into a map of twenty cells a side."""
        return QSize(480, 480)

    def minimumSizeHint(self) -> QSize:
        """The smallest legible plan."""
        return QSize(160, 160)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the cells, which are cached, and over them what changes with the mouse."""
        layout = self._fitted()
        if not self._scene or not layout:
            return
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._cached_cells(self._scene, layout))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self._ghost:
            plan_painting.paint_ghost(painter, self._ghost, layout)
        if self._brush is None:
            plan_painting.paint_handles(painter, layout, self._handles, self._selected)
        if self.hasFocus() and (cell := self._keyboard_cell(layout)):
            plan_painting.paint_active(painter, layout, cell, self.palette().color(QPalette.ColorRole.Highlight))
        if self._rubber_band:
            plan_painting.paint_rubber_band(painter, layout, *self._rubber_band)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start to drag a handle, to draw an obstacle or to paint."""
        layout = self._fitted()
        if layout and self._brush is not None:
            self._start_stroke(layout, event)
            return
        if not layout or event.button() != Qt.MouseButton.LeftButton:
            return
        point = event.position().toTuple()
        self._dragged = grip_at(self._handles, self._selected, layout, point)
        self._end_switched = False
        if self._dragged:
            self._active_grip = self._dragged
            if self._dragged.row != self._selected:
                self.chosen.emit(self._dragged.row)
        elif layout.cell_at(point):
            self._pressed = event.position()
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue the drag, and show what is under the cursor."""
        layout = self._fitted()
        if not layout:
            return
        point = event.position().toTuple()
        self._show_cell(layout.cell_at(point))
        if self._stroke_level is not None:
            self._paint_to(layout.nearest_block(point), self._stroke_level)
        elif self._dragged:
            self._move(self._dragged, layout.nearest_block(point))
        elif self._pressed and self._far(event.position()):
            self._rubber_band = layout.nearest_block(self._pressed.toTuple()), layout.nearest_block(point)
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag; what was drawn becomes an obstacle."""
        if event.button() != Qt.MouseButton.LeftButton and self._stroke_level is None:
            return
        band = self._rubber_band
        self._end_drag()
        if band and self._brush is None:
            self.drawn.emit(*band[0], *band[1])

    def leaveEvent(self, event: QEvent) -> None:
        """Show that nothing is under the cursor."""
        self._show_cell(None)
        super().leaveEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows move the handle used last by a cell; Escape cancels a drag."""
        if self._brush is not None and self._paint_by_key(event, self._brush):
            return
        step, grip, layout = _STEPS.get(Qt.Key(event.key())), self._active_or_selected(), self._fitted()
        cell = cell_of(self._handles, grip) if grip else None
        if event.key() == Qt.Key.Key_Escape and (self._rubber_band or self._dragged):
            self._end_drag()
        elif step and grip and cell and layout:
            self._active_grip, self._end_switched = grip, False
            self._move(grip, layout.moved(cell, step))
        else:
            super().keyPressEvent(event)

    def focusNextPrevChild(self, next: bool) -> bool:  # noqa: A002, FBT001  # Qt's word
        """Tab switches to the obstacle's other end; a second Tab, and Shift+Tab, leave the plan."""
        grip = self._active_or_selected() if self._brush is None else None
        other = Grip(grip.row, ENDS[grip.end == "first"]) if grip else None
        if not next or self._end_switched or not other or not cell_of(self._handles, other):
            return super().focusNextPrevChild(next)
        self._active_grip, self._end_switched = other, True
        self.update()
        return True

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Mark the handle that the keyboard moves."""
        self._end_switched = False
        super().focusInEvent(event)
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the plan to the new size."""
        self._layout = self._cells_pixmap = None
        super().resizeEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Repaint when the colours or fonts of the desktop change."""
        self._cells_pixmap = None
        super().changeEvent(event)

    def _set_up(self) -> None:
        self.setAccessibleName("Plan of the map")
        self.setAccessibleDescription(
            "The map from above, x to the right and y up. Drag across cells to draw an obstacle, drag a handle to move "
            "an end of one. Arrow keys move the end used last by one cell; Tab switches between first and last."
        )
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def _fitted(self) -> PlanLayout | None:
        """The layout of the plan in the widget at its present size."""
        if not self._layout and self._scene:
            self._layout = fit(
                self._scene.field, plan_painting.plan_area(self.width(), self.height()), self.devicePixelRatio()
            )
        return self._layout

    def _cached_cells(self, scene: Scene, layout: PlanLayout) -> QPixmap:
        ratio = self.devicePixelRatio()
        if self._cells_pixmap is None or self._cells_pixmap.devicePixelRatio() != ratio:
            self._cells_pixmap = QPixmap(self.size() * ratio)
            self._cells_pixmap.setDevicePixelRatio(ratio)
            self._cells_pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._cells_pixmap)
            painter.setFont(self.font())
            plan_painting.paint_ground(painter, scene, layout)
            plan_painting.paint_rulers(painter, layout, self.palette().color(QPalette.ColorRole.WindowText))
            painter.end()
        return self._cells_pixmap

    def _active_or_selected(self) -> Grip | None:
        """The handle that the keyboard moves: the one used last, or else one of the selected obstacle."""
        if self._active_grip or self._selected is None:
            return self._active_grip
        ends = (Grip(self._selected, end) for end in ENDS)
        return next((grip for grip in ends if cell_of(self._handles, grip)), None)

    def _keyboard_cell(self, layout: PlanLayout) -> Cell | None:
        """The block cell that the keyboard moves or paints."""
        if self._brush is not None:
            return layout.moved(self._cursor, (0, 0))
        grip = self._active_or_selected()
        return cell_of(self._handles, grip) if grip else None

    def _start_stroke(self, layout: PlanLayout, event: QMouseEvent) -> None:
        """Start a stroke that paints with the left button, and erases with another."""
        cell = layout.cell_at(event.position().toTuple())
        if cell and (block := layout.block_of(cell)):
            self._stroke_level = (
                self._brush if event.button() == Qt.MouseButton.LeftButton and self._brush is not None else UNPAINTED
            )
            self._cursor, self._strokes = block, self._strokes + 1
            self._paint_to(block, self._stroke_level)

    def _paint_to(self, block: Cell, level: int) -> None:
        """Paint all cells from the last one to this, so that a quick stroke has no gaps."""
        cells = stroke(self._cursor, block)
        self._cursor = block
        self.painted.emit(cells, level, self._strokes)
        self.update()

    def _paint_by_key(self, event: QKeyEvent, level: int) -> bool:
        """Arrows move, a digit sets the level of the cell and moves on, Space paints, Backspace erases."""
        layout, key, typed = self._fitted(), Qt.Key(event.key()), event.text()
        levels = {" ": level, "\b": UNPAINTED} | {str(digit): digit for digit in range(10)}
        if not layout or not (key in _STEPS or typed in levels):
            return False
        self._cursor = layout.moved(self._cursor, _STEPS.get(key, (0, 0)))
        if key not in _STEPS:
            self._strokes += 1
            self._paint_to(self._cursor, levels[typed])
            if typed.isdigit():
                self._cursor = next_cell(self._cursor, (len(layout.blocks[0]), len(layout.blocks[1])))
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
        return self._rubber_band is not None or (point - start).manhattanLength() >= QApplication.startDragDistance()

    def _end_drag(self) -> None:
        self._dragged = self._pressed = self._rubber_band = self._stroke_level = None
        self.update()

    def _show_cell(self, cell: Cell | None) -> None:
        text = describe_cell(self._scene, self._layout, cell) if self._scene and self._layout and cell else ""
        if text != self.toolTip():
            self.setToolTip(text)
            self.hovered.emit(text)
