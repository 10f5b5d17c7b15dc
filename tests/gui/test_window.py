"""The window, with real clicks and keys."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QTimer, QUrl
from PySide6.QtGui import QAction, QDragEnterEvent, QDropEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QDoubleSpinBox,
    QFileDialog,
    QLabel,
    QLineEdit,
    QMessageBox,
    QSlider,
    QSpinBox,
    QTableWidgetItem,
    QWidget,
)

from rsegen import StepField, build, load
from rsegen.gui.dialogs.opening import HeightsDialog
from rsegen.gui.dialogs.outputs import PictureSizeDialog
from rsegen.gui.model.plan_layout import fit
from rsegen.gui.model.session import Session
from rsegen.gui.widgets.obstacle_form import DEFAULT
from rsegen.gui.widgets.plan_painting import plan_area
from rsegen.gui.window import Window
from tests.support.clicking import answer, click, find, shown, typed
from tests.support.waiting import until

LEFT = Qt.MouseButton.LeftButton
SELF_EXPLAINING = {"default_ends", "ScrollLeftButton", "ScrollRightButton"}
"""Buttons that speak for themselves, and Qt's own."""


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    with shown(window):
        yield window


def cell(window: Window, row: int, column: int) -> QTableWidgetItem:
    found = window.views.table.item(row, column)
    assert found is not None
    return found


def previewed(window: Window) -> StepField:
    """The field that is shown, once it is that of the recipe."""
    until(lambda: window.previewer.scene is not None and window.previewer.scene.recipe == window.session.recipe)
    assert window.previewer.scene is not None
    return window.previewer.scene.field


def kinds(window: Window) -> list[str]:
    return [row.entry["kind"] for row in window.session.draft.rows]


def choose(window: Window, kind: str) -> None:
    window.forms.obstacle.kind.setCurrentText(kind)


def test_plus_adds_minus_takes_the_last_and_c_clears(window: Window) -> None:
    click(window, "add")
    choose(window, "peak")
    window.views.table.clearSelection()
    click(window, "add")
    assert window.views.table.rowCount() == 2
    click(window, "remove")
    assert window.views.table.rowCount() == 1
    click(window, "add")
    click(window, "clear")
    assert window.views.table.rowCount() == 0
    assert kinds(window) == []


def test_type_height_and_softness_of_the_form_match_the_row(window: Window) -> None:
    choose(window, "random")
    find(window.forms.obstacle, QSpinBox, "levels_field").setValue(4)
    click(window, "add")
    (row,) = window.session.draft.rows
    assert (row.entry["kind"], row.entry["levels"]) == ("random", 4)
    assert [cell(window, 0, column).text() for column in (1, 2)] == ["random", "4"]
    assert find(window.forms.obstacle, QLabel, "heights").text() == "4 levels: 0, 10, 20, 30 cm"


def test_sliders_move_the_ends_of_the_chosen_obstacle(window: Window) -> None:
    choose(window, "peak")
    window.forms.obstacle.default_ends.setChecked(False)
    find(window.forms.obstacle, QSlider, "x_last").setValue(5)
    click(window, "add")
    slider = find(window.forms.obstacle, QSlider, "x_last")
    assert slider.maximum() == 9
    slider.setFocus()
    before = slider.value()
    QTest.keyClick(slider, Qt.Key.Key_Left)
    assert window.session.draft.rows[0].entry["last"][0] == before - 1


def test_sliders_reach_as_far_as_the_map(window: Window) -> None:
    for box in window.forms.basic.findChildren(QSpinBox, "chunks_field"):
        box.setValue(3)
    assert find(window.forms.obstacle, QSlider, "x_first").maximum() == 29


def test_undo_and_redo_by_key(window: Window) -> None:
    click(window, "add")
    QTest.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert kinds(window) == []
    window.session.redo()
    assert kinds(window) == ["horizontal_barrier"]


def test_a_problem_is_shown_in_its_row_and_start_is_disabled(window: Window) -> None:
    choose(window, "peak")
    window.forms.obstacle.default_ends.setChecked(False)
    for name in ("x_first", "y_first", "y_last"):
        find(window.forms.obstacle, QSlider, name).setValue(2)
    find(window.forms.obstacle, QSlider, "x_last").setValue(9)
    click(window, "add")
    window.session.set("chunk_size", 5)
    assert window.forms.error_label.text() == "Row 1, X last: 9 is outside 0..4"
    assert cell(window, 0, 1).toolTip() == "9 is outside 0..4"
    assert not window.forms.start.isEnabled()
    window.session.undo()
    assert window.forms.start.isEnabled()
    assert window.forms.error_label.isHidden()


