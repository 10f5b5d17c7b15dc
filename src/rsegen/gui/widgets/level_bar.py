"""A bar of the share of blocks of each level."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import QWidget

from rsegen.gui.model.colours import bright
from rsegen.gui.model.map_numbers import Share
from rsegen.gui.widgets.named import named

_LISTED = 24


class LevelBar(QWidget):
    """A coloured part per level, as long as its share of blocks; the tooltip has the counts."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "levels", title="blocks of each level")
        self._shares: Sequence[Share] = ()

    def show_shares(self, shares: Sequence[Share]) -> None:
        """Show these shares, from the lowest level."""
        self._shares = shares
        more = len(shares) - _LISTED
        lines = [f"{share.name}: {share.blocks:,} blocks" for share in shares[:_LISTED]]
        self.setToolTip("\n".join([*lines, *([f"and {more} more levels"] if more > 0 else [])]))
        self.setAccessibleDescription(self.toolTip())
        self.update()

    def sizeHint(self) -> QSize:
        """Room for a few heights."""
        return QSize(200, self.fontMetrics().height() + 4)

    def minimumSizeHint(self) -> QSize:
        """The smallest legible bar."""
        return QSize(80, self.fontMetrics().height() + 4)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint each part in its level's colour, with its height if there is room."""
        painter = QPainter(self)
        for share, part in self._parts():
            painter.fillRect(part, QColor(*share.colour))
            light = bool(bright(np.array(share.colour, dtype=np.uint8)))
            painter.setPen(Qt.GlobalColor.black if light else Qt.GlobalColor.white)
            if self.fontMetrics().horizontalAdvance(share.name) + 4 <= part.width():
                painter.drawText(part, Qt.AlignmentFlag.AlignCenter, share.name)
        painter.setPen(self.palette().color(QPalette.ColorRole.Mid))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _parts(self) -> Iterator[tuple[Share, QRectF]]:
        left, a_block = 0.0, self.width() / max(sum(share.blocks for share in self._shares), 1)
        for share in self._shares:
            yield share, QRectF(left, 0, share.blocks * a_block, self.height())
            left += share.blocks * a_block
