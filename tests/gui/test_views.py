"""Plan and view in the window: tools, zoom, pictures, with real clicks and keys."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QPoint, Qt, QTimer
from PySide6.QtGui import QAction, QColor, QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QFileDialog, QSpinBox

from rsegen.gui.dialogs.outputs import PictureSizeDialog, SavingDialog
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import active, click, find, shown, typed
from tests.support.waiting import until

pytestmark = pytest.mark.long(reason="views in three dimensions need VTK, 0.6 GB")

LEFT = Qt.MouseButton.LeftButton
STEPS = {"kind": "matrix", "levels": 4, "rows": ["0 0 3 3", "0 0 3 1"], "first": [2, 2], "last": [5, 3]}


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    window.session.add(STEPS)
    with shown(window):
        previewed(window)
        QApplication.processEvents()
        yield window


def previewed(window: Window) -> None:
    until(lambda: window.previewer.scene is not None and window.previewer.scene.recipe == window.session.recipe)


def at(window: Window, block: tuple[int, int]) -> QPoint:
    QApplication.processEvents()
    layout = window.views.plan.plan_layout
    assert layout
    return QPoint(*map(round, layout.middle(block)))


def test_tools_and_levels_are_buttons_shown_while_painting(window: Window) -> None:
    box = find(window, QAbstractButton, "paint_box")
    assert not box.isVisible()
    click(window, "paint")
    assert box.isVisible()
    levels = [find(window, QAbstractButton, f"paint_level_{level}") for level in range(8)]
    assert [each.text() for each in levels if each.isVisible()] == ["0", "10", "20", "30"]
    click(window, "paint_level_3")
    assert find(window, QSpinBox, "paint_level").value() == 3
    click(window, "paint_box")
    plan = window.views.plan
    QTest.mousePress(plan, LEFT, pos=at(window, (0, 0)))
    QTest.mouseMove(plan, at(window, (1, 1)))
    QTest.mouseRelease(plan, LEFT, pos=at(window, (1, 1)))
    previewed(window)
    assert window.previewer.scene
    assert window.previewer.scene.field.blocks[:2, :2].tolist() == [[3, 3], [3, 3]]


def test_keys_choose_the_tools_while_painting_and_only_then(window: Window) -> None:
    active(window)
    window.views.plan.setFocus()
    QTest.keyClick(window.views.plan, Qt.Key.Key_F)
    assert find(window, QAbstractButton, "paint_cells").isChecked()
    QTest.keyClick(window.views.plan, Qt.Key.Key_P)
    for key, name in ((Qt.Key.Key_F, "fill"), (Qt.Key.Key_R, "box"), (Qt.Key.Key_I, "pick"), (Qt.Key.Key_B, "cells")):
        QTest.keyClick(window.views.plan, key)
        assert find(window, QAbstractButton, f"paint_{name}").isChecked()


def test_a_level_is_picked_from_the_map_and_filled_in_elsewhere(window: Window) -> None:
    click(window, "paint")
    click(window, "paint_pick")
    QTest.mouseClick(window.views.plan, LEFT, pos=at(window, (4, 3)))
    assert find(window, QSpinBox, "paint_level").value() == 3
    assert find(window, QAbstractButton, "paint_cells").isChecked()
    click(window, "paint_fill")
    QTest.mouseClick(window.views.plan, LEFT, pos=at(window, (9, 9)))
    previewed(window)
    assert window.previewer.scene
    blocks = window.previewer.scene.field.blocks
    assert (int((blocks == 3).sum()), int((blocks == 1).sum())) == (99, 1)
    window.session.undo()
    assert window.session.draft.rows[0].entry["rows"] == STEPS["rows"]


def test_the_whole_map_is_shown_by_a_key(window: Window) -> None:
    plan = window.views.plan
    whole = plan.plan_layout
    plan.zoom(3)
    assert plan.plan_layout != whole
    QTest.keyClick(active(window), Qt.Key.Key_0, Qt.KeyboardModifier.ControlModifier)
    assert plan.plan_layout == whole


def test_a_cell_that_is_clicked_in_the_view_chooses_its_obstacle(window: Window) -> None:
    window.views.view.clicked.emit((1, 1))
    assert window.document.selected == -1
    window.views.view.clicked.emit((4, 4))
    assert (window.document.selected, window.views.table.selected) == (0, 0)
    window.views.view.clicked.emit(None)
    assert (window.document.selected, window.views.table.selected) == (-1, -1)


def test_the_reach_of_the_chosen_robot_is_on_the_plan_until_the_map_changes(window: Window) -> None:
    window.session.set("boundary", "none")
    window.session.set("seed", 1)  # of the start and the goal
    previewed(window)
    plan, robot = window.views.plan, find(window, QComboBox, "robot")
    before = plan.grab().toImage()
    robot.setCurrentText("burger")
    until(lambda: plan._reach is not None)
    assert plan._reach
    assert window.previewer.scene
    assert plan._reach.region.shape == window.previewer.scene.field.shape
    assert not plan._reach.region[4, 2]
    there = plan.grab().toImage()
    assert there.pixelColor(at(window, (5, 2)) + QPoint(6, 6)).lightness() > 200  # a veil over a block
    assert there.pixelColor(at(window, (8, 8))) == before.pixelColor(at(window, (8, 8)))
    ways = [QColor(255, 45, 149), QColor(255, 140, 0)]
    assert all(any(there.pixelColor(x, y) == way for x in range(400) for y in range(300)) for way in ways)
    window.session.set("unit_cm", 9)
    previewed(window)
    until(lambda: plan._reach is not None)
    robot.setCurrentText("no robot")
    assert plan._reach is None


def chosen(window: Window, monkeypatch: pytest.MonkeyPatch, entry: str, path: Path) -> None:
    """Choose an entry of the menu View, and a file."""
    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(lambda *_: (str(path), "")))
    (action,) = window.findChildren(QAction, entry)
    action.trigger()


def test_the_plan_is_saved_from_the_menu(window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chosen(window, monkeypatch, "Save plan", tmp_path / "plan.pdf")
    assert (tmp_path / "plan.pdf").read_bytes().startswith(b"%PDF")


def test_a_picture_is_saved_in_the_size_that_is_typed(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen(window, monkeypatch, "Save picture", tmp_path / "view.png")
    dialog = find(window, PictureSizeDialog, "picture_size_dialog")
    view = window.views.view
    assert find(dialog, QSpinBox, "picture_width").value() == 2 * view.width() * view.devicePixelRatioF()
    typed(dialog, "picture_width", "640")
    typed(dialog, "picture_height", "360")
    QTimer.singleShot(0, lambda: QTest.keyClick(dialog, Qt.Key.Key_Return))
    until((tmp_path / "view.png").exists)
    until(lambda: not window.findChildren(SavingDialog))
    picture = QImage(str(tmp_path / "view.png"))
    has_view = view._actors is not None
    assert (picture.width(), picture.height()) == ((640, 360) if has_view else view.pixels.toTuple())
