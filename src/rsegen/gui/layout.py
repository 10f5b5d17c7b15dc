"""Where everything stands in the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGroupBox, QHBoxLayout, QScrollArea, QSplitter, QTabWidget, QVBoxLayout, QWidget

if TYPE_CHECKING:
    from rsegen.gui.window import Window


def lay_out(window: Window) -> QSplitter:
    """Forms and Start on the left; view, plan and list on the right; numbers below. Gives the two halves."""
    left = QWidget()
    column = QVBoxLayout(left)
    tabs = QTabWidget()
    tabs.addTab(window.often, "Map")
    tabs.addTab(window.seldom, "More")
    column.addWidget(tabs)
    column.addWidget(_group("Obstacle", window.obstacle, _row(window.add, window.drop, window.clear)))
    column.addStretch(1)
    column.addWidget(window.complaint)
    column.addLayout(_row(window.start, window.cancel, window.bar))
    scroll = QScrollArea(widgetResizable=True)
    scroll.setWidget(left)
    scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    below = QSplitter()
    below.addWidget(_column(window.brushes, window.plan))
    below.addWidget(_group("Obstacles, imposed from the first to the last", window.rows))
    below.setStretchFactor(0, 1)
    below.setSizes([390, 460])
    right = QSplitter(Qt.Orientation.Vertical)
    right.addWidget(window.view)
    right.addWidget(below)
    right.setSizes([380, 320])
    halves = QSplitter()
    for widget, stretch in ((scroll, 0), (right, 1)):
        halves.addWidget(widget)
        halves.setStretchFactor(halves.count() - 1, stretch)
    window.setCentralWidget(halves)
    window.statusBar().addWidget(window.index)
    window.statusBar().addWidget(window.numbers)
    window.statusBar().addPermanentWidget(window.cell)
    return halves


def _row(*widgets: QWidget) -> QHBoxLayout:
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
