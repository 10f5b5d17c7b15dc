"""Painting of the plan: cells with their heights, rulers, handles, the rubber band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QIcon, QImage, QPainter, QPen, QPixmap

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import CellWindow, Mask
from rsegen.geometry.rectangles import merge
from rsegen.gui.model.colours import GROUND, bright, cells
from rsegen.gui.model.obstacle_ends import ENDS, GRIP, End, Ghost, Handle
from rsegen.gui.model.plan_layout import Box, PlanLayout, ticks, visible
from rsegen.params.sorts import Cell

RULER = 26
"""The width of a ruler in pixels."""

_RIM = 6.0

_LINED = 5
_WRITTEN = 17
"""Lines between cells, and heights in them, are painted if cells have at least this many pixels."""

_INK = QColor(20, 20, 20)
_PAPER = QColor(255, 255, 255)
_LINE = QColor(0, 0, 0, 70)
_COVERED = 210
"""The opacity of paper behind the numbers of rulers."""


def plan_area(width: int, height: int) -> Box:
    """The area of a widget that is left for the map by its rulers."""
    return RULER + _RIM, _RIM, width - RULER - 2 * _RIM, height - RULER - _RIM


def file_size(scene: Scene) -> QSize:
    """The size of the whole plan in a file, its cells large enough for heights unless there are very many."""
    n_x, n_y = scene.field.shape
    side = int(np.clip(2400 / max(n_x, n_y), 2, 24))
    return QSize(int(n_x * side + RULER + 2 * _RIM), int(n_y * side + RULER + _RIM))


def clip(painter: QPainter, area: Box, margin: float = 0.0) -> None:
    """Paint inside an area, and a margin around it, alone."""
    left, top, width, height = area
    painter.setClipRect(QRectF(left - margin, top - margin, width + 2 * margin, height + 2 * margin))


def paint_cells(painter: QPainter, scene: Scene, layout: PlanLayout) -> None:
    """Paint every cell in its colour; if cells are smaller than pixels, their mean."""
    ratio, image = painter.device().devicePixelRatioF(), ground_image(scene, _frame_share(layout))
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, layout.side * ratio < 1)
    if layout.side * ratio < 1:
        width, height = (max(round(side * ratio), 1) for side in layout.area[2:])
        smooth = Qt.TransformationMode.SmoothTransformation
        image = image.scaled(width, height, Qt.AspectRatioMode.IgnoreAspectRatio, smooth)
    painter.drawImage(QRectF(*layout.area), image)


def paint_vector_cells(painter: QPainter, scene: Scene, layout: PlanLayout) -> None:
    """Paint every cell in its colour, as few rectangles."""
    colours = cells(scene).astype(np.int64)
    found = merge((colours * [65536, 256, 1]).sum(axis=2) + 1)
    for colour, x1, x2, y1, y2 in zip(*(column.tolist() for column in found), strict=True):
        box = layout.box((x1, y1), (x2 - 1, y2 - 1))
        painter.fillRect(QRectF(*box), QColor.fromRgb(colour - 1))


def paint_grid(painter: QPainter, scene: Scene, layout: PlanLayout, area: Box | None = None) -> None:
    """Paint lines between the cells of an area, and their heights in centimetres, if there is room."""
    seen = visible(layout, area or layout.area)
    if layout.side >= _LINED:
        _paint_lines(painter, layout, seen)
    if layout.side >= _WRITTEN:
        _write_heights(painter, scene, layout, seen)


def paint_ghost(painter: QPainter, ghost: Ghost, layout: PlanLayout) -> None:
    """Paint the cells of an obstacle that is not yet in the list: pale, hatched, with a dashed rim."""
    shown = ground_image(ghost.scene).convertToFormat(QImage.Format.Format_ARGB32)
    shown.setAlphaChannel(_mask_image(ghost.cells, 150))
    painter.drawImage(QRectF(*layout.area), shown)
    i, j = (np.flatnonzero(ghost.cells.any(axis=1 - axis)) for axis in (0, 1))
    if len(i):
        painter.setPen(QPen(_INK, 1.5, Qt.PenStyle.DashLine))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(QRectF(*layout.box((int(i[0]), int(j[0])), (int(i[-1]), int(j[-1])))))


def _mask_image(cells: Mask, alpha: int) -> QImage:
    """The opacity of every cell, north up."""
    upright = np.ascontiguousarray(cells.T[::-1] * np.uint8(alpha))
    height, width = upright.shape
    return QImage(upright.tobytes(), width, height, width, QImage.Format.Format_Alpha8).copy()


def ground_image(scene: Scene, frame_share: float = 1.0) -> QImage:
    """A pixel for every cell, in its colour, north up; of the colour of frames only a share, of the ground the rest."""
    colours = cells(scene)
    if frame_share < 1:
        frame = scene.field.frame
        mixed = frame_share * colours[frame] + (1 - frame_share) * np.array(GROUND)
        colours[frame] = np.round(mixed).astype(np.uint8)
    upright = np.ascontiguousarray(colours.transpose(1, 0, 2)[::-1])
    height, width = upright.shape[:2]
    return QImage(upright.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888).copy()


def square_image(scene: Scene, side: int) -> QImage:
    """The map from above, centred in a square of some pixels a side."""
    plan = ground_image(scene).scaled(side, side, Qt.AspectRatioMode.KeepAspectRatio)
    square = QImage(side, side, QImage.Format.Format_ARGB32_Premultiplied)
    square.fill(Qt.GlobalColor.transparent)
    painter = QPainter(square)
    painter.drawImage((side - plan.width()) // 2, (side - plan.height()) // 2, plan)
    painter.end()
    return square


def square_icon(scene: Scene, side: int) -> QIcon:
    """The same as an icon."""
    return QIcon(QPixmap.fromImage(square_image(scene, side)))


def paint_rulers(painter: QPainter, layout: PlanLayout, area: Box, ink: QColor, paper: QColor) -> None:
    """Paint the numbers of the block cells in an area, below the map and to its left, over what else is there."""
    font = QFont(painter.font())
    font.setPixelSize(11)
    painter.setFont(font)
    letters = painter.fontMetrics()
    left, top, width, height = area
    start, bottom = max(layout.left, left), min(layout.bottom, top + height)
    n_x, n_y = map(len, layout.blocks)
    for x in ticks(n_x, layout.side, room=max(30, letters.horizontalAdvance(str(n_x)) + 9)):
        middle = layout.middle((x, 0))[0]
        if left <= middle <= left + width:
            place = QRectF(middle - RULER, bottom + 2, 2 * RULER, 16)
            _write_number(painter, place, Qt.AlignmentFlag.AlignHCenter, str(x), (ink, paper))
    for y in ticks(n_y, layout.side, room=max(18, letters.height() + 2)):
        middle = layout.middle((0, y))[1]
        if top <= middle <= top + height:
            place = QRectF(start - RULER - 4, middle - 8, RULER, 16)
            _write_number(painter, place, Qt.AlignmentFlag.AlignRight, str(y), (ink, paper))


def _write_number(
    painter: QPainter, place: QRectF, side: Qt.AlignmentFlag, text: str, colours: tuple[QColor, QColor]
) -> None:
    """Write a number of a ruler in an ink, on paper, as the end of a way may be under it."""
    ink, paper = colours
    flags = side | Qt.AlignmentFlag.AlignVCenter
    paper.setAlpha(_COVERED)
    painter.fillRect(painter.boundingRect(place, flags, text).adjusted(-1, 1, 1, -1), paper)
    painter.setPen(ink)
    painter.drawText(place, flags, text)


def paint_handles(painter: QPainter, layout: PlanLayout, handles: Sequence[Handle], selected: int | None) -> None:
    """Paint the ends of all obstacles: a square for the first, a circle for the last; the selected one's large.

    The selected one has a cross between them, which moves both.
    """
    for handle in sorted(handles, key=lambda handle: handle.row == selected):
        chosen = handle.row == selected
        painter.setOpacity(1.0 if chosen else 0.8)
        if handle.first and handle.last:
            _paint_joint(painter, layout, handle.first, handle.last, 2.0 if chosen else 1.0)
        for end in ENDS:
            if cell := handle.end(end):
                _paint_grip(painter, QPointF(*layout.middle(cell)), end, GRIP if chosen else GRIP * 0.6)
        if chosen and handle.shows_middle(layout) and (cell := handle.end("both")):
            _paint_cross(painter, QPointF(*layout.middle(cell)))
    painter.setOpacity(1.0)


def paint_active(painter: QPainter, layout: PlanLayout, cell: Cell, ink: QColor) -> None:
    """Paint a ring around the handle that the keyboard moves."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for width, colour in ((5.0, _PAPER), (2.5, ink)):
        painter.setPen(QPen(colour, width))
        painter.drawEllipse(QPointF(*layout.middle(cell)), GRIP * 1.7, GRIP * 1.7)