def test_the_field_follows_changes(window: Window) -> None:
    choose(window, "random")
    click(window, "add")
    assert previewed(window) == build(window.session.recipe)
    assert "10 cm" in window.status.numbers.text() or "largest step" in window.status.numbers.text()


def test_difficulty_stands_in_the_form_and_eases_the_map(window: Window) -> None:
    choose(window, "peak")
    click(window, "add")
    field = find(window, QDoubleSpinBox, "difficulty_field")
    assert field.value() == 1
    field.setValue(0.25)
    assert window.session.recipe.difficulty == 0.25
    field.setValue(0)
    assert not previewed(window).levels.any()
    field.setValue(1)
    assert window.session.recipe.difficulty == 1


def test_a_range_of_difficulty_is_shown_and_stays(window: Window) -> None:
    window.session.set("difficulty", [0.2, 1, 5])
    field = find(window, QDoubleSpinBox, "difficulty_field")
    assert field.text() == "[0.2, 1, 5]"
    choose(window, "peak")
    click(window, "add")
    assert window.session.recipe.entry()["difficulty"] == [0.2, 1, 5]
    field.setValue(0.5)
    assert window.session.recipe.entry()["difficulty"] == 0.5


def test_frictions_are_in_the_form_with_their_errors_below(window: Window) -> None:
    field = find(window, QLineEdit, "level_friction_field")
    error_label = find(window, QLabel, "level_friction_error")
    for text, said in (("0.9,0.1", ""), ("0.9,rough", "'rough' is not a number; give 0..1000"), ("", "")):
        field.setText(text)
        field.editingFinished.emit()
        assert error_label.text() == said
        assert window.session.recipe.level_friction == ((0.9, 0.1) if text else None)


def test_a_row_is_edited_in_place_and_switched_off(window: Window) -> None:
    choose(window, "peak")
    click(window, "add")
    cell(window, 0, 3).setText("40")
    assert window.session.draft.rows[0].entry["softness"] == 40
    cell(window, 0, 0).setCheckState(Qt.CheckState.Unchecked)
    assert not window.session.recipe.obstacles


def test_a_recipe_is_saved_and_opened(window: Window, tmp_path: Path) -> None:
    choose(window, "random")
    click(window, "add")
    recipe = window.session.recipe
    window.session.save(tmp_path / "field.yaml")
    assert load(tmp_path / "field.yaml") == recipe
    window.document.open(Session.opened(tmp_path / "field.yaml"))
    assert window.views.table.rowCount() == 1
    assert "field.yaml" in window.windowTitle()


def test_an_obstacle_is_drawn_on_the_plan_and_its_end_dragged(window: Window) -> None:
    previewed(window)
    choose(window, "peak")
    window.views.plan.drawn.emit(2, 2, 6, 6)
    assert window.session.draft.rows[0].entry["first"] == [2, 2]
    assert window.views.table.selected == 0
    window.views.plan.moved.emit(0, "last", 8, 8)
    window.views.plan.moved.emit(0, "last", 9, 9)
    assert window.session.draft.rows[0].entry["last"] == [9, 9]
    window.session.undo()
    assert window.session.draft.rows[0].entry["last"] == [6, 6]


def pressed(window: Window, *blocks: tuple[int, int]) -> None:
    """A stroke of the left button over the plan."""
    assert window.previewer.scene
    plan = window.views.plan
    layout = fit(window.previewer.scene.field, plan_area(plan.width(), plan.height()), plan.devicePixelRatio())
    points = [QPoint(*map(round, layout.middle(block))) for block in blocks]
    QTest.mousePress(plan, LEFT, pos=points[0])
    for point in points[1:]:
        QTest.mouseMove(plan, point)
    QTest.mouseRelease(plan, LEFT, pos=points[-1])


def test_painted_cells_are_a_matrix_and_undo_removes_a_whole_stroke(window: Window) -> None:
    previewed(window)
    QTest.keyClick(window, Qt.Key.Key_P)
    QApplication.processEvents()  # the tools take some of the plan's room
    find(window, QSpinBox, "paint_level").setValue(3)
    assert find(window, QLabel, "paint_height").text() == "30 cm"
    pressed(window, (2, 2), (2, 5))
    QTest.keyClick(window.views.plan, Qt.Key.Key_1)
    assert window.session.draft.rows[0].entry["rows"] == ["1", "3", "3", "3"]
    assert (window.session.recipe.top_level, window.views.table.selected) == (3, 0)
    assert previewed(window).blocks[2, 2:6].tolist() == [3, 3, 3, 1]
    window.session.undo()
    window.session.undo()
    assert kinds(window) == []


