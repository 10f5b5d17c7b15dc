"""What a robot can do on a map, painted on the plan: its largest area, ways across, a start and a goal."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPainter, QPen, QPolygonF

from rsegen.field.stepfield import Array, StepField
from rsegen.gui.model.plan_layout import PlanLayout
from rsegen.gui.model.reach import EASTWARD, NORTHWARD, Reach, Way, corners

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
