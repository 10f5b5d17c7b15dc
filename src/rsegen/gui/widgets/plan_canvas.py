"""The plan of a map that can be zoomed, moved, read and saved; what a robot can do is painted on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PySide6.QtCore import QEvent, QMarginsF, QPointF, QRect, QRectF, QSize, QSizeF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QBrush,
    QColor,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPageSize,
    QPaintDevice,
    QPainter,
    QPalette,
    QPdfWriter,
    QPen,
    QPixmap,
    QPolygonF,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from rsegen.errors import FileError, UnknownName
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Array, StepField
from rsegen.gui.model.plan_layout import Box, PlanLayout, Point, describe_cell, fit, resized, shifted, zoomed
from rsegen.gui.model.reach import EASTWARD, NORTHWARD, Reach, Way, corners
from rsegen.gui.widgets import plan_painting
from rsegen.params.sorts import Cell

_VEIL = (245, 245, 245, 195)
"""Blocks beyond the largest area of the robot are nearly white."""

_EASTWARD, _NORTHWARD = QColor(*EASTWARD), QColor(*NORTHWARD)
_PAPER, _INK = QColor(255, 255, 255), QColor(20, 20, 20)


def paint_reach(painter: QPainter, field: StepField, layout: PlanLayout, reach: Reach) -> None:
    """Paint a veil over the blocks that a robot does not reach, its ways across, and its start and goal."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)  # noqa: FBT003  # Qt's
    painter.drawImage(QRectF(*layout.area), _veil(field, reach))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for way in reach.ways:
        _paint_way(painter, _pixels(field, layout, way.points), way)
    for name, spot in zip(("S", "G"), reach.spots, strict=False):
        _paint_spot(painter, _pixels(field, layout, corners(reach.outline, spot)), name)
    painter.restore()


