"""Numbers are read in one way in every locale: `.` and `,` are both the decimal mark, and nothing groups digits."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QLocale, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QDoubleSpinBox, QSpinBox

from rsegen.gui.model.session import Session
from rsegen.gui.widgets.editors import DecimalBox, IntegerBox
from rsegen.gui.window import Window
from tests.support.clicking import find, shown, typed

LOCALES = ("C", "de_DE", "fr_FR")
DECIMALS = {"7.5": 7.5, "7,5": 7.5, "0.5": 0.5, "0,5": 0.5, "1.000": 1, "1,000": 1, ",5": 0.5}
INTEGERS = {"7.5": 7, "7,5": 7, "0.5": 0, "0,5": 0, "1.000": 1, "1,000": 1, "1000": 1000}


@pytest.fixture(params=LOCALES)
def locale(app: QApplication, request: pytest.FixtureRequest) -> Iterator[str]:
    before = QLocale()
    QLocale.setDefault(QLocale(request.param))
    yield request.param
    QLocale.setDefault(before)


@pytest.fixture
def window(locale: str) -> Iterator[Window]:
    window = Window(Session.new())
    window.document.add({"kind": "peak", "levels": 5, "first": [1, 1], "last": [7, 7]})
    window.document.select(0)
    with shown(window):
        yield window


def number(box: QSpinBox | QDoubleSpinBox, text: str, *, pastes: bool) -> float:
    """The value of a box after a text was typed or pasted, and Enter."""
    box.setRange(0, 10_000)
    box.setValue(3)
    box.selectAll()
    if pastes:
        QApplication.clipboard().setText(text)
        box.lineEdit().paste()
    else:
        QTest.keyClick(box, Qt.Key.Key_Delete)
        QTest.keyClicks(box, text)
    QTest.keyClick(box, Qt.Key.Key_Return)
    return box.value()


@pytest.mark.parametrize("suffix", ["", " cm"])
@pytest.mark.parametrize("text", DECIMALS)
def test_a_float_has_a_point_or_a_comma(locale: str, text: str, suffix: str) -> None:
    box = DecimalBox(suffix=suffix)
    assert number(box, text, pastes=False) == DECIMALS[text]
    assert number(box, text, pastes=True) == DECIMALS[text]
    assert "," not in box.text()


@pytest.mark.parametrize("text", INTEGERS)
def test_an_integer_is_not_read_across_a_decimal_mark(locale: str, text: str) -> None:
    assert number(IntegerBox(suffix=" pixels"), text, pastes=False) == INTEGERS[text]
    assert number(IntegerBox(prefix="x "), text, pastes=True) in {INTEGERS[text], 3}


def test_a_number_with_two_marks_is_refused(locale: str) -> None:
    for text in ("1.000.000", "1,000,000", "1.000,5", "1,000.5"):
        assert number(DecimalBox(), text, pastes=True) == 3
        assert number(IntegerBox(), text, pastes=True) == 3


def test_large_numbers_are_shown_without_marks(locale: str) -> None:
    for box in (IntegerBox(), DecimalBox()):
        box.setRange(0, 10**6)
        box.setValue(123456)
        assert box.text() == "123456"


def test_every_spin_box_of_the_window_reads_numbers_so(window: Window) -> None:
    boxes = [box for box in window.findChildren(QAbstractSpinBox) if isinstance(box, (QSpinBox, QDoubleSpinBox))]
    assert len(boxes) > 10
    assert {type(box) for box in boxes} <= {IntegerBox, DecimalBox}


@pytest.mark.parametrize(("text", "wanted"), [("7.5", 7.5), ("7,5", 7.5), ("0,5", 0.5), ("1.000", 1)])
def test_a_number_of_a_form_is_read_so(window: Window, text: str, wanted: float) -> None:
    typed(window.forms.basic, "unit_cm_field", text)
    assert window.session.recipe.unit_cm == wanted
    box = find(window.forms.obstacle, QDoubleSpinBox, "softness_field")
    box.selectAll()
    QTest.keyClick(box, Qt.Key.Key_Delete)
    QTest.keyClicks(box, text)
    assert window.session.draft.rows[0].entry["softness"] == wanted


def test_a_text_field_of_one_number_takes_a_comma_and_a_list_keeps_its_own(window: Window) -> None:
    for name, text in (("frame_friction_field", "0,5"), ("level_friction_field", "0.5,1")):
        typed(window, name, text)
        window.finish_typing()
    assert window.session.draft.values["frame_friction"] == 0.5
    assert window.session.draft.values["level_friction"] == [0.5, 1]


@pytest.mark.parametrize(
    ("column", "key", "text", "wanted"),
    [
        (3, "softness", "7.5", 7.5),
        (3, "softness", "7,5", 7.5),
        (4, "first", "2, 3", [2, 3]),
        (2, "levels", "7.5", "7.5"),
    ],
)
def test_a_cell_of_the_list_is_read_so(window: Window, column: int, key: str, text: str, wanted: object) -> None:
    table = window.views.table
    item = table.item(0, column)
    assert item is not None
    table.editItem(item)
    editor = table._cells.open_editor
    assert isinstance(editor, QAbstractSpinBox)
    editor.selectAll()
    QTest.keyClick(editor, Qt.Key.Key_Delete)
    QTest.keyClicks(editor, text)
    window.finish_typing()
    assert window.session.draft.rows[0].entry[key] == wanted
    assert (window.session.problem is None) == (wanted != text)
