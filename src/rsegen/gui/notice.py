"""What is wrong, and what should be known, in a colour that can be read on light and on dark."""

from __future__ import annotations

from typing import Literal

from PySide6.QtCore import QEvent
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QLabel

from rsegen.gui.editors import named

Tone = Literal["wrong", "warning"]

_INKS: dict[Tone, tuple[str, str]] = {"wrong": ("#b3261e", "#ff8a80"), "warning": ("#7a4f00", "#ffca70")}
"""On light ground, and on dark."""


def ink(tone: Tone, palette: QPalette) -> QColor:
    """The colour to write in, on the ground of a palette."""
    on_light, on_dark = _INKS[tone]
    return QColor(on_dark if palette.color(QPalette.ColorRole.Base).lightness() < 128 else on_light)


class Notice(QLabel):
    """A few words below a field; nothing is there while there is nothing to say."""

    def __init__(self, name: str, tone: Tone = "wrong") -> None:
        super().__init__(wordWrap=True)
        self._tone: Tone = tone
        named(self, name)
        self._dip()
        self.hide()

    def say(self, text: str) -> None:
        """These words, or none."""
        self.setText(text)
        self.setVisible(bool(text))

    def changeEvent(self, event: QEvent) -> None:
        """Follow the desktop from light to dark and back."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dip()

    def _dip(self) -> None:
        palette = self.palette()
        colour = ink(self._tone, palette)
        if palette.color(QPalette.ColorRole.WindowText) != colour:
            palette.setColor(QPalette.ColorRole.WindowText, colour)
            self.setPalette(palette)
