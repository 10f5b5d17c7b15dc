"""The list of obstacles, dragged on by a real mouse; its actions as they can be chosen."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import shown

LEFT = Qt.MouseButton.LeftButton
KINDS = ["random", "peak", "diagonal_barrier"]
ROWS = {"Duplicate obstacle", "Remove obstacle", "Move obstacle up", "Move obstacle down"}


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    for kind in KINDS:
        window.session.add({"kind": kind, "max_height": 3})
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


def test_only_what_can_be_done_can_be_chosen(window: Window) -> None:
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
    assert not window.forms.remove.isEnabled()
    assert not window.forms.clear.isEnabled()


def edit(window: Window, row: int, column: int, text: str) -> None:
    item = window.views.table.item(row, column)
    assert item is not None
    item.setText(text)


def test_a_kind_that_there_is_not_is_an_error_and_can_be_corrected(window: Window) -> None:
    window.document.select(0)
    edit(window, 0, 1, "pyramid")
    assert "pyramid" in window.forms.error_label.text()
    edit(window, 0, 2, "4")
    edit(window, 0, 1, "peak")
    assert window.forms.error_label.isHidden()
    assert kinds(window)[0] == "peak"
    assert window.session.draft.rows[0].entry["max_height"] == 4
