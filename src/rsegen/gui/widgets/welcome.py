"""What an empty window says: how to begin, and three examples to start from."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QToolButton

from rsegen.exporters.scene import compose
from rsegen.gui.widgets.named import named
from rsegen.gui.widgets.plan_painting import square_icon
from rsegen.io.recipe_file import load
from rsegen.recipe.examples import EXAMPLES

SIDE = 64
"""The side of a picture in pixels."""

_SHOWN = ("mixed-course", "turtlebot", "red-diagonal-pallet")
_TEXT = """<b>This map is still flat.</b><br>
Choose an obstacle type on the left: it is shown pale where it would lie. <b>+&nbsp;Add</b> puts it into the list.<br>
Or draw one on the plan with the mouse. Or start from an example:"""


class Welcome(QFrame):
    """`chosen` gives the file of an example; `more` asks for all examples. It is empty until it is shown."""

    chosen = Signal(Path)
    more = Signal()

    def __init__(self) -> None:
        super().__init__()
        named(self, "welcome", title="how to begin")
        self.setFrameShape(QFrame.Shape.StyledPanel)

    def showEvent(self, event: QShowEvent) -> None:
        """Fill the panel: the maps of its pictures are made only for those who see them."""
        if self.layout() is None:
            self._fill()
        super().showEvent(event)

    def _fill(self) -> None:
        row = QHBoxLayout(self)
        text = QLabel(_TEXT, wordWrap=True, textFormat=Qt.TextFormat.RichText)
        row.addWidget(text, stretch=1)
        for name in _SHOWN:
            row.addWidget(self._example(name))
        more = named(QToolButton(), "more_examples", title="more examples", tip="all examples (Ctrl+Shift+N)")
        more.setText("More...")
        more.clicked.connect(self.more)
        row.addWidget(more)

    def _example(self, name: str) -> QToolButton:
        path = EXAMPLES[name]
        recipe = load(path)
        button = named(QToolButton(), f"example_{name}", title=f"example {name}", tip=recipe.description)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        button.setIcon(square_icon(compose(recipe, recipe.first_map), SIDE))
        button.setIconSize(QSize(SIDE, SIDE))
        button.setText(name)
        button.clicked.connect(lambda: self.chosen.emit(path))
        return button
