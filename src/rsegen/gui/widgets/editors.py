"""An editor widget for each type of parameter; numbers have `.` or `,` as decimal mark, whatever the locale."""

from __future__ import annotations

import re
from dataclasses import fields
from typing import cast

from PySide6.QtCore import QLocale, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QInputDialog,
    QLineEdit,
    QPushButton,
    QSlider,
    QSpinBox,
    QWidget,
)

from rsegen.errors import ParameterError
from rsegen.field.obstacles.matrix import Rows
from rsegen.gui.model.obstacle_ends import typed_value
from rsegen.gui.widgets.layouts import named, scroll_past
from rsegen.params.sorts import Choice, Flag, Float, Integer, Json, Parameter, Size2D, parameters
from rsegen.recipe.map_design import DifficultySort


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


_MOST = 2**31 - 1
_LETTERS = 14


class Editor(QWidget):
    """Edits a parameter's value as a recipe file has it; `edited` is emitted when the user changes it.

    A draft may have any value, also one that the widgets cannot show; it is kept until the user changes it.
    """

    edited = Signal(object)
    _parts: tuple[str, ...] = ("",)
    """What is added to the accessible name of each widget."""

    def __init__(self, name: str, parameter: Parameter) -> None:
        super().__init__()
        self.parameter = parameter
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(0, 0, 0, 0)
        tip = f"{parameter.help}: {parameter.describe()}"
        self.fields = self._widgets()
        for widget, part in zip(self.fields, self._parts, strict=True):
            title = f"{name.removesuffix('_cm').replace('_', ' ')}{part}"
            self._row.addWidget(named(widget, f"{name}_field", title=title, tip=tip))
            if isinstance(widget, (QAbstractSpinBox, QAbstractSlider, QComboBox)):
                scroll_past(widget)
        named(self, name)
        self._given, self._shown = self._read(), self._content()

    def _widgets(self) -> tuple[QWidget, ...]:
        raise NotImplementedError

    def value(self) -> Json:
        """The value in the editor, unchecked: the one that it was given, until the user changes it."""
        return self._given if self._content() == self._shown else self._read()

    def show_value(self, value: Json) -> None:
        """Show a value without a signal."""
        if value != self.value():
            blockers = [QSignalBlocker(child) for child in self.findChildren(QWidget)]
            (self._put if self._can_show(value) else self._put_invalid)(value)
            del blockers
            self._given, self._shown = value, self._content()

    def finish_typing(self) -> None:
        """Emit `edited` if a text was typed and not yet finished with Enter."""

    def _read(self) -> Json:
        """The value that the widgets show now."""
        raise NotImplementedError

    def _content(self) -> object:
        """What the widgets show now, to be compared."""
        return self._read()

    def _put(self, value: Json) -> None:
        """Let the widgets show a valid value."""
        raise NotImplementedError

    def _put_invalid(self, value: Json) -> None:
        """Let the widgets show an invalid value if they can."""

    def _can_show(self, value: Json) -> bool:
        try:
            self.parameter.check("", value)
        except ParameterError:
            return False
        return True

    def _emit(self) -> None:
        self.edited.emit(self.value())


class ChoiceEditor(Editor):
    """A drop-down list for a choice."""

    def _widgets(self) -> tuple[QWidget, ...]:
        self._box = QComboBox()
        self._box.addItems(cast(Choice, self.parameter).values)
        self._box.currentTextChanged.connect(self._emit)
        return (self._box,)

    def _read(self) -> Json:
        return self._box.currentText()

    def _put(self, value: Json) -> None:
        self._box.setCurrentText(value)

    def _put_invalid(self, value: Json) -> None:
        self._box.setCurrentIndex(-1)


class NumberEditor(Editor):
    """A spin box for an integer or a float; a value that is none, or out of range, is shown as its text."""

    def _widgets(self) -> tuple[QWidget, ...]:
        sort = cast("Integer | Float", self.parameter)
        self._low, self._high = sort.low, _MOST if sort.high is None else min(sort.high, _MOST)
        suffix = f" {sort.unit}" if sort.unit else ""
        self._box: IntegerBox | DecimalBox
        if isinstance(sort, Integer):
            self._box = IntegerBox(suffix=suffix)
        else:
            self._box = DecimalBox(suffix=suffix)
            self._box.setStepType(DecimalBox.StepType.AdaptiveDecimalStepType)
        self._box.setRange(self._low, self._high)  # type: ignore[arg-type]  # integers in an IntegerBox
        self._box.valueChanged.connect(self._emit)
        return (self._box,)

    def _read(self) -> Json:
        return self._box.value()

    def _put(self, value: Json) -> None:
        self._show_special("", self._low)
        self._box.setValue(value)

    def _put_invalid(self, value: Json) -> None:
        """Show a text: Qt has one for the minimum, so that is one below the range for as long."""
        self._show_special(shortened(value), self._low - 1)
        self._box.setValue(self._low - 1)  # type: ignore[arg-type]  # an integer in an IntegerBox

    def _show_special(self, text: str, minimum: float) -> None:
        self._box.setSpecialValueText(text)
        self._box.setMinimum(minimum)  # type: ignore[arg-type]  # an integer in an IntegerBox

    def _can_show(self, value: Json) -> bool:
        return super()._can_show(value) and value <= self._high


