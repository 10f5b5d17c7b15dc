"""Where everything stands in the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import (
    QFrame,
    QGroupBox,
    QHBoxLayout,
    QScrollArea,
    QSplitter,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from rsegen.gui.editors import named

if TYPE_CHECKING:
    from rsegen.gui.window import Window


def lay_out(window: Window) -> QSplitter:
    """Forms and Start on the left; view, plan and list on the right; numbers below. Gives the two halves."""
    forms = QWidget()
    column = QVBoxLayout(forms)
    tabs = named(QTabWidget(), "tabs", title="parameters of the map")
    tabs.addTab(window.often, "Map")
    tabs.addTab(_Scrolled(window.seldom), "More")
    column.addWidget(tabs)
    column.addWidget(_group("Obstacle", window.obstacle, row_of(window.add, window.drop, window.clear)))
    column.addStretch(1)
    left = QWidget()
    stack = QVBoxLayout(left)
    stack.setContentsMargins(0, 0, 0, 0)
    stack.addWidget(_Scrolled(forms), stretch=1)
    for part in (window.warning, window.complaint, window.start_form):
        stack.addWidget(part)
    for notice in (window.warning, window.complaint):
        notice.setContentsMargins(10, 0, 10, 0)
    below = QSplitter()
    below.addWidget(_column(window.brushes, window.plan))
    below.addWidget(_group("Obstacles, imposed from the first to the last", window.rows))
    below.setStretchFactor(0, 1)
    below.setSizes([330, 520])
    right = QSplitter(Qt.Orientation.Vertical)
    right.addWidget(window.view)
    right.addWidget(below)
    right.setSizes([380, 320])
    halves = QSplitter()
    for widget, stretch in ((left, 0), (right, 1)):
        halves.addWidget(widget)
        halves.setStretchFactor(halves.count() - 1, stretch)
    window.setCentralWidget(halves)
    window.statusBar().addWidget(window.index)
    for number in (window.levels, window.numbers, window.costs, window.robot, window.crossing):
        window.statusBar().addWidget(number)
    window.statusBar().addPermanentWidget(window.cell)
    return halves


class _Scrolled(QScrollArea):
    """The content in as much height as there is, which it does not ask for."""

    def __init__(self, content: QWidget) -> None:
        super().__init__(widgetResizable=True)
        self.setWidget(content)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def sizeHint(self) -> QSize:
        """As wide as the content."""
        return QSize(super().sizeHint().width(), 0)


def row_of(*widgets: QWidget) -> QHBoxLayout:
    """Side by side."""
    row = QHBoxLayout()
    for widget in widgets:
        row.addWidget(widget)
    return row


def _column(*widgets: QWidget) -> QWidget:
    column = QWidget()
    box = QVBoxLayout(column)
    box.setContentsMargins(0, 0, 0, 0)
    for widget in widgets:
        box.addWidget(widget, stretch=widget is widgets[-1])
    return column


def _group(title: str, *contents: QWidget | QHBoxLayout) -> QGroupBox:
    group = QGroupBox(title)
    column = QVBoxLayout(group)
    for content in contents:
        if isinstance(content, QHBoxLayout):
            column.addLayout(content)
        else:
            column.addWidget(content)
    return group