def test_levels_of_a_matrix_can_be_typed_as_text(window: Window, monkeypatch: pytest.MonkeyPatch) -> None:
    choose(window, "matrix")
    click(window, "add")
    typed = staticmethod(lambda *_: ("0 1\n\n2 3 \n", True))
    monkeypatch.setattr("rsegen.gui.widgets.editors.QInputDialog.getMultiLineText", typed)
    click(window, "rows_field")
    assert window.session.draft.rows[0].entry["rows"] == ["0 1", "2 3"]
    assert find(window, QAbstractButton, "rows_field").text() == "2 x 2 cells..."
    monkeypatch.setattr(
        "rsegen.gui.widgets.editors.QInputDialog.getMultiLineText", staticmethod(lambda *_: ("0 1\n2", True))
    )
    click(window, "rows_field")
    assert "rows[1]: has 1 cells" in find(window, QLabel, "error").text()


def dropped(window: Window, path: Path) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    where = window.rect().center()
    copy, none = Qt.DropAction.CopyAction, Qt.KeyboardModifier.NoModifier
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # from PySide6 6.12 on it is a QPointF
        entering = QDragEnterEvent(where, copy, data, LEFT, none)
    window.dragEnterEvent(entering)
    window.dropEvent(QDropEvent(QPointF(where), copy, data, LEFT, none))


def test_an_image_is_dropped_and_read_as_the_dialog_says(window: Window, tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 255], [255, 0]], dtype=np.uint8)).save(tmp_path / "grey.png")
    complaints = []

    def answer() -> None:
        reading = window.findChild(HeightsDialog, "heights_dialog")
        if reading is None:
            QTimer.singleShot(50, answer)
            return
        unit = find(reading, QLineEdit, "unit_cm_field")
        QTest.keyClicks(unit, "-1")
        QTest.keyClick(reading, Qt.Key.Key_Return)
        complaints.append(find(reading, QLabel, "heights_error").text())
        unit.clear()
        QTest.keyClicks(unit, "5")
        find(reading, QAbstractButton, "invert_field").click()
        QTest.keyClick(reading, Qt.Key.Key_Return)

    QTimer.singleShot(100, answer)
    dropped(window, tmp_path / "grey.png")
    assert complaints == ["unit_cm: -1.0 is outside 0.001..100000 cm"]
    assert build(window.session.recipe).levels.tolist() == [[0, 4], [4, 0]]
    assert window.session.recipe.unit_cm == 5
    assert window.session.unsaved


