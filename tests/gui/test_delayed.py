"""The window while its preview is not yet that of the recipe, and while a text is typed but not finished."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QDialog, QLabel, QLineEdit, QSpinBox

from rsegen import Recipe, load
from rsegen.gui.model.plan_layout import fit
from rsegen.gui.model.session import Session
from rsegen.gui.widgets.plan_painting import plan_area
from rsegen.gui.window import Window
from tests.support.clicking import active, find, shown
from tests.support.waiting import until

pytestmark = pytest.mark.long(reason="windows more")

LEFT = Qt.MouseButton.LeftButton
PEAK = {"kind": "peak", "levels": 5, "first": [2, 2], "last": [7, 7]}


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    for first in ([2, 2], [4, 5]):
        window.session.add({**PEAK, "first": first})
    with shown(window):
        until(lambda: window.previewer.scene is not None and window.previewer.scene.recipe == window.session.recipe)
        window.document.select(1)
        yield window


def at(window: Window, block: tuple[int, int]) -> QPoint:
    assert window.previewer.scene
    plan = window.views.plan
    layout = fit(window.previewer.scene.field, plan_area(plan.width(), plan.height()), plan.devicePixelRatio())
    return QPoint(*map(round, layout.middle(block)))


def test_keys_and_clicks_on_the_plan_are_about_the_obstacles_of_now(window: Window) -> None:
    QTest.mouseClick(window.views.plan, LEFT, pos=at(window, (4, 5)))
    window.session.clear()
    for key in (Qt.Key.Key_Up, Qt.Key.Key_Tab, Qt.Key.Key_Left):
        QTest.keyClick(window.views.plan, key)
    QTest.mouseClick(window.views.plan, LEFT, pos=at(window, (4, 5)))
    assert window.session.draft.rows == ()
    assert window.document.selected == -1


def test_a_handle_of_an_obstacle_that_was_removed_is_let_go(window: Window) -> None:
    plan = window.views.plan
    QTest.mousePress(plan, LEFT, pos=at(window, (4, 5)))
    QTest.mouseMove(plan, at(window, (5, 5)))
    window.session.remove(1)
    QTest.mouseMove(plan, at(window, (6, 6)))
    QTest.mouseRelease(plan, LEFT, pos=at(window, (6, 6)))
    assert [row.entry["first"] for row in window.session.draft.rows] == [[2, 2]]


@pytest.mark.parametrize("change", [lambda session: session.undo(), lambda session: session.move(1, 0)])
def test_a_handle_is_let_go_if_the_obstacle_was_moved_otherwise(window: Window, change: object) -> None:
    plan = window.views.plan
    QTest.mousePress(plan, LEFT, pos=at(window, (4, 5)))
    QTest.mouseMove(plan, at(window, (5, 5)))
    assert window.session.draft.rows[1].entry["first"] == [5, 5]
    assert callable(change)
    change(window.session)
    left = window.session.draft
    QTest.mouseMove(plan, at(window, (6, 6)))
    QTest.mouseRelease(plan, LEFT, pos=at(window, (6, 6)))
    assert window.session.draft == left


def test_an_end_opposite_a_random_or_an_invalid_one_can_be_moved(window: Window) -> None:
    entries: list[dict[str, object]] = [
        {"kind": "horizontal_barrier", "levels": "abc", "first": [1, 1], "last": "random"},
        {"kind": "horizontal_barrier", "levels": "abc", "first": [1, 1]},
        {"kind": "horizontal_barrier", "levels": 3, "first": [1, 1], "last": [4, "x"]},
    ]
    for entry in entries:
        window.session.change(1, entry)
        window.document.move_end(1, "first", (3, 3))
        moved = dict(window.session.draft.rows[1].entry)
        assert moved == {**entry, "first": [3, 3], "key": moved["key"]}


def test_a_preview_error_vanishes_with_the_next_preview_and_hides_no_other(window: Window) -> None:
    error = find(window, QLabel, "error")
    window.session.set("chunk_size", 1000)
    window.session.set("chunks", [10**9, 10**9])
    until(lambda: error.text() != "" and not error.text().startswith("internal error"))
    window.session.set("unit_cm", -1)
    QTest.qWait(100)
    assert error.text().startswith("unit_cm: ")
    for _ in range(3):
        window.session.undo()
    until(error.isHidden)


def test_a_recipe_of_huge_numbers_is_shown(app: QApplication) -> None:
    huge = {"maps": 2**62, "first_map": 2**62, "chunks": (10**9, 10**9), "chunk_size": 1000, "boundary": "none"}
    window = Window(Session.imported(Recipe(seed=2**63 - 1, **huge)))  # type: ignore[arg-type]  # any parameter
    with shown(window):
        assert find(window.forms, QSpinBox, "maps_field").text() == f"{2**62}"[:11] + "..."
        assert [box.value() for box in window.forms.findChildren(QSpinBox, "chunks_field")] == [10**9, 10**9]
        window.status.index.setValue(3)
        assert (window.status.index.text(), window.status.shown_index()) == (f"map {2**62} + 3", 2**62 + 3)
        assert window.session.recipe.maps == 2**62


def test_a_number_of_many_digits_is_kept_where_it_is_not_changed(window: Window) -> None:
    window.session.change(1, {**PEAK, "softness": 33.33333})
    window.document.select(1)
    find(window.forms.obstacle, QSpinBox, "levels_field").setValue(4)
    assert window.session.draft.rows[1].entry["softness"] == 33.33333


def typing(window: Window, row: int, column: int, text: str) -> QLineEdit:
    """A text that is typed into a cell, without Enter."""
    table = window.views.table
    table.setCurrentCell(row, column)
    QTest.keyClick(table, Qt.Key.Key_F2)
    (field,) = table.viewport().findChildren(QLineEdit)
    field.selectAll()
    QTest.keyClicks(field, text)
    return field


def test_a_click_into_a_field_that_typing_replaces_is_a_click(window: Window) -> None:
    active(window)
    for kind in ("matrix", "peak", "random"):
        window.views.table.setCurrentCell(1, 1)
        QTest.keyClick(window.views.table, Qt.Key.Key_F2)
        find(window.views.table, QComboBox, "cell_editor").setCurrentText(kind)
        box = find(window.forms.obstacle, QSpinBox, "levels_field")
        QTest.mouseClick(find(box, QLineEdit, "qt_spinbox_lineedit"), LEFT)
        assert window.session.draft.rows[1].entry["kind"] == kind
        QTest.qWait(20)


def test_start_takes_over_a_text_that_is_not_finished(window: Window, tmp_path: Path) -> None:
    window.forms.start_form.folder = tmp_path / "worlds"
    field = typing(window, 1, 2, "4")
    QTest.keyClick(active(window) and field, Qt.Key.Key_F5)
    until(lambda: window.forms.start_form.written is not None)
    assert window.session.draft.rows[1].entry["levels"] == 4
    assert [obstacle.levels for obstacle in window.session.recipe.obstacles] == [5, 4]
    (written,) = tmp_path.rglob("recipe.json")
    assert load(written) == window.session.recipe


@pytest.mark.parametrize("keys", ["F5", "Ctrl+E", "Ctrl+B", "Ctrl+Shift+E", "F6"])
def test_nothing_is_made_of_the_last_valid_recipe(window: Window, tmp_path: Path, keys: str) -> None:
    window.forms.start_form.folder = tmp_path / "worlds"
    seed = find(window, QLineEdit, "seed_field")
    seed.setFocus()
    seed.selectAll()
    QTest.keyClicks(seed, "abc")
    (action,) = (each for each in window.findChildren(QAction) if each.shortcut().toString() == keys)
    assert action.isEnabled()
    action.trigger()
    assert find(window, QLabel, "seed_error").text().startswith("'abc' is not a whole number")
    assert not action.isEnabled()
    assert window.findChildren(QDialog) == []
    assert find(window, QLabel, "note").isHidden()
    assert list(tmp_path.iterdir()) == []


def test_a_text_that_is_typed_once_is_one_change(window: Window) -> None:
    friction, steps = find(window, QLineEdit, "frame_friction_field"), len(window.session._done)
    friction.setText("nan")
    for _ in range(3):
        friction.editingFinished.emit()
        window.finish_typing()
        window.document.add(PEAK)
    assert find(window, QLabel, "frame_friction_error").text().startswith("nan is not a finite number")
    assert len(window.session._done) == steps + 4