def _veil(field: StepField, reach: Reach) -> QImage:
    """A pixel for every cell, north up, transparent where the robot is."""
    pixels = np.zeros((*field.shape, 4), dtype=np.uint8)
    pixels[~reach.region & ~field.frame] = _VEIL
    upright = np.ascontiguousarray(pixels.transpose(1, 0, 2)[::-1])
    height, width = upright.shape[:2]
    return QImage(upright.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()


def _pixels(field: StepField, layout: PlanLayout, points: Array) -> QPolygonF:
    """Points of the map [m] on the plan."""
    cells = (points + np.array(field.extent) / 2) / field.block_width
    return QPolygonF(
        [QPointF(layout.left + x * layout.side, layout.bottom - y * layout.side) for x, y in cells.tolist()]
    )


def _paint_way(painter: QPainter, points: QPolygonF, way: Way) -> None:
    """Paint a way from a ring to a dot, dashed if the robot cannot drive it."""
    colour = _EASTWARD if way.is_eastward else _NORTHWARD
    style = Qt.PenStyle.DashLine if way.is_too_steep else Qt.PenStyle.SolidLine
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for ink, width, dashes in ((_PAPER, 5.0, Qt.PenStyle.SolidLine), (colour, 2.5, style)):
        painter.setPen(QPen(ink, width, dashes, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin))
        painter.drawPolyline(points)
    for point, fill in ((points.first(), _PAPER), (points.last(), colour)):
        painter.setPen(QPen(colour, 2))
        painter.setBrush(fill)
        painter.drawEllipse(point, 4.5, 4.5)


def _paint_spot(painter: QPainter, outline: QPolygonF, name: str) -> None:
    """Paint the outline of a robot, its front thick, with a letter: S for the start, G for the goal."""
    painter.setPen(QPen(_INK, 1.5))
    painter.setBrush(QBrush(QColor(255, 255, 255, 170)))
    painter.drawPolygon(outline)
    painter.setPen(QPen(_INK, 4))
    painter.drawLine(outline.at(2), outline.at(3))
    middle = outline.boundingRect().center()
    font = painter.font()
    font.setPixelSize(12)
    font.setBold(True)
    painter.setFont(font)
    for ink, (x, y) in ((_PAPER, (1, 1)), (_PAPER, (-1, -1)), (_INK, (0, 0))):
        painter.setPen(ink)
        painter.drawText(QRectF(middle.x() - 12 + x, middle.y() - 9 + y, 24, 18), Qt.AlignmentFlag.AlignCenter, name)


Paint = Callable[[QPainter], None]
_FINE = 4
"""Pixels of a PNG file per pixel of the plan."""


def save_plan(path: Path, size: QSize, paint: Paint) -> None:
    """Write what `paint` paints on an area of some pixels, in the format of the suffix; a FileError if that fails."""
    write = WRITERS.get(path.suffix.lower())
    if write is None:
        raise UnknownName.among(f"{path}", "suffix of a plan", path.suffix, WRITERS)
    try:
        path.open("ab").close()
        written = write(path, size, paint)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None
    if not written:
        raise FileError(f"{path}: cannot be written")


def _svg(path: Path, size: QSize, paint: Paint) -> bool:
    from PySide6.QtSvg import QSvgGenerator

    generator = QSvgGenerator()
    generator.setFileName(str(path))
    generator.setSize(size)
    generator.setViewBox(QRect(0, 0, size.width(), size.height()))
    generator.setTitle("rsegen: plan of a map")
    return _painted(generator, paint)


def _pdf(path: Path, size: QSize, paint: Paint) -> bool:
    writer = QPdfWriter(str(path))
    writer.setResolution(72)
    writer.setPageSize(QPageSize(QSizeF(size), QPageSize.Unit.Point))
    writer.setPageMargins(QMarginsF())
    writer.setTitle("rsegen: plan of a map")
    return _painted(writer, paint)


def _png(path: Path, size: QSize, paint: Paint) -> bool:
    image = QImage(size * _FINE, QImage.Format.Format_ARGB32)
    image.setDevicePixelRatio(_FINE)
    image.fill(Qt.GlobalColor.white)
    return _painted(image, paint) and image.save(str(path))


def _painted(device: QPaintDevice, paint: Paint) -> bool:
    painter = QPainter()
    if not painter.begin(device):
        return False
    paint(painter)
    return painter.end()


WRITERS: Mapping[str, Callable[[Path, QSize, Paint], bool]] = {".svg": _svg, ".pdf": _pdf, ".png": _png}
"""The formats by their suffix."""

_ZOOMS: dict[int, float] = {Qt.Key.Key_Plus: 1.25, Qt.Key.Key_Equal: 1.25, Qt.Key.Key_Minus: 0.8}
_STEP = 12.0
_PAUSE = 30
"""While a drag is beyond the edge, the plan moves by this many pixels each of these milliseconds."""


class PlanCanvas(QWidget):
    """A scene from above, north up, at a zoom of its own.

    hovered: what is under the cursor, empty outside the map.
    """

    hovered = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._scene: Scene | None = None
        self._layout: PlanLayout | None = None
        self._reach: Reach | None = None
        self._area: Box = (0, 0, 0, 0)
        self._is_zoomed = False
        self._cells_pixmap: QPixmap | None = None
        self._cursor_point: Point | None = None
        self._pan: tuple[Qt.MouseButton, QPointF] | None = None
        self._space_held = self._panned = False
        self._scroll = QTimer(self, interval=_PAUSE)
        self._scroll.timeout.connect(self._scroll_on)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    @property
    def cells(self) -> Cell | None:
        """The number of block cells along x and y of the scene that is shown."""
        return self._scene.recipe.grid.shape if self._scene else None

    @property
    def plan_layout(self) -> PlanLayout | None:
        """Where the cells are now; None without a scene."""
        if self._scene and not self._layout:
            self._area = plan_painting.plan_area(self.width(), self.height())
            self._layout = fit(self._scene.field, self._area, self.devicePixelRatio())
        return self._layout

    def show_scene(self, scene: Scene) -> None:
        """Show a scene; one of the same size at the present zoom."""
        if scene is not self._scene:
            self._scene, self._reach = scene, None
            self._relayout()

    def show_reach(self, reach: Reach | None) -> None:
        """Show what a robot can do on the map, on which it was computed; None shows nothing."""
        if reach is not self._reach:
            self._reach = reach
            self._repaint_cells()

    def fit(self) -> None:
        """Show the whole map."""
        self._layout, self._is_zoomed = None, False
        self._repaint_cells()

    def zoom(self, factor: float, at: Point | None = None) -> None:
        """Come closer by a factor, or go away, around a point; by default around the middle."""
        layout = self.plan_layout
        if layout and self._scene:
            left, top, width, height = self._area
            fitted = fit(self._scene.field, self._area, self.devicePixelRatio())
            self._layout = zoomed(layout, fitted, self._area, at or (left + width / 2, top + height / 2), factor)
            self._is_zoomed = self._layout != fitted
            self._repaint_cells()

    def save(self, path: Path) -> None:
        """Write the whole plan with its rulers in the format of the suffix: .svg, .pdf or .png."""
        if not self._scene:
            return
        scene, size = self._scene, plan_painting.file_size(self._scene)
        layout = fit(scene.field, plan_painting.plan_area(size.width(), size.height()))

        def paint(painter: QPainter) -> None:
            painter.setFont(self.font())
            plan_painting.paint_vector_cells(painter, scene, layout)
            plan_painting.paint_grid(painter, scene, layout)
            self._paint_on_cells(painter, layout)
            plan_painting.paint_rulers(painter, layout, layout.area, QColor("black"), QColor("white"))

        save_plan(path, size, paint)

    def sizeHint(self) -> QSize:
        """Large enough to write heights into a map of twenty cells a side."""
        return QSize(480, 480)

    def minimumSizeHint(self) -> QSize:
        """The smallest legible plan."""
        return QSize(160, 160)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom at the cursor."""
        self.zoom(1.2 ** (event.angleDelta().y() / 120), event.position().toTuple())
        event.accept()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Show the whole map after a double click on nothing that can be taken or painted; else it is a press."""
        layout, is_left = self.plan_layout, event.button() == Qt.MouseButton.LeftButton
        if layout and is_left and not self._space_held and self._is_empty(layout, event.position().toTuple()):
            self.fit()
        else:
            self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """+ and - zoom at the cursor."""
        if event.key() in _ZOOMS:
            self.zoom(_ZOOMS[event.key()], self._cursor_point)
        else:
            super().keyPressEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Show that nothing is under the cursor."""
        self._cursor_point = None
        self._show_cell()
        super().leaveEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit the plan to the new size."""
        self._relayout()
        super().resizeEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        """Repaint when the colours or fonts of the desktop change."""
        self._cells_pixmap = None
        super().changeEvent(event)

    # For PlanView.

    def _pans(self, event: QMouseEvent) -> bool:
        """Return whether a mouse event moves the plan: of the middle button, or the left with Space; then do it."""
        if event.type() in {QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick}:
            if event.button() == (Qt.MouseButton.LeftButton if self._space_held else Qt.MouseButton.MiddleButton):
                self._pan = event.button(), event.position()
            return self._pan is not None
        if not self._pan:
            return False
        button, before = self._pan
        if event.type() == QEvent.Type.MouseMove:
            self._pan, self._panned = (button, event.position()), True
            self._shift((event.position() - before).toTuple())
            return True
        self._pan = None if event.button() == button else self._pan
        return self._pan is None

    def _follow_cursor(self, point: Point, *, is_drag: bool) -> None:
        """Show what is under the cursor; while a drag is beyond the edge, the plan moves along."""
        self._cursor_point = point
        self._show_cell()
        if is_drag and self._beyond_edge() != (0, 0):
            self._scroll.start()
        else:
            self._scroll.stop()

    def _is_empty(self, layout: PlanLayout, point: Point) -> bool:
        """Return whether there is nothing at a point that a press would take or paint."""
        return True

    def _dragged_to(self, layout: PlanLayout, point: Point) -> None:
        """Continue a drag, also if the plan moves under a cursor that rests."""

    def _paint_on_cells(self, painter: QPainter, layout: PlanLayout) -> None:
        """Paint what a robot can do on the map."""
        if self._reach and self._scene:
            paint_reach(painter, self._scene.field, layout, self._reach)

    def _painted_cells(self, scene: Scene, layout: PlanLayout) -> QPixmap:
        """The cells and what belongs to them, painted once as long as nothing changes."""
        ratio = self.devicePixelRatio()
        if self._cells_pixmap is None or self._cells_pixmap.devicePixelRatio() != ratio:
            self._cells_pixmap = QPixmap(self.size() * ratio)
            self._cells_pixmap.setDevicePixelRatio(ratio)
            self._cells_pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._cells_pixmap)
            painter.setFont(self.font())
            plan_painting.clip(painter, self._area)
            plan_painting.paint_cells(painter, scene, layout)
            plan_painting.paint_grid(painter, scene, layout, self._area)
            self._paint_on_cells(painter, layout)
            painter.setClipping(False)  # Qt takes no name
            paper = self.palette().color(QPalette.ColorRole.Window)
            plan_painting.paint_rulers(painter, layout, self._area, self._ink, paper)
            painter.end()
        return self._cells_pixmap

    @property
    def _ink(self) -> QColor:
        return self.palette().color(QPalette.ColorRole.WindowText)

    def _repaint_cells(self) -> None:
        self._cells_pixmap = None
        self._show_cell()
        self.update()

    def _relayout(self) -> None:
        """The same part of the map in another size of the widget, or of a map of the same size."""
        before, area = self._layout, self._area
        self._layout = None
        if self._is_zoomed and before and (fitted := self.plan_layout):
            self._layout = resized(before, fitted, area, self._area)
            self._is_zoomed = self._layout != fitted
        self._repaint_cells()

    def _shift(self, by: Point) -> None:
        if layout := self.plan_layout:
            self._layout = shifted(layout, self._area, by)
            self._repaint_cells()

    def _beyond_edge(self) -> Point:
        """The direction in which the cursor is beyond the edge of the plan, one pixel before it included."""
        (left, top, width, height), (x, y) = self._area, self._cursor_point or (self._area[0] + 1, self._area[1] + 1)
        return float((x < left) - (x >= left + width - 1)), float((y < top) - (y >= top + height - 1))

    def _scroll_on(self) -> None:
        x, y = self._beyond_edge()
        self._shift((x * _STEP, y * _STEP))
        if self._layout and self._cursor_point:
            self._dragged_to(self._layout, self._cursor_point)

    def _show_cell(self) -> None:
        """Emit what is under the cursor if that has changed, be it by the mouse or by the map."""
        layout = self.plan_layout
        cell = self._cell_at(layout, self._cursor_point) if layout and self._cursor_point else None
        text = describe_cell(self._scene, layout, cell) if self._scene and layout and cell else ""
        if text != self.toolTip():
            self.setToolTip(text)
            self.hovered.emit(text)

    def _cell_at(self, layout: PlanLayout, point: Point) -> Cell | None:
        """The field cell that is seen at a point, None outside the map and on the rulers."""
        left, top, width, height = self._area
        is_seen = left <= point[0] < left + width and top <= point[1] < top + height
        return layout.cell_at(point) if is_seen else None
