"""The plan of a map, on which obstacles are drawn, selected and moved, and cells painted."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QApplication, QWidget

from rsegen.exporters.scene import Scene
from rsegen.gui.model.obstacle_ends import ENDS, GRIP, Ghost, Grip, Handle, cell_of, grip_at, moved
from rsegen.gui.model.painting import UNPAINTED, Brush, Painted, Strokes, Tool, next_cell
from rsegen.gui.model.plan_layout import PlanLayout, Point
from rsegen.gui.widgets import plan_painting
from rsegen.gui.widgets.plan_canvas import PlanCanvas
from rsegen.params.sorts import Cell

_STEPS = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Down: (0, -1),
    Qt.Key.Key_Up: (0, 1),
}


class PlanView(PlanCanvas):
    """A scene from above, north up, with the ends of its obstacles.

    chosen: the row of the obstacle whose handle was pressed. moved: row, "first", "last" or "both", x, y. drawn: x and
    y of the first end, x and y of the last. painted: cells, their new level (UNPAINTED to erase), and the number of the
    stroke. picked: the level of the cell that was pressed. All in block cells.
    """

    chosen = Signal(int)
    moved = Signal(int, str, int, int)
    drawn = Signal(int, int, int, int)
    painted = Signal(object, int, int)
    picked = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._ghost: Ghost | None = None
        self._handles: tuple[Handle, ...] = ()
        self._selected: int | None = None
        self._active_grip: Grip | None = None
        self._dragged: Grip | None = None
        self._pressed: QPointF | None = None
        self._rubber_band: tuple[Cell, Cell] | None = None
        self._end_switched = False
        self._brush: Brush | None = None
        self._strokes = Strokes()
        self.setAccessibleName("Plan of the map")
        self.setAccessibleDescription(
            "The map from above, x to the right and y up. Drag across cells to draw an obstacle, drag a handle to move "
            "an end of one, or the handle between both to move them together. Arrow keys move the end used last by one "
            "cell; Tab switches between first and last. + and - zoom; the middle button, or the left one with Space, "
            "moves the plan."
        )

    def show(self, scene: Scene | None = None, handles: Sequence[Handle] = (), selected: int | None = None) -> None:
        """Show a scene with the ends of its obstacles and the selected row; without a scene, show the widget."""
        if scene is None:
            super().show()
            return
        self.show_scene(scene)
        self.show_handles(handles, selected)

    def show_ghost(self, ghost: Ghost | None) -> None:
        """Show an obstacle that is not yet in the list; None hides it."""
        self._ghost = ghost
        self.update()

    def show_handles(self, handles: Sequence[Handle], selected: int | None) -> None:
        """Show the ends of the obstacles and the selected row; a handle that was moved by others is let go."""
        before, self._handles, self._selected = self._handles, tuple(handles), selected
        if self._active_grip and (self._active_grip.row != selected or not cell_of(handles, self._active_grip)):
            self._active_grip = None
        if self._dragged and cell_of(handles, self._dragged) != cell_of(before, self._dragged):
            self._dragged = None
        self.update()

    def set_brush(self, brush: Brush | None) -> None:
        """Paint with a tool from now on; None switches painting off."""
        self._end_drag()
        self._brush = brush
        self.setCursor(Qt.CursorShape.ArrowCursor if brush is None else Qt.CursorShape.CrossCursor)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the cells, which are cached, and over them what changes with the mouse."""
        layout = self.plan_layout
        if not self._scene or not layout:
            return
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._painted_cells(self._scene, layout))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        plan_painting.clip(painter, self._area, margin=GRIP)
        if self._ghost:
            plan_painting.paint_ghost(painter, self._ghost, layout)
        if self._brush is None:
            plan_painting.paint_handles(painter, layout, self._handles, self._selected)
        if self.hasFocus() and (cell := self._keyboard_cell(layout)):
            plan_painting.paint_active(painter, layout, cell, self.palette().color(QPalette.ColorRole.Highlight))
        if self._rubber_band:
            plan_painting.paint_rubber_band(painter, layout, *self._rubber_band)
        if self._strokes.band:
            plan_painting.paint_band(painter, layout, *self._strokes.band)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start to drag a handle, to draw an obstacle or to paint."""
        layout, point = self.plan_layout, event.position().toTuple()
        if not layout or self._pans(event):
            return
        if self._brush is not None:
            self._start_stroke(layout, point, self._brush, erases=event.button() != Qt.MouseButton.LeftButton)
        elif event.button() == Qt.MouseButton.LeftButton:
            self._start_drag(layout, point)
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue the drag, and show what is under the cursor."""
        layout, point = self.plan_layout, event.position().toTuple()
        if not layout or self._pans(event):
            return
        is_far = self._pressed is not None and self._far(event.position())
        self._follow_cursor(point, is_drag=bool(self._strokes.is_going_on or self._dragged or is_far))
        self._dragged_to(layout, point)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag; what was drawn becomes an obstacle, or painted cells."""
        if self._pans(event):
            return
        if event.button() != Qt.MouseButton.LeftButton and not self._strokes.is_going_on:
            return
        band, painted = self._rubber_band, self._strokes.end()
        self._end_drag()
        self._tell(painted)
        if band and self._brush is None:
            self.drawn.emit(*band[0], *band[1])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Arrows move the handle used last by a cell; Escape cancels a drag."""
        if event.key() == Qt.Key.Key_Space:
            self._space_held = True
            return
        if self._brush is not None and self._paint_by_key(event):
            return
        step, grip, layout = _STEPS.get(Qt.Key(event.key())), self._active_or_selected(), self.plan_layout
        cell = cell_of(self._handles, grip) if grip else None
        if event.key() == Qt.Key.Key_Escape and (self._rubber_band or self._dragged or self._strokes.is_going_on):
            self._end_drag()
        elif step and grip and cell and layout:
            self._active_grip, self._end_switched = grip, False
            self._move(grip, layout.moved(cell, step))
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Space paints the cell of the keyboard, unless it was held to move the plan."""
        if event.key() != Qt.Key.Key_Space or event.isAutoRepeat():
            super().keyReleaseEvent(event)
            return
        is_press, self._space_held = self._space_held and not self._panned, False
        self._panned = False
        if is_press and self._brush is not None:
            self._tell(self._strokes.paint_here(self._brush.level))

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

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Let go of Space, whose release another widget gets."""
        self._space_held = self._panned = False
        super().focusOutEvent(event)

    def _is_empty(self, layout: PlanLayout, point: Point) -> bool:
        """Return whether there is neither a handle nor, while painting, a cell."""
        if self._brush is not None:
            return not self._cell_at(layout, point)
        return grip_at(self._handles, self._selected, layout, point) is None

    def _dragged_to(self, layout: PlanLayout, point: Point) -> None:
        """Continue what is being dragged, drawn or painted."""
        block = layout.nearest_block(point)
        if self._strokes.is_going_on:
            self._tell(self._strokes.go_to(block))
        elif self._dragged:
            self._move(self._dragged, block)
        elif self._pressed and self._far(QPointF(*point)):
            self._rubber_band = (self._rubber_band or (layout.nearest_block(self._pressed.toTuple()),))[0], block
        self.update()

    def _start_drag(self, layout: PlanLayout, point: Point) -> None:
        """Take the handle under a point, or else start to draw."""
        self._dragged = grip_at(self._handles, self._selected, layout, point)
        self._end_switched = False
        if self._dragged:
            self._active_grip = self._dragged
            if self._dragged.row != self._selected:
                self.chosen.emit(self._dragged.row)
        elif self._cell_at(layout, point):
            self._pressed = QPointF(*point)

    def _start_stroke(self, layout: PlanLayout, point: Point, brush: Brush, *, erases: bool) -> None:
        cell = self._cell_at(layout, point)
        block = layout.block_of(cell) if cell else None
        if not block or not self._scene:
            return
        levels = self._scene.field.blocks
        if brush.tool is Tool.PICK:
            self.picked.emit(int(levels[block]))
        else:
            self._tell(self._strokes.begin(brush, block, levels, erases=erases))

    def _paint_by_key(self, event: QKeyEvent) -> bool:
        """Arrows move, a digit sets the level of the cell and moves on, Backspace erases."""
        layout, key, typed = self.plan_layout, Qt.Key(event.key()), event.text()
        levels = {"\b": UNPAINTED} | {str(digit): digit for digit in range(10)}
        if not layout or not (key in _STEPS or typed in levels):
            return False
        self._strokes.cursor = layout.moved(self._strokes.cursor, _STEPS.get(key, (0, 0)))
        if key not in _STEPS:
            self._tell(self._strokes.paint_here(levels[typed]))
            if typed.isdigit():
                size = len(layout.blocks[0]), len(layout.blocks[1])
                self._strokes.cursor = next_cell(self._strokes.cursor, size)
        self.update()
        return True

    def _tell(self, painted: Painted | None) -> None:
        if painted:
            self.painted.emit(*painted)
        self.update()

    def _active_or_selected(self) -> Grip | None:
        """The handle that the keyboard moves: the one used last, or else one of the selected obstacle."""
        if self._active_grip or self._selected is None:
            return self._active_grip
        ends = (Grip(self._selected, end) for end in ENDS)
        return next((grip for grip in ends if cell_of(self._handles, grip)), None)

    def _keyboard_cell(self, layout: PlanLayout) -> Cell | None:
        """The block cell that the keyboard moves or paints."""
        if self._brush is not None:
            return layout.moved(self._strokes.cursor, (0, 0))
        grip = self._active_or_selected()
        return cell_of(self._handles, grip) if grip else None

    def _move(self, grip: Grip, cell: Cell) -> None:
        before = cell_of(self._handles, grip)
        self._handles = moved(self._handles, grip, cell, self.cells or (0, 0))
        if (now := cell_of(self._handles, grip)) and now != before:
            self.update()
            self.moved.emit(grip.row, grip.end, *now)

    def _far(self, point: QPointF) -> bool:
        """Return whether a press has become a drag."""
        start = self._pressed or point
        return self._rubber_band is not None or (point - start).manhattanLength() >= QApplication.startDragDistance()

    def _end_drag(self) -> None:
        self._dragged = self._pressed = self._rubber_band = None
        self._strokes.cancel()
        self._scroll.stop()
        self.update()
