"""Spin boxes in which `.` and `,` are both the decimal mark, and no digits are grouped, whatever the locale.

Qt reads numbers as the locale writes them, and passes over the marks that group digits: `7.5` is 75 in German, `0,5` is
5 in English. Recipes have decimal points everywhere; the window reads numbers in one way everywhere too.
"""

from __future__ import annotations

import re

from PySide6.QtCore import QLocale
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox, QSpinBox, QWidget


class IntegerBox(QSpinBox):
    """A spin box for integers; of 7.5 it takes the 7."""

    def __init__(self, parent: QWidget | None = None, *, prefix: str = "", suffix: str = "") -> None:
        super().__init__(parent)
        self.setLocale(QLocale.c())
        self.setPrefix(prefix)
        self.setSuffix(suffix)

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        """Let a fraction be typed, though it is not taken: Qt would drop the mark alone, and read 7.5 as 75."""
        if text == self.specialValueText():
            return super().validate(text, position)
        text = text.replace(",", ".")
        whole = re.sub(r"(?<=\d)\.\d*", "", text, count=1)
        state, *_ = super().validate(whole, min(position, len(whole)))
        if whole != text and state != QValidator.State.Invalid:
            state = QValidator.State.Intermediate
        return state, text, position


class DecimalBox(QDoubleSpinBox):
    """A spin box for floats, without trailing zeros; it replaces a comma by a point."""

    def __init__(self, parent: QWidget | None = None, *, suffix: str = "") -> None:
        super().__init__(parent)
        self.setLocale(QLocale.c())
        self.setDecimals(3)
        self.setSuffix(suffix)

    def textFromValue(self, value: float) -> str:
        """The number without trailing zeros."""
        return f"{value:.3f}".rstrip("0").rstrip(".")

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        """The verdict on the text with a decimal point, which replaces the one that was typed."""
        is_number = text != self.specialValueText()
        return super().validate(text.replace(",", ".") if is_number else text, position)