def test_a_recipe_is_dropped(window: Window, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("chunk_size: 7\n", "utf-8")
    dropped(window, tmp_path / "a.yaml")
    assert window.session.recipe.chunk_size == 7


def test_the_chosen_robot_crosses_steps_that_it_climbs(window: Window) -> None:
    wall = {"kind": "horizontal_barrier", "levels": 5, "softness": 0, "first": [5, 0], "last": [5, 19]}
    window.session.set("chunks", [2, 2])
    window.session.set("boundary", "none")  # the crawler mostly does not cross frames of 10 cm
    window.session.add(wall)
    crossing, robot = find(window, QLabel, "crossing"), find(window, QComboBox, "robot")
    robot.setCurrentText("crawler")
    until(lambda: crossing.text() == "crosses south to north")
    window.session.add({**wall, "first": [0, 5], "last": [19, 5]})
    until(lambda: crossing.text().startswith("does not cross; largest area "))
    window.session.clear()
    until(lambda: crossing.text() == "crosses west to east and south to north")
    robot.setCurrentText("no robot")
    assert crossing.text() == ""


def test_every_input_has_an_accessible_name(window: Window) -> None:
    nameless = [
        widget.objectName()
        for widget in window.findChildren(QWidget)
        if widget.focusPolicy() & Qt.FocusPolicy.TabFocus
        and not (widget.accessibleName() or getattr(widget, "text", str)())
        and widget.objectName()
        and not widget.objectName().startswith("qt_")
    ]
    assert not nameless
    assert window.childAt(QPoint(5, 5)) is not None


def test_an_end_outside_the_map_is_reported_and_the_rest_goes_on(window: Window) -> None:
    choose(window, "peak")
    window.forms.obstacle.default_ends.setChecked(False)
    click(window, "add")
    window.document.select(0)
    cell(window, 0, 5).setText("99, 99")
    assert window.forms.error_label.text() == "Row 1, X last: 99 is outside 0..9"
    cell(window, 0, 5).setText("8, 9")
    assert previewed(window) == build(window.session.recipe)
    assert window.forms.error_label.isHidden()


def test_tab_goes_through_the_window_as_it_is_read(window: Window) -> None:
    choose(window, "peak")
    window.forms.obstacle.default_ends.setChecked(False)
    click(window, "add")
    window.document.select(0)
    wanted = ["maps_field", "mesh_type_field", "seed_field", "keep_seed", "reroll", "kind"]
    wanted += [
        "levels_field",
        "levels_field",
        "softness_field",
        "softness_field",
        "default_ends",
    ]  # slider, number
    wanted += ["x_first", "y_first", "x_last", "y_last", "folder", "start", "add"]
    names, widget = [], window.nextInFocusChain()
    while widget is not None and widget is not window:
        if widget.focusPolicy() & Qt.FocusPolicy.TabFocus:
            names.append(widget.objectName())
        widget = widget.nextInFocusChain()
    assert [name for name in names if name in wanted] == wanted


def test_every_button_has_a_description(window: Window) -> None:
    silent = [button.objectName() for button in window.findChildren(QAbstractButton) if not button.toolTip()]
    assert [name for name in silent if name and not name.startswith("qt_") and name not in SELF_EXPLAINING] == []


def test_a_tooltip_is_spoken_without_markup(window: Window) -> None:
    robot = find(window, QComboBox, "robot")
    assert robot.toolTip() == f"<p>{robot.accessibleDescription()}</p>"
    assert robot.accessibleDescription().startswith("whether this robot can cross the map")


def test_a_picture_that_cannot_be_written_is_one_line(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "nowhere" / "x.png"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(lambda *_: (str(path), "")))
    messages = answer(QMessageBox.StandardButton.Ok)
    (action,) = window.findChildren(QAction, "Save picture")
    action.trigger()
    QTest.keyClick(find(window, PictureSizeDialog, "picture_size_dialog"), Qt.Key.Key_Return)
    until(lambda: bool(messages))
    assert messages == [f"{path}: cannot be written as a picture; give a name in an existing folder, such as x.png"]


def test_a_place_beyond_the_map_can_be_typed_and_is_an_error(window: Window) -> None:
    window.session.add({"kind": "peak", "levels": 5, "first": [2, 2], "last": [5, 5]})
    window.document.select(0)
    typed(window, "x_first_number", "99")
    assert window.session.draft.rows[0].entry["first"] == [99, 2]
    assert find(window.forms.obstacle, QSpinBox, "x_first_number").text() == "99"
    assert window.forms.error_label.text() == "Row 1, X first: 99 is outside 0..9"
    for name in ("start", "export", "spawn", "open_in"):
        assert not find(window, QAbstractButton, name).isEnabled()
    typed(window, "x_first_number", "3")
    assert window.session.draft.rows[0].entry["first"] == [3, 2]
    assert not window.forms.error_label.text()
    for name in ("start", "export", "spawn", "open_in"):
        assert find(window, QAbstractButton, name).isEnabled()


def test_a_barrier_moves_as_a_whole_when_its_place_is_typed(window: Window) -> None:
    window.session.add({"kind": "horizontal_barrier", "levels": 5, "first": [9, 0], "last": [9, 7]})
    window.document.select(0)
    typed(window, "x_first_number", "4")
    entry = window.session.draft.rows[0].entry
    assert (entry["first"], entry["last"]) == ([4, 0], [4, 7])


def test_the_wheel_scrolls_the_form_and_changes_no_value(window: Window) -> None:
    for name in ("levels_field", "chunk_size_field", "boundary_field", "kind"):
        for field in window.forms.findChildren(QWidget, name):
            before = window.session.draft, window.forms.obstacle.entry()
            window.setFocus()
            spin(field)
            assert (window.session.draft, window.forms.obstacle.entry()) == before
    box = find(window.forms.obstacle, QSpinBox, "levels_field")
    box.setFocus()
    spin(box)
    assert box.value() == 6


def spin(field: QWidget) -> None:
    """One notch of the wheel upwards."""
    middle, none = QPointF(field.rect().center()), Qt.KeyboardModifier.NoModifier
    phase = Qt.ScrollPhase.NoScrollPhase
    at, angle = field.mapToGlobal(middle), QPoint(0, 120)
    event = QWheelEvent(middle, at, QPoint(), angle, Qt.MouseButton.NoButton, none, phase, False)  # noqa: FBT003  # Qt's
    QApplication.sendEvent(field, event)


def test_the_written_folder_is_forgotten_when_another_recipe_is_opened(window: Window, tmp_path: Path) -> None:
    window.outputs.start_into(tmp_path / "worlds")
    outcome = find(window, QLabel, "outcome")
    until(lambda: outcome.text().startswith("1 map in"))
    choose(window, "peak")
    window.document.open(Session.new())
    assert window.forms.obstacle.entry()["kind"] == DEFAULT["kind"]
    assert outcome.text() == ""
    assert not find(window, QAbstractButton, "open_folder").isVisible()
