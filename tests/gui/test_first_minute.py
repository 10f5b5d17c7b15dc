"""What a newcomer does first: every step is valid, shown before it is done, and nothing is taken away."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QPoint, QSettings, QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QLabel,
    QLineEdit,
    QMenu,
    QMessageBox,
    QPushButton,
    QSlider,
    QSpinBox,
    QToolButton,
    QWidget,
)

from rsegen import load
from rsegen.field.obstacles import KINDS
from rsegen.gui.model.session import Session
from rsegen.gui.widgets import layouts
from rsegen.gui.widgets.map_views import Welcome
from rsegen.gui.window import Window
from rsegen.recipe.examples import EXAMPLES
from tests.support.clicking import answer, click, find, said, shown
from tests.support.waiting import until

LEFT = Qt.MouseButton.LeftButton
BUTTON = QMessageBox.StandardButton


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    QSettings("rsegen", "rsegen").clear()
    window = Window(Session.new())
    with shown(window):
        yield window
    QSettings("rsegen", "rsegen").clear()


def title(window: Window) -> str:
    return window.forms._group.title()


def has_ghost(window: Window) -> bool:
    return window.views.plan._ghost is not None


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_the_untouched_defaults_of_every_kind_are_valid(window: Window, kind: str, seed: int) -> None:
    window.session.set("seed", seed)
    form = window.forms.obstacle
    form.kind.setCurrentIndex(form.kind.findData(kind))
    click(window, "default_ends")
    click(window, "add")
    assert window.session.problem is None
    assert {"first", "last"} <= set(window.session.draft.rows[0].entry)
    for name, end, axis in (("x_first", "first", 0), ("y_last", "last", 1)):
        find(form, QSlider, name).setValue(5)
        assert window.session.problem is None, window.session.problem
        assert window.session.draft.rows[0].entry[end][axis] == 5


def test_the_ghost_of_the_form_goes_with_it_until_the_obstacle_is_added(window: Window) -> None:
    until(lambda: has_ghost(window))
    assert (window.session.draft.rows, title(window)) == ((), "New obstacle")
    click(window, "add")
    until(lambda: not has_ghost(window))
    assert title(window) == "Obstacle 1: horizontal barrier"
    QTest.keyClick(window, Qt.Key.Key_Escape)
    assert (title(window), window.document.selected) == ("New obstacle", -1)
    find(window.forms.obstacle, QSpinBox, "levels_field").setValue(7)
    until(lambda: has_ghost(window))
    assert window.session.draft.rows[0].entry["levels"] == 5
    window.document.select(0)
    until(lambda: not has_ghost(window))


def test_a_click_outside_the_rows_and_a_button_clear_the_selection(window: Window) -> None:
    window.resize(1280, 900)
    click(window, "add")
    table = window.views.table
    QTest.mouseClick(table.viewport(), LEFT, pos=QPoint(20, table.viewport().height() - 4))
    assert window.document.selected == -1
    window.document.select(0)
    click(window, "another")
    assert window.document.selected == -1


def test_minus_removes_the_selected_obstacle_and_else_the_last(window: Window) -> None:
    for kind in ("peak", "random", "platform"):
        window.document.add({"kind": kind, "levels": 5})
    window.document.select(0)
    click(window, "remove")
    assert [row.entry["kind"] for row in window.session.draft.rows] == ["random", "platform"]
    window.document.select(-1)
    click(window, "remove")
    assert [row.entry["kind"] for row in window.session.draft.rows] == ["random"]


def test_an_empty_window_says_how_to_begin_and_opens_an_example(window: Window) -> None:
    welcome = window.views.welcome
    assert welcome.isVisible()
    QTest.mouseClick(find(welcome, QToolButton, "example_mixed-course"), LEFT)
    assert window.session.recipe.obstacles == load(EXAMPLES["mixed-course"]).obstacles
    assert not welcome.isVisible()
    assert window.windowTitle() == "copy of mixed-course[*] - rsegen"


def test_the_pictures_of_the_welcome_are_made_only_if_it_is_shown(app: QApplication) -> None:
    welcome = Welcome()
    assert not welcome.findChildren(QToolButton)
    welcome.show()
    assert len(welcome.findChildren(QToolButton)) == 4
    welcome.close()


def test_blend_is_described(window: Window) -> None:
    assert said(window, "about_blend") == "This obstacle overwrites the earlier ones."
    assert said(window, "about_kind").startswith("A straight ridge along x or y.")


def test_closing_offers_to_save(window: Window, tmp_path: Path) -> None:
    window.session.path = tmp_path / "mine.yaml"
    click(window, "add")
    asked = answer(BUTTON.Cancel)
    assert not window.close()
    assert asked == ["Save the changes of mine.yaml?"]
    answer(BUTTON.Save)
    assert window.files.may_leave()
    assert load(tmp_path / "mine.yaml").obstacles == window.session.recipe.obstacles
    click(window, "add")
    answer(BUTTON.Discard)
    assert window.files.may_leave()


def test_saving_asks_before_it_drops_obstacles_that_are_switched_off(window: Window, tmp_path: Path) -> None:
    path = window.session.path = tmp_path / "mine.yaml"
    click(window, "add")
    click(window, "add")
    window.session.enable(0, enabled=False)
    draft = window.session.draft
    asked = answer(BUTTON.Cancel)
    window.files.save()
    assert asked == ["1 obstacle is switched off and a recipe file can't hold it: save without it?"]
    assert not path.exists()
    assert window.session.unsaved
    assert window.session.draft == draft
    answer(BUTTON.Save)
    window.files.save()
    assert len(load(path).obstacles) == 1
    assert not window.session.unsaved


def test_closing_and_saving_asks_before_it_drops_obstacles_that_are_switched_off(
    window: Window, tmp_path: Path
) -> None:
    path = window.session.path = tmp_path / "mine.yaml"
    click(window, "add")
    click(window, "add")
    for row in range(2):
        window.session.enable(row, enabled=False)
    first, second = answer(BUTTON.Save), answer(BUTTON.Cancel)
    assert not window.close()
    assert first == ["Save the changes of mine.yaml?"]
    assert second == ["2 obstacles are switched off and a recipe file can't hold them: save without them?"]
    assert not path.exists()
    answer(BUTTON.Save)
    answer(BUTTON.Save)
    assert window.files.may_leave()
    assert load(path).obstacles == ()


def test_a_message_passes_and_leaves_the_numbers_in_sight(window: Window, monkeypatch: pytest.MonkeyPatch) -> None:
    window.forms.note._pause.setInterval(50)
    window.outputs.spawn_job.message.emit("rse_0000 is in the simulation")
    assert said(window, "note") == "rse_0000 is in the simulation"
    assert window.status.numbers.isVisible()
    assert window.status.index.isVisible()
    until(lambda: not said(window, "note"))
    assert layouts.PASSES > 5000


def test_parameters_are_filtered_by_name_and_help(window: Window) -> None:
    window.forms.tabs.setCurrentIndex(1)
    field = find(window.forms, QLineEdit, "filter")
    QTest.keyClicks(field, "robot")
    seen = [each.objectName() for each in window.forms.advanced.findChildren(QWidget) if each.isVisible()]
    assert "crossable_by" in seen
    assert "friction" not in seen
    field.clear()
    assert window.forms.advanced.groups["Friction"]._editors["friction"].isVisible()


def test_selecting_an_obstacle_brings_its_form_back(window: Window) -> None:
    click(window, "add")
    window.document.select(-1)
    window.forms.tabs.setCurrentIndex(1)
    assert not window.forms.obstacle.isVisible()
    window.document.select(0)
    assert window.forms.obstacle.isVisible()


def test_a_new_window_is_no_larger_than_the_screen_and_remembers_its_parts(window: Window) -> None:
    room = window.screen().availableSize()
    assert window.size().boundedTo(room) == window.size()
    assert window.minimumSizeHint().boundedTo(QSize(800, 480)) == window.minimumSizeHint()
    window.forms.tabs.setCurrentIndex(1)
    window.views.setSizes([200, 300])
    sizes = window.views.sizes()
    window.close()
    again = Window(Session.new())
    with shown(again):
        assert again.forms.tabs.currentIndex() == 1
        assert abs(again.views.sizes()[0] - sizes[0]) < 40


def test_the_seed_is_shown_whole(window: Window) -> None:
    window.session.set("seed", 2**63 - 1)
    field = find(window.forms, QLineEdit, "seed_field")
    assert field.fontMetrics().horizontalAdvance(field.text()) < field.width()


def test_a_written_map_can_be_opened_and_sent_next_to_start(window: Window, tmp_path: Path) -> None:
    button = find(window.forms, QPushButton, "open_in")
    assert not button.isVisible()
    window.outputs.start_into(tmp_path / "out")
    until(button.isVisible)
    assert str(tmp_path / "out") in find(window.forms.start_form, QLabel, "outcome").text()
    QTest.mouseClick(button, LEFT)
    menu = QApplication.activePopupWidget()
    assert isinstance(menu, QMenu)
    assert [action.objectName() for action in menu.actions()] == ["Open in Gazebo Sim", "Open in Gazebo Classic"]
    menu.close()
