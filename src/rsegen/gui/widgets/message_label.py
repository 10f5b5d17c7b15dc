"""A label for errors and warnings, in a colour that is legible on light and dark backgrounds."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QLabel

from rsegen.gui.widgets.named import named

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