def paint_rubber_band(painter: QPainter, layout: PlanLayout, first: Cell, last: Cell) -> None:
    """Paint the obstacle that is being drawn: the cells between its ends, and the line between them."""
    painter.setPen(QPen(_INK, 1.5, Qt.PenStyle.DashLine))
    painter.setBrush(QColor(255, 255, 255, 90))
    painter.drawRect(QRectF(*layout.box(layout.cell_of(first), layout.cell_of(last))))
    _paint_joint(painter, layout, first, last, 2.0)
    for end, cell in zip(ENDS, (first, last), strict=True):
        _paint_grip(painter, QPointF(*layout.middle(cell)), end, GRIP)


def paint_band(painter: QPainter, layout: PlanLayout, first: Cell, last: Cell) -> None:
    """Paint the outline of the cells that will be painted."""
    painter.setBrush(QColor(255, 255, 255, 90))
    painter.setPen(QPen(_INK, 1.5, Qt.PenStyle.DashLine))
    painter.drawRect(QRectF(*layout.box(layout.cell_of(first), layout.cell_of(last))))


def _frame_share(layout: PlanLayout) -> float:
    """How much of their colour frames have: less if cells are small, so that they do not hide heights."""
    return float(np.clip(layout.side / _LINED, 0.15, 1))


