"""The command and the program that the window shows, copied with real clicks, and run."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPlainTextEdit, QPushButton

from rsegen import generate
from rsegen.cli import main
from rsegen.gui.dialogs.outputs import CodeDialog
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import shown

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(app: QApplication, tmp_path: Path) -> Iterator[Window]:
    window = Window(Session.new())
    window.session.add({"kind": "random", "levels": 3})
    window.forms.start_form.folder = tmp_path / "my worlds"
    window.activateWindow()
    with shown(window):
        yield window


@pytest.fixture
def dialog(window: Window) -> CodeDialog:
    QTest.keyClick(window, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    (found,) = window.findChildren(CodeDialog)
    return found


def spelled(dialog: CodeDialog, name: str) -> str:
    (page,) = dialog.findChildren(QPlainTextEdit, name)
    assert page.isReadOnly()
    assert page.fontInfo().fixedPitch() or not page.fontInfo().exactMatch()
    return page.toPlainText()


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_command_and_the_program_make_the_same_maps_as_start(
    window: Window, dialog: CodeDialog, tmp_path: Path
) -> None:
    generate(window.session.recipe, tmp_path / "expected")
    assert main(shlex.split(spelled(dialog, "command_line"))[1:]) == 0
    assert files(tmp_path / "my worlds") == files(tmp_path / "expected")
    (tmp_path / "my worlds").rename(tmp_path / "first")
    exec(spelled(dialog, "python_code"), {})  # noqa: S102  # our own
    assert files(tmp_path / "my worlds") == files(tmp_path / "expected")


@pytest.mark.parametrize("name", ["command_line", "python_code"])
def test_either_is_copied_whole(dialog: CodeDialog, name: str) -> None:
    (button,) = dialog.findChildren(QPushButton, f"copy_{name}")
    QTest.mouseClick(button, LEFT)
    assert QGuiApplication.clipboard().text() == spelled(dialog, name)
