"""The list of obstacles, dragged on by a real mouse; its actions as they can be chosen."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDoubleSpinBox, QSlider, QSpinBox

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import find, shown
from tests.support.waiting import until

LEFT = Qt.MouseButton.LeftButton
KINDS = ["random", "peak", "diagonal_barrier"]
ROWS = {"Duplicate obstacle", "Remove obstacle", "Move obstacle up", "Move obstacle down"}


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    for kind in KINDS:
        window.session.add({"kind": kind, "levels": 3})
    with shown(window):
        yield window


def kinds(window: Window) -> list[str]:
    return [row.entry["kind"] for row in window.session.draft.rows]


def at(window: Window, row: float) -> QPoint:
    """The upper rim of a row, or so much of its height below."""
    height = window.views.table.rowHeight(0)
    return QPoint(60, window.views.table.rowViewportPosition(0) + round(row * height))


def held(window: Window, row: float, to: float) -> None:
    page = window.views.table.viewport()
    QTest.mousePress(page, LEFT, pos=at(window, row))
    for part in (0.3, 0.6, 1.0):
        QTest.mouseMove(page, at(window, row + (to - row) * part))


def drag(window: Window, row: float, to: float) -> None:
    held(window, row, to)
    QTest.mouseRelease(window.views.table.viewport(), LEFT, pos=at(window, to))


def lined(window: Window, gap: int) -> bool:
    page = window.views.table.viewport().grab().toImage()
    line = window.views.table.palette().color(QPalette.ColorRole.Highlight)
    return all(page.pixelColor(x, at(window, gap).y() + 1) == line for x in range(2, page.width(), 7))


def possible(window: Window) -> set[str]:
    return {action.objectName() for action in window.findChildren(QAction) if action.isEnabled()}


@pytest.mark.parametrize(
    ("row", "to", "order"),
    [(0, 3.2, [1, 2, 0]), (2, -0.2, [2, 0, 1]), (0, 1.8, [1, 0, 2]), (2, 1.2, [0, 2, 1]), (1, 1.9, [0, 1, 2])],
)
def test_a_dragged_row_comes_to_lie_where_it_is_let_go(window: Window, row: int, to: float, order: list[int]) -> None:
    drag(window, row + 0.5, to)
    assert kinds(window) == [KINDS[number] for number in order]
    assert window.views.table.selected == order.index(row)


def test_a_drag_is_undone_as_one(window: Window) -> None:
    drag(window, 0.5, 2.9)
    assert kinds(window) != KINDS
    window.session.undo()
    assert kinds(window) == KINDS


def test_a_line_shows_where_a_row_would_come_to_lie_and_escape_takes_it_away(window: Window) -> None:
    held(window, 0.5, 2.9)
    assert lined(window, 3)
    QTest.keyClick(window.views.table, Qt.Key.Key_Escape)
    assert not lined(window, 3)
    QTest.mouseRelease(window.views.table.viewport(), LEFT, pos=at(window, 2.9))
    assert kinds(window) == KINDS


def test_a_row_that_is_held_moves_no_other_choice(window: Window) -> None:
    held(window, 0.5, 2.4)
    assert window.views.table.selected == 0


def test_only_possible_actions_are_enabled(window: Window) -> None:
    window.document.select(-1)
    assert possible(window).isdisjoint(ROWS)
    window.document.select(0)
    assert possible(window) & ROWS == ROWS - {"Move obstacle up"}
    window.document.select(2)
    assert possible(window) & ROWS == ROWS - {"Move obstacle down"}
    assert "Undo" in possible(window)
    assert "Redo" not in possible(window)
    window.session.undo()
    assert "Redo" in possible(window)
    window.document.open(Session.new())
    assert possible(window).isdisjoint({"Undo", "Redo"} | ROWS)
    assert not window.views.list_bar.remove.isEnabled()
    assert not window.views.list_bar.clear.isEnabled()


def edit(window: Window, row: int, column: int, text: str) -> None:
    item = window.views.table.item(row, column)
    assert item is not None
    item.setText(text)


def test_an_unknown_kind_is_an_error_and_can_be_corrected(window: Window) -> None:
    window.document.select(0)
    edit(window, 0, 1, "pyramid")
    assert "pyramid" in window.forms.error_label.text()
    edit(window, 0, 2, "4")
    edit(window, 0, 1, "peak")
    assert window.forms.error_label.isHidden()
    assert kinds(window)[0] == "peak"
    assert window.session.draft.rows[0].entry["levels"] == 4


@pytest.mark.parametrize(
    ("column", "text", "message"),
    [
        (1, "peek", "type: unknown obstacle kind 'peek'; did you mean 'peak'?"),
        (1, "", "type: unknown obstacle kind ''"),
        (2, "abc", "levels: 'abc' is not a whole number; give 2..32767 units"),
        (2, "5.5", "levels: '5.5' is not a whole number; give 2..32767 units"),
        (2, "9" * 30, f"levels: {'9' * 30} is outside 2..32767 units"),
        (2, "", "levels: is missing; give 2..32767 units"),
        (3, "a,b", "softness: 'a,b' is not a number; give 0..100 %"),
        (3, "nan", "softness: nan is not a finite number; give 0..100 %"),
        (3, "<b>7</b>", "softness: '<b>7</b>' is not a number; give 0..100 %"),
        (4, "abc", "first: 'abc' is not a place; give x and y"),
        (4, "7", "first: '7' is not a place; give x and y"),
        (4, "a,b", "X first: 'a' is not a coordinate"),
        (5, "1,2,3", "last: [1, 2, 3] is not a place; give x and y"),
        (5, "2, 5.5", "Y last: '5.5' is not a coordinate"),
        (5, "-1, 2", "X last: -1 is not a coordinate"),
        (5, f"2, {2**70}", f"Y last: {2**70} is outside 0..9"),
    ],
)
@pytest.mark.parametrize("selected", [-1, 1])
def test_a_cell_that_is_wrong_is_marked_and_named_and_nothing_can_be_started(
    window: Window, column: int, text: str, message: str, selected: int
) -> None:
    window.document.select(selected)
    edit(window, 1, column, text)
    assert window.forms.error_label.text().startswith(f"Row 2, {message}")
    assert not window.forms.start.isEnabled()
    item = window.views.table.item(1, column)
    assert item is not None
    assert item.text().replace(" ", "") == text.replace(" ", "")
    marked = [(row, each) for row in range(3) for each in range(6) if has_icon(window, row, each)]
    assert marked == [(1, column)]
    window.session.undo()
    assert window.forms.error_label.isHidden()
    assert item.icon().isNull()


def has_icon(window: Window, row: int, column: int) -> bool:
    item = window.views.table.item(row, column)
    return item is not None and not item.icon().isNull()


@pytest.mark.parametrize("text", ["2, 3", "[2,3]", "[2, 3]"])
def test_a_place_is_typed_with_brackets_or_without(window: Window, text: str) -> None:
    edit(window, 1, 4, text)
    assert window.session.draft.rows[1].entry["first"] == [2, 3]
    assert window.session.problem is None


def test_another_kind_keeps_the_parameters_that_it_shares(window: Window) -> None:
    window.session.change(0, {"kind": "matrix", "levels": 3, "rows": ["1 2"], "softness": 10})
    edit(window, 0, 1, "matrx")
    edit(window, 0, 1, "matrix")
    assert window.session.draft.rows[0].entry["rows"] == ["1 2"]
    edit(window, 0, 1, "peak")
    assert dict(window.session.draft.rows[0].entry) | {"key": ""} == {
        "kind": "peak",
        "levels": 3,
        "softness": 10,
        "key": "",
    }
    assert window.session.problem is None


def test_the_form_keeps_a_wrong_value_until_it_is_corrected(window: Window) -> None:
    window.document.select(1)
    edit(window, 1, 2, "abc")
    edit(window, 1, 5, "99, random")
    find(window.forms.obstacle, QDoubleSpinBox, "softness_field").setValue(40)
    entry = window.session.draft.rows[1].entry
    assert (entry["levels"], entry["last"], entry["softness"]) == ("abc", [99, "random"], 40)
    levels = find(window.forms.obstacle, QSpinBox, "levels_field")
    assert levels.text() == "abc"
    levels.setValue(4)
    assert levels.text() == "4 units"
    find(window.forms.obstacle, QSlider, "x_last").setValue(3)
    assert window.session.problem is None
    entry = window.session.draft.rows[1].entry
    assert (entry["levels"], entry["last"]) == (4, [3, "random"])


def test_a_kind_that_is_wrong_is_replaced_in_the_form(window: Window) -> None:
    window.document.select(0)
    edit(window, 0, 1, "peek")
    assert window.forms.obstacle.kind.currentIndex() == -1
    assert window.forms.obstacle.kind.placeholderText() == "peek"
    window.forms.obstacle.kind.setCurrentText("peak")
    assert kinds(window)[0] == "peak"
    assert window.session.problem is None


def test_a_row_that_is_dragged_while_the_rows_change_is_let_go(window: Window) -> None:
    held(window, 2.5, 0.2)
    window.session.clear()
    QTest.mouseRelease(window.views.table.viewport(), LEFT, pos=QPoint(60, 5))
    assert kinds(window) == []
    window.session.undo()
    assert kinds(window) == KINDS


def test_a_row_is_selected_also_if_the_list_was_scrolled_over_a_long_text(window: Window) -> None:
    edit(window, 0, 2, "x" * 600)
    bar = window.views.table.horizontalScrollBar()
    until(lambda: bar.maximum() > 0)
    bar.setValue(bar.maximum())
    window.document.open(Session.new())
    window.document.add({"kind": "peak", "levels": 3})
    assert (window.document.selected, window.views.table.selected) == (0, 0)
