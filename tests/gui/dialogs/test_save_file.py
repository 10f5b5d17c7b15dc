"""Where a file is saved: its name gets the suffix of its format, and nothing is replaced unasked."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QWidget

from rsegen.gui.dialogs.opening import ask_where_to_save
from tests.support.clicking import answer

FORMATS = "PNG (*.png);;JPEG (*.jpg *.jpeg)"


@pytest.mark.parametrize(
    ("name", "chosen", "found"),
    [
        ("slide.png", "PNG (*.png)", "slide.png"),
        ("slide.JPEG", "PNG (*.png)", "slide.JPEG"),
        ("slide", "PNG (*.png)", "slide.png"),
        ("slide", "JPEG (*.jpg *.jpeg)", "slide.jpg"),
        ("slide", "", "slide.png"),
        ("my.first slide", "PNG (*.png)", "my.first slide.png"),
    ],
)
def test_a_name_without_the_suffix_of_a_format_gets_one(
    name: str, chosen: str, found: str, app: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(lambda *_: (str(tmp_path / name), chosen)))
    parent = QWidget()
    assert ask_where_to_save(parent, "Save", "field.png", FORMATS) == tmp_path / found


@pytest.mark.parametrize("replaces", [False, True])
def test_a_file_that_has_the_name_with_its_suffix_is_not_replaced_unasked(
    replaces: bool, app: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "slide.png").touch()
    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(lambda *_: (str(tmp_path / "slide"), "")))
    parent, buttons = QWidget(), QMessageBox.StandardButton
    questions = answer(buttons.Yes if replaces else buttons.No)
    assert ask_where_to_save(parent, "Save", "x.png", FORMATS) == (tmp_path / "slide.png" if replaces else None)
    assert questions == ["slide.png already exists. Replace it?"]


def test_no_name_is_no_file(app: QApplication, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(lambda *_: ("", "")))
    parent = QWidget()
    assert ask_where_to_save(parent, "Save", "x.png", FORMATS) is None