def _paint_lines(painter: QPainter, layout: PlanLayout, seen: CellWindow) -> None:
    """Paint lines between cells, a pixel wide."""
    left, top, width, height = layout.area
    along, up = (range(part.start, part.stop + 1) for part in seen)
    lines = [QLineF(left + i * layout.side, top, left + i * layout.side, top + height) for i in along]
    lines += [QLineF(left, layout.bottom - j * layout.side, left + width, layout.bottom - j * layout.side) for j in up]
    painter.setPen(QPen(_LINE, 0))
    painter.drawLines(lines)


def _write_heights(painter: QPainter, scene: Scene, layout: PlanLayout, seen: CellWindow) -> None:
    """Write centimetres into each cell that is no frame, in a colour that is legible on it."""
    texts = {level: decimal(round(level * scene.field.unit * 100, 4)) for level in scene.field.level_counts()}
    font = QFont(painter.font())
    longest = max(map(len, texts.values()), default=1)
    font.setPixelSize(max(int(min(layout.side * 0.45, layout.side * 1.5 / longest, 15)), 5))
    painter.setFont(font)
    light, start = bright(cells(scene)), np.array([part.start for part in seen])
    for i, j in np.argwhere(~scene.field.frame[seen]) + start:
        painter.setPen(_INK if light[i, j] else _PAPER)
        box = QRectF(*layout.box((int(i), int(j)), (int(i), int(j))))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, texts[int(scene.field.levels[i, j])])


def _paint_joint(painter: QPainter, layout: PlanLayout, first: Cell, last: Cell, width: float) -> None:
    ends = QPointF(*layout.middle(first)), QPointF(*layout.middle(last))
    for colour, stroke in ((_PAPER, width + 2), (_INK, width)):
        painter.setPen(QPen(colour, stroke))
        painter.drawLine(*ends)


def _paint_cross(painter: QPainter, middle: QPointF) -> None:
    for colour, width in ((_PAPER, 5.0), (_INK, 2.2)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        for x, y in ((GRIP, 0), (0, GRIP)):
            painter.drawLine(middle - QPointF(x, y), middle + QPointF(x, y))


def _paint_grip(painter: QPainter, middle: QPointF, end: End, half: float) -> None:
    painter.setPen(QPen(_INK, 1.8))
    painter.setBrush(_PAPER)
    if end == "first":
        painter.drawRect(QRectF(middle.x() - half, middle.y() - half, 2 * half, 2 * half))
    else:
        painter.drawEllipse(middle, half, half)
