"""The list of obstacle kinds, each with a small picture of an obstacle of its defaults."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QComboBox

from rsegen.errors import RsegenError
from rsegen.exporters.scene import compose
from rsegen.field.obstacles import KINDS
from rsegen.gui.model.typed_cells import kind_words
from rsegen.gui.widgets.editors import shortened
from rsegen.gui.widgets.layouts import scroll_past
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.params.registry import summary
from rsegen.params.sorts import Json
from rsegen.recipe.codec import decode

SIDE = 32
"""The side of a picture in pixels."""


class KindBox(QComboBox):
    """Chooses a kind by its name in plain words; `chosen` is emitted when the user chooses another."""

    chosen = Signal()

    def __init__(self) -> None:
        super().__init__()
        named(self, "kind", title="obstacle type", tip="what the obstacle looks like")
        scroll_past(self)
        self.setIconSize(QSize(SIDE, SIDE))
        for kind, cls in KINDS.items():
            self.addItem(_picture(kind), kind_words(kind), kind)
            self.setItemData(self.count() - 1, summary(cls), Qt.ItemDataRole.ToolTipRole)
        self.currentIndexChanged.connect(lambda: self.chosen.emit())

    @property
    def kind(self) -> str:
        """The kind that is chosen; empty if an unknown one is shown."""
        return self.currentData() or ""

    def show_kind(self, kind: Json) -> None:
        """Show a kind without a signal; an unknown one as its text."""
        blocker = QSignalBlocker(self)
        self.setPlaceholderText(shortened(kind))
        self.setCurrentIndex(self.findData(kind))
        del blocker


def _picture(kind: str) -> QIcon:
    """A pallet with one obstacle of a kind; no picture of a plug-in's kind that needs more than its defaults."""
    row = {"kind": kind, "max_height": 5}
    try:
        scene = compose(decode({"seed": 3, "boundary": "none", "obstacles": [row]}), 0)
    except RsegenError:
        return QIcon()
    return square_icon(scene, SIDE)