class PairEditor(Editor):
    """Two spin boxes for integers along x and y."""

    _parts = (" along x", " along y")

    def _widgets(self) -> tuple[QWidget, ...]:
        self._boxes = (IntegerBox(prefix="x "), IntegerBox(prefix="y "))
        for box in self._boxes:
            box.setRange(1, Size2D.high)
            box.valueChanged.connect(self._emit)
        return self._boxes

    def _read(self) -> Json:
        return [box.value() for box in self._boxes]

    def _put(self, value: Json) -> None:
        for box, number in zip(self._boxes, self.parameter.check("", value), strict=True):
            box.setValue(number)


class TextEditor(Editor):
    """A text field for everything else, written as on the command line; an empty one is None."""

    def _widgets(self) -> tuple[QWidget, ...]:
        self._line = QLineEdit(placeholderText=self.parameter.describe())
        self._line.editingFinished.connect(self._emit)
        return (self._line,)

    def finish_typing(self) -> None:
        """Emit `edited` if the text was changed and not yet finished with Enter."""
        if self._content() != self._shown:
            self._emit()

    def _content(self) -> object:
        """The text: nan is a number that equals none."""
        return self._line.text()

    def _read(self) -> Json:
        text = self._line.text()
        return typed_value(self.parameter, text) if text else None

    def _put(self, value: Json) -> None:
        self._line.setText("" if value is None else self.parameter.format(value))
        self._line.setCursorPosition(0)

    def _put_invalid(self, value: Json) -> None:
        (self._line.setText if isinstance(value, str) else self._put)(value)

    def _can_show(self, value: Json) -> bool:
        return value is None or super()._can_show(value)


class FlagEditor(Editor):
    """A check box for yes or no."""

    def _widgets(self) -> tuple[QWidget, ...]:
        self._box = QCheckBox()
        self._box.toggled.connect(self._emit)
        return (self._box,)

    def _read(self) -> Json:
        return self._box.isChecked()

    def _put(self, value: Json) -> None:
        self._box.setChecked(value)


class RowsEditor(Editor):
    """A button that opens a text field for the levels of a matrix, which may be many."""

    def _widgets(self) -> tuple[QWidget, ...]:
        self._rows: list[str] = []
        self._button = QPushButton()
        self._button.clicked.connect(self._ask)
        return (self._button,)

    def _read(self) -> Json:
        return self._rows

    def _put(self, value: Json) -> None:
        self._rows = list(value)
        n_x = len(str(self._rows[0]).split()) if self._rows else 0
        self._button.setText(f"{n_x} x {len(self._rows)} cells...")

    def _put_invalid(self, value: Json) -> None:
        if isinstance(value, (list, tuple)):
            self._put(value)

    def _ask(self) -> None:
        text, done = QInputDialog.getMultiLineText(
            self, "Levels", "The top row has the largest y; a dot leaves its cell unchanged.", "\n".join(self._rows)
        )
        if done:
            self._put([line.strip() for line in text.splitlines() if line.strip()])
            self._emit()


def shortened(value: Json) -> str:
    """A value as a text of a few letters; None is a value that is missing."""
    text = "missing" if value is None else str(value)
    return text if len(text) <= _LETTERS else f"{text[: _LETTERS - 3]}..."


def editor(owner: type, name: str) -> Editor:
    """The editor for a parameter of a dataclass; one whose default is None gets a text field, which may be empty."""
    parameter = parameters(owner)[name]
    if isinstance(parameter, DifficultySort):
        parameter = Float(0, 1, help=parameter.help)  # of a range the text is shown, and kept until it is changed
    if next(field.default for field in fields(owner) if field.name == name) is None:
        return TextEditor(name, parameter)
    if isinstance(parameter, Choice):
        return ChoiceEditor(name, parameter)
    if isinstance(parameter, Size2D):
        return PairEditor(name, parameter)
    if isinstance(parameter, Flag):
        return FlagEditor(name, parameter)
    if isinstance(parameter, Rows):
        return RowsEditor(name, parameter)
    small = isinstance(parameter, Float) or (isinstance(parameter, Integer) and (parameter.high or 0) <= _MOST)
    return NumberEditor(name, parameter) if small else TextEditor(name, parameter)


class SliderEditor(NumberEditor):
    """A slider and a spin box for a number; the slider ends at `most`, the box may go beyond."""

    _parts = (" slider", "")

    def __init__(self, name: str, parameter: Parameter, most: int) -> None:
        self._most = most
        super().__init__(name, parameter)

    def _widgets(self) -> tuple[QWidget, ...]:
        (box,) = super()._widgets()
        self._slider = QSlider(Qt.Orientation.Horizontal)
        self._slider.setRange(int(self._low), self._most)
        self._slider.valueChanged.connect(self._box.setValue)
        self._box.valueChanged.connect(self._follow)
        self._row.setStretch(0, 1)
        return self._slider, box

    def _put(self, value: Json) -> None:
        super()._put(value)
        self._follow()

    def _put_invalid(self, value: Json) -> None:
        super()._put_invalid(value)
        self._follow()

    def _follow(self) -> None:
        """Move the slider to the number in the box, as near as it can."""
        blocker = QSignalBlocker(self._slider)
        self._slider.setValue(min(int(self._box.value()), self._most))
        del blocker
