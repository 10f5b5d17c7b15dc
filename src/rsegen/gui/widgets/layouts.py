"""Small layouts, names of widgets, and labels for errors and warnings."""

from __future__ import annotations

from html import escape
from typing import Literal, TypeVar

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QFrame, QGroupBox, QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget


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


_Widget = TypeVar("_Widget", bound=QWidget)

_LINE = 80
"""Letters of a tooltip in one line; Qt wraps a longer one only if it is rich text."""


def named(widget: _Widget, name: str, *, title: str = "", tip: str = "") -> _Widget:
    """The widget with an object name, an accessible name (by default the same), and a tooltip that is also spoken."""
    widget.setObjectName(name)
    widget.setAccessibleName(title or name.replace("_", " "))
    widget.setToolTip(tooltip(tip))
    if tip:
        widget.setAccessibleDescription(tip)
    return widget


def tooltip(text: str) -> str:
    """A text as a tooltip that shows it letter by letter, also one that looks like HTML, in lines that fit a screen."""
    return f"<p>{escape(text)}</p>" if "<" in text or len(text) > _LINE else text


Tone = Literal["error", "warning"]

_INKS: dict[Tone, tuple[str, str]] = {"error": ("#b3261e", "#ff8a80"), "warning": ("#7a4f00", "#ffca70")}
"""The text colours on a light and on a dark background."""

PASSES = 15_000
"""Milliseconds for which a note is shown."""


def ink(tone: Tone, palette: QPalette) -> QColor:
    """The text colour on the background of a palette."""
    on_light, on_dark = _INKS[tone]
    return QColor(on_dark if palette.color(QPalette.ColorRole.Base).lightness() < 128 else on_light)


class MessageLabel(QLabel):
    """A message below a field, hidden while there is none."""

    def __init__(self, name: str, tone: Tone = "error") -> None:
        super().__init__(wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        self._tone: Tone = tone
        named(self, name)
        self._set_colour()
        self.hide()

    def show_message(self, text: str) -> None:
        """Show a message; an empty one hides the label."""
        self.setText(text)
        self.setVisible(bool(text))

    def changeEvent(self, event: QEvent) -> None:
        """Update the colour when the desktop switches between light and dark."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._set_colour()

    def _set_colour(self) -> None:
        palette = self.palette()
        colour = ink(self._tone, palette)
        if palette.color(QPalette.ColorRole.WindowText) != colour:
            palette.setColor(QPalette.ColorRole.WindowText, colour)
            self.setPalette(palette)


class PassingNote(QLabel):
    """What was just done, such as a map that is in the simulation now: it disappears by itself."""

    def __init__(self) -> None:
        super().__init__(wordWrap=True, textFormat=Qt.TextFormat.PlainText)
        named(self, "note", title="what was done last")
        self._pause = QTimer(self, singleShot=True, interval=PASSES)
        self._pause.timeout.connect(self.hide)
        self.hide()

    def show_message(self, text: str) -> None:
        """Show a message for some seconds."""
        self.setText(text)
        self.show()
        self._pause.start()
