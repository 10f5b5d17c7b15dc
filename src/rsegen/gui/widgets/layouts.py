"""Small layouts: rows, columns, groups and scrolled forms."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtWidgets import QFrame, QGroupBox, QHBoxLayout, QScrollArea, QVBoxLayout, QWidget


class Scrolled(QScrollArea):
    """A widget in as much height as is available, with a scroll bar if that is too little."""

    def __init__(self, content: QWidget) -> None:
        super().__init__(widgetResizable=True)
        self.setWidget(content)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def sizeHint(self) -> QSize:
        """The width of the content."""
        return QSize(super().sizeHint().width(), 0)


class _ScrollPast(QObject):
    """Leaves the wheel to the scrolled form, unless its field has the keyboard."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Ignore a wheel, which then goes to the parent."""
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()
            return True
        return False


def scroll_past(field: QWidget) -> None:
    """A wheel over a field that does not have the keyboard scrolls the form and does not change the value."""
    field.installEventFilter(_ScrollPast(field))
    field.setFocusPolicy(Qt.FocusPolicy.StrongFocus)


def row_of(*widgets: QWidget) -> QHBoxLayout:
    """The widgets side by side."""
    row = QHBoxLayout()
    for widget in widgets:
        row.addWidget(widget)
    return row


def column_of(*widgets: QWidget) -> QWidget:
    """The widgets below each other; the last one takes the height that is left."""
    column = QWidget()
    box = QVBoxLayout(column)
    box.setContentsMargins(0, 0, 0, 0)
    for widget in widgets:
        box.addWidget(widget, stretch=widget is widgets[-1])
    return column


def group_of(title: str, *contents: QWidget | QHBoxLayout) -> QGroupBox:
    """The widgets and rows in a titled frame."""
    group = QGroupBox(title)
    column = QVBoxLayout(group)
    for content in contents:
        if isinstance(content, QHBoxLayout):
            column.addLayout(content)
        else:
            column.addWidget(content)
    return group
