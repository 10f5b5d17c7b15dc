"""Pictures that lie over the 3D view: the legend of its heights, and a scale bar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QGuiApplication, QImage, QPainter, QPen

from rsegen.gui.model.colours import Rgb

_PAD = 8.0
_TEXT = 12


class Inks(NamedTuple):
    """The colours of pictures over the view: below the text, and of the text."""

    paper: QColor
    ink: QColor


def legend_image(rows: Sequence[tuple[Rgb, str]], note: str, height: float, inks: Inks, scale: float) -> QImage:
    """Colours with their names and a note below, in at most a height; rows that have no room there are left out.

    Lengths are in pixels before they are multiplied by the scale.
    """
    metrics = QFontMetricsF(_font())
    row = metrics.height() + 3
    notes = note.splitlines()
    step = _step(len(rows), int((height - 2 * _PAD) / row) - len(notes))
    shown = [*rows[:-1:step], *rows[-1:]] if step else []
    longest = max((metrics.horizontalAdvance(text) for text in [*(name for _, name in shown), *notes]), default=0)
    side = metrics.ascent()
    image, painter = _blank(side + longest + 3 * _PAD, (len(shown) + len(notes)) * row + 2 * _PAD, inks, scale)
    for number, (colour, name) in enumerate(shown):
        y = _PAD + number * row
        painter.fillRect(QRectF(_PAD, y + (row - side) / 2, side, side), QColor(*colour))
        painter.drawText(QRectF(2 * _PAD + side, y, longest + 1, row), Qt.AlignmentFlag.AlignVCenter, name)
    for number, line in enumerate(notes):
        y = _PAD + (len(shown) + number) * row
        painter.drawText(QRectF(_PAD, y, longest + side + _PAD, row), Qt.AlignmentFlag.AlignVCenter, line)
    painter.end()
    return image


def scale_bar_image(text: str, width: float, inks: Inks, scale: float) -> QImage:
    """A bar of a width in pixels with its length as text, all multiplied by the scale."""
    metrics = QFontMetricsF(_font())
    total = max(width, metrics.horizontalAdvance(text)) + 2 * _PAD
    image, painter = _blank(total, metrics.height() + 9 + _PAD, inks, scale)
    left, y = (total - width) / 2, metrics.height() + 8
    painter.drawText(QRectF(0, 3, total, metrics.height()), Qt.AlignmentFlag.AlignHCenter, text)
    painter.setPen(QPen(inks.ink, 2))
    painter.drawPolyline([QRectF(left, y - 4, width, 4).topLeft(), QRectF(left, y, 0, 0).topLeft()])
    painter.drawLine(int(left), int(y), int(left + width), int(y))
    painter.drawLine(int(left + width), int(y - 4), int(left + width), int(y))
    painter.end()
    return image


def _step(rows: int, room: int) -> int:
    """Every which row is shown, the last aside, so that all have room; 0 if there are none."""
    return max(-(-(rows - 1) // max(room - 1, 1)), 1) if rows else 0


def _font() -> QFont:
    font = QFont(QGuiApplication.font())
    font.setPixelSize(_TEXT)
    return font


def _blank(width: float, height: float, inks: Inks, scale: float) -> tuple[QImage, QPainter]:
    """A transparent image with round, translucent paper, and a painter of it."""
    image = QImage(round(width * scale), round(height * scale), QImage.Format.Format_RGBA8888)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(scale, scale)
    paper = QColor(inks.paper)
    paper.setAlphaF(0.75)
    painter.setBrush(paper)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.drawRoundedRect(QRectF(0, 0, width, height), 5, 5)
    painter.setPen(inks.ink)
    painter.setFont(_font())
    return image, painter
