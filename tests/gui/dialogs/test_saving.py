"""Pictures saved in a thread: with a dialog that cancels, and no file unless it is whole."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QApplication, QMessageBox, QPushButton, QWidget

from rsegen.gui.dialogs.outputs import SavingDialog
from rsegen.gui.workers import PictureSaver
from tests.support.clicking import answer
from tests.support.waiting import exposed, until


class Drawing:
    """A picture that is drawn when it may be."""

    def __init__(self) -> None:
        self.begun, self.may_end = threading.Event(), threading.Event()

    def __call__(self) -> QImage:
        self.begun.set()
        self.may_end.wait()
        image = QImage(40, 30, QImage.Format.Format_RGB888)
        image.fill(Qt.GlobalColor.red)
        return image


@pytest.fixture
def window(app: QApplication) -> Iterator[QWidget]:
    window = QWidget()
    window.show()
    exposed(window)
    yield window
    window.close()


@pytest.mark.parametrize("name", ["x.png", "x.jpg", "y.PNG"])
def test_the_dialog_is_open_until_the_picture_is_written(window: QWidget, tmp_path: Path, name: str) -> None:
    saver, draw = PictureSaver(window), Drawing()
    saved = QSignalSpy(saver.saved)
    dialog = SavingDialog(saver, draw, tmp_path / name, window)
    until(draw.begun.is_set)
    assert dialog.isVisible()
    assert saved.count() == 0
    assert dialog.labelText() == f"Saving {name}..."
    draw.may_end.set()
    until(lambda: not window.findChildren(SavingDialog))
    assert QImage(str(tmp_path / name)).size().toTuple() == (40, 30)
    assert saved.at(0) == [tmp_path / name]
    saver.stop()


def test_cancel_closes_it_at_once_and_leaves_the_file_as_it_was(window: QWidget, tmp_path: Path) -> None:
    (tmp_path / "x.png").write_text("mine")
    saver, draw = PictureSaver(window), Drawing()
    dialog = SavingDialog(saver, draw, tmp_path / "x.png", window)
    until(draw.begun.is_set)
    (button,) = dialog.findChildren(QPushButton)
    button.click()
    until(lambda: not window.findChildren(SavingDialog))
    assert not draw.may_end.is_set()
    draw.may_end.set()
    saver.stop()
    assert (tmp_path / "x.png").read_text() == "mine"


def test_after_a_cancelled_one_another_is_saved(window: QWidget, tmp_path: Path) -> None:
    saver, first, second = PictureSaver(window), Drawing(), Drawing()
    dialog = SavingDialog(saver, first, tmp_path / "first.png", window)
    until(first.begun.is_set)
    dialog.close()
    SavingDialog(saver, second, tmp_path / "second.png", window)
    first.may_end.set()
    until(second.begun.is_set)
    second.may_end.set()
    until((tmp_path / "second.png").exists)
    until(lambda: not window.findChildren(SavingDialog))
    assert not (tmp_path / "first.png").exists()
    saver.stop()


@pytest.mark.parametrize("name", ["nowhere/x.png", "x.abc", "x"])
def test_an_unwritable_output_is_refused_in_one_line(window: QWidget, tmp_path: Path, name: str) -> None:
    saver, draw = PictureSaver(window), Drawing()
    asked = answer(QMessageBox.StandardButton.Ok)
    SavingDialog(saver, draw, tmp_path / name, window)
    draw.may_end.set()
    until(lambda: bool(asked))
    words = "cannot be written as a picture; give a name in an existing folder, such as x.png"
    assert asked == [f"{tmp_path / name}: {words}"]
    until(lambda: not window.findChildren(SavingDialog))
    saver.stop()
