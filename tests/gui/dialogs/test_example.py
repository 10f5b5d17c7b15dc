"""The examples as pictures, opened with real clicks and keys."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QListWidget

from rsegen import load
from rsegen.exporters.scene import FRAME_COLOUR
from rsegen.gui.application import session_of
from rsegen.gui.dialogs.opening import SIDE, ExampleDialog
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.recipe.examples import EXAMPLES
from tests.support.clicking import shown
from tests.support.waiting import exposed

LEFT = Qt.MouseButton.LeftButton
CONTROL_SHIFT = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.activateWindow()
    with shown(window):
        yield window


@pytest.fixture
def dialog(window: Window) -> ExampleDialog:
    QTest.keyClick(window, Qt.Key.Key_N, CONTROL_SHIFT)
    (found,) = window.findChildren(ExampleDialog)
    exposed(found)
    return found


def board(dialog: ExampleDialog) -> QListWidget:
    (found,) = dialog.findChildren(QListWidget)
    return found


def test_every_example_is_listed_with_name_and_description(dialog: ExampleDialog) -> None:
    pictures = board(dialog)
    assert [pictures.item(row).text() for row in range(pictures.count())] == list(EXAMPLES)
    (about,) = dialog.findChildren(QLabel, "about")
    for row, path in enumerate(EXAMPLES.values()):
        pictures.setCurrentRow(row)
        assert about.text() == load(path).description


def test_a_picture_is_the_map_from_above(dialog: ExampleDialog) -> None:
    item = board(dialog).item(list(EXAMPLES).index("mixed-course"))
    image = item.icon().pixmap(SIDE, SIDE).toImage()
    rim = QColor(*(round(part * 255) for part in FRAME_COLOUR))
    assert image.pixelColor(1, image.height() // 2).rgb() == rim.rgb()
    colours = {image.pixelColor(x, image.height() // 2).rgb() for x in range(image.width())}
    assert len(colours) > 3


def test_a_double_click_opens_a_copy_that_is_bound_to_no_file(window: Window, dialog: ExampleDialog) -> None:
    page = board(dialog)
    place = page.visualItemRect(page.item(list(EXAMPLES).index("turtlebot"))).center()
    QTest.mouseClick(page.viewport(), LEFT, pos=place)
    QTest.mouseDClick(page.viewport(), LEFT, pos=place)
    assert not dialog.isVisible()
    assert window.session.recipe == load(EXAMPLES["turtlebot"])
    assert window.session.path is None
    assert not window.session.unsaved


def test_arrows_and_enter_open_one(window: Window, dialog: ExampleDialog) -> None:
    QTest.keyClick(board(dialog), Qt.Key.Key_Right)
    QTest.keyClick(board(dialog), Qt.Key.Key_Return)
    assert window.session.recipe == load(list(EXAMPLES.values())[1])


def test_escape_leaves_all_as_it_was(window: Window, dialog: ExampleDialog) -> None:
    before = window.session
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert not dialog.isVisible()
    assert window.session is before


def test_an_example_on_the_command_line_is_a_copy_and_a_file_is_not(tmp_path: Path) -> None:
    assert session_of(EXAMPLES["peak"]).path is None
    mine = tmp_path / "peak.yaml"
    mine.write_bytes(EXAMPLES["peak"].read_bytes())
    assert session_of(mine).path == mine
