"""The dialog of drives: its first robot, and its room on the screen."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QApplication, QComboBox

from rsegen import Recipe
from rsegen.gui.dialogs.job import DriveDialog
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import find, shown


@pytest.fixture
def dialog(app: QApplication) -> DriveDialog:
    return DriveDialog(Recipe(seed=1), 0)


def test_it_starts_with_the_robot_of_the_window(app: QApplication) -> None:
    window = Window(Session.new())
    with shown(window):
        for row, robot in enumerate(["burger", *(window.status.robot.itemText(row) for row in (1, 2, 3))]):
            window.status.robot.setCurrentIndex(row)
            window.outputs.drive()
            opened = find(window, DriveDialog, "drive_dialog")
            assert find(opened, QComboBox, "robot_field").currentText() == robot
            opened.close()
            opened.setObjectName("closed")


def test_it_grows_with_its_content_and_stays_on_the_screen(dialog: DriveDialog) -> None:
    dialog.show()
    screen = dialog.screen().availableGeometry()
    dialog.move(screen.right() - 100, screen.bottom() - 100)
    dialog._picture.setFixedHeight(screen.height() // 2)
    dialog._picture.show()
    dialog.make_room()
    assert dialog.height() >= dialog.heightForWidth(dialog.width()) > screen.height() // 2
    assert screen.contains(dialog.geometry())
    dialog.make_room(QSize(10 * screen.width(), 10 * screen.height()))
    assert screen.contains(dialog.geometry())
    dialog.close()
