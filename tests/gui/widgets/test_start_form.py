"""Start, the folder beside it, and the seed that is kept or drawn, with real clicks and keys."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QObject, Qt, QUrl, Slot
from PySide6.QtGui import QAction, QDesktopServices
from PySide6.QtWidgets import QApplication, QCheckBox, QFileDialog, QLineEdit, QMessageBox, QPushButton

from rsegen import load
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from tests.support.clicking import answer, click, find, said, shown, typed
from tests.support.waiting import until

LEFT = Qt.MouseButton.LeftButton
Said = QMessageBox.StandardButton


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.resize(1280, 720)
    window.session.add({"kind": "random", "levels": 3})
    with shown(window):
        yield window


def started(window: Window) -> None:
    click(window, "start")
    until(window.forms.start.isVisible)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


class Desktop(QObject):
    """What the desktop is asked to open."""

    opened: str = ""

    @Slot(QUrl)
    def show_it(self, url: QUrl) -> None:
        self.opened = url.toLocalFile()


def test_start_writes_the_maps_into_the_folder_that_is_typed(window: Window, tmp_path: Path) -> None:
    window.session.set("maps", 3)
    typed(window, "folder", str(tmp_path / "new" / "worlds"))
    assert said(window, "outcome") == ""
    started(window)
    assert names(tmp_path / "new" / "worlds") == ["rse_0000", "rse_0001", "rse_0002"]
    seed = window.session.recipe.seed
    assert said(window, "outcome") == f"3 maps in {tmp_path / 'new' / 'worlds'}, seed {seed}"


def test_a_tilde_of_nobody_is_a_name_like_any_other(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    typed(window, "folder", "~nobody-such")
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", staticmethod(lambda *_: ""))
    click(window, "choose_folder")
    started(window)
    assert names(tmp_path) == ["~nobody-such"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a\0b", "'a\\x00b' is not the name of a folder; give one such as worlds"),
        ("x" * 300, f"{'x' * 300}: "),
        ("  ", "give a folder to write the maps into, such as worlds"),
    ],
)
def test_a_folder_that_cannot_be_is_one_line(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    find(window, QLineEdit, "folder").setText(name)
    started(window)
    until(lambda: said(window, "folder_error") != "")
    assert said(window, "folder_error").startswith(message)
    assert names(tmp_path) == []


def test_the_folder_is_remembered(window: Window, tmp_path: Path) -> None:
    typed(window, "folder", str(tmp_path / "mine"))
    started(window)
    another = Window(Session.new())
    assert another.forms.start_form.folder == tmp_path / "mine"
    another.close()


def test_the_folder_is_opened_by_the_desktop(window: Window, tmp_path: Path) -> None:
    (menu,) = (action for action in window.findChildren(QAction) if action.objectName() == "Open the folder")
    assert not menu.isEnabled()
    typed(window, "folder", str(tmp_path / "worlds"))
    started(window)
    desktop = Desktop()
    QDesktopServices.setUrlHandler("file", desktop, "show_it")  # type: ignore[arg-type]  # so it is called
    click(window, "open_folder")
    QDesktopServices.unsetUrlHandler("file")
    assert desktop.opened == str(tmp_path / "worlds")
    assert menu.isEnabled()


def test_a_file_in_the_folders_place_is_one_line_below_it(window: Window, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    typed(window, "folder", str(tmp_path / "taken"))
    click(window, "start")
    assert said(window, "folder_error") == f"{tmp_path / 'taken'}: is a file; give a folder"
    typed(window, "folder", "elsewhere")
    assert said(window, "folder_error") == ""


def test_no_folder_is_one_line(window: Window) -> None:
    typed(window, "folder", "")
    click(window, "start")
    assert said(window, "folder_error") == "give a folder to write the maps into, such as worlds"


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="only Linux has a folder that nobody can write to")
def test_a_folder_that_cannot_be_written_to_is_one_line_below_it(window: Window) -> None:
    typed(window, "folder", "/proc/self/worlds")
    started(window)
    assert said(window, "folder_error").startswith("/proc/self/worlds")
    assert said(window, "outcome") == ""


def test_existing_maps_are_replaced_only_after_confirmation(window: Window, tmp_path: Path) -> None:
    typed(window, "folder", str(tmp_path))
    started(window)
    before = os.stat(tmp_path / "rse_0000").st_ino
    answer(Said.No)
    click(window, "start")
    assert os.stat(tmp_path / "rse_0000").st_ino == before
    answer(Said.Yes)
    started(window)
    assert os.stat(tmp_path / "rse_0000").st_ino != before


def test_a_run_is_cancelled_between_two_maps(window: Window, tmp_path: Path) -> None:
    window.session.set("maps", 2000)
    typed(window, "folder", str(tmp_path))
    click(window, "start")
    until(lambda: window.forms.start_form.bar.value() > 0)
    click(window, "cancel")
    until(window.forms.start.isVisible)
    made = len(names(tmp_path))
    assert 0 < made < 2000
    assert said(window, "outcome") == f"Cancelled: {made} of 2000 maps are in {tmp_path}"


def test_a_kept_seed_is_that_of_every_start(window: Window, tmp_path: Path) -> None:
    seed = window.session.recipe.seed
    typed(window, "folder", str(tmp_path))
    started(window)
    assert load(tmp_path / "rse_0000" / "recipe.json").seed == window.session.recipe.seed == seed


def test_without_keep_every_start_draws_a_seed_that_is_shown_and_can_be_undone(window: Window, tmp_path: Path) -> None:
    seed = window.session.recipe.seed
    click(window, "keep_seed")
    typed(window, "folder", str(tmp_path))
    started(window)
    drawn = window.session.recipe.seed
    (line,) = window.forms.basic.findChildren(QLineEdit, "seed_field")
    assert drawn != seed
    assert line.text() == str(drawn)
    assert load(tmp_path / "rse_0000" / "recipe.json").seed == drawn
    window.session.undo()
    assert window.session.recipe.seed == seed


def test_no_seed_is_drawn_for_a_start_that_does_not_come_to_be(window: Window, tmp_path: Path) -> None:
    seed = window.session.recipe.seed
    click(window, "keep_seed")
    typed(window, "folder", "")
    click(window, "start")
    assert window.session.recipe.seed == seed


def test_the_seed_of_a_recipe_that_is_opened_is_kept(window: Window, tmp_path: Path) -> None:
    keep = window.forms.basic.findChild(QCheckBox, "keep_seed")
    assert keep is not None
    click(window, "keep_seed")
    window.session.save(tmp_path / "field.yaml")
    assert not keep.isChecked()
    window.document.open(Session.opened(tmp_path / "field.yaml"))
    assert keep.isChecked()
    assert window.findChildren(QPushButton, "reroll")[0].isEnabled()
