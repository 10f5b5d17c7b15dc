"""The editors of the cells of the list: they show what is there, and change only what is changed in them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget

from rsegen.gui.model.session import Session
from rsegen.gui.widgets.obstacle_table import EndCell
from rsegen.gui.window import Window
from tests.support.clicking import active, shown
from tests.support.waiting import until


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    window.document.add({"kind": "peak", "levels": 5, "first": [1, "random"], "last": [7, 7]})
    with shown(window):
        yield window


def opened(window: Window, column: int) -> QWidget:
    table = window.views.table
    item = table.item(0, column)
    assert item is not None
    table.editItem(item)
    editor = table._cells.open_editor
    assert editor is not None
    return editor


def entry(window: Window) -> dict[str, object]:
    return {name: value for name, value in window.session.draft.rows[0].entry.items() if name != "key"}


def test_a_kind_is_chosen_from_a_list(window: Window) -> None:
    editor = opened(window, 1)
    assert isinstance(editor, QComboBox)
    assert editor.currentText() == "peak"
    editor.setCurrentText("diagonal barrier")
    window.finish_typing()
    assert entry(window)["kind"] == "diagonal_barrier"


def test_a_height_is_counted_up(window: Window) -> None:
    editor = opened(window, 2)
    QTest.keyClick(editor, Qt.Key.Key_Up)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    until(lambda: entry(window)["levels"] == 6)


def test_softness_without_a_value_begins_at_none(window: Window) -> None:
    editor = opened(window, 3)
    window.finish_typing()
    assert "softness" not in entry(window)
    QTest.keyClick(editor, Qt.Key.Key_Up)
    window.finish_typing()
    assert entry(window)["softness"] == 1


def test_an_end_has_two_numbers_each_of_which_may_be_random(window: Window) -> None:
    editor = opened(window, 4)
    assert isinstance(editor, EndCell)
    assert editor.text() == "1, random"
    editor.lineEdit().setCursorPosition(4)
    for _ in range(4):
        QTest.keyClick(editor, Qt.Key.Key_Up)
    assert editor.text() == "1, 3"
    editor.lineEdit().setCursorPosition(0)
    for _ in range(20):
        QTest.keyClick(editor, Qt.Key.Key_Up)
    assert editor.text() == "9, 3"
    for _ in range(20):
        QTest.keyClick(editor, Qt.Key.Key_Down)
    assert editor.text() == "random, 3"
    window.finish_typing()
    assert entry(window)["first"] == ["random", 3]


def test_an_end_that_is_left_is_taken_over(window: Window) -> None:
    editor = opened(window, 5)
    assert isinstance(editor, EndCell)
    active(window)
    editor.setFocus()
    editor.selectAll()
    QTest.keyClicks(editor, "4, 7")
    assert entry(window)["last"] == [7, 7]
    window.views.plan.setFocus()
    until(lambda: entry(window)["last"] == [4, 7])


def test_an_editor_that_is_closed_unchanged_changes_nothing(window: Window) -> None:
    before = window.session.draft
    for column in (1, 2, 3, 4, 5):
        opened(window, column)
        window.finish_typing()
    assert window.session.draft == before


def test_a_text_that_no_editor_can_show_is_edited_as_text(window: Window) -> None:
    item = window.views.table.item(0, 2)
    assert item is not None
    item.setText("abc")
    editor = opened(window, 2)
    assert isinstance(editor, QLineEdit)
    editor.setText("4")
    window.finish_typing()
    assert entry(window)["levels"] == 4


def test_a_wrong_cell_is_red_with_its_reason_in_the_selected_row_too(window: Window) -> None:
    item = window.views.table.item(0, 5)
    assert item is not None
    item.setText("99, 99")
    window.document.select(0)
    table = window.views.table
    box = table.visualItemRect(item)
    assert table.isVisible()
    picture = QImage(table.viewport().grab(box).toImage())
    corner = picture.pixelColor(picture.width() - 4, 3)
    assert corner.red() > corner.green() + 10
    assert corner.red() > corner.blue()
