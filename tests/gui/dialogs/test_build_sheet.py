"""Build sheets from the window with real clicks and keys: read again by `rsegen import`."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from rsegen import CutSettings, build, compose, load, sheet
from rsegen.cli import main
from rsegen.gui.dialogs.outputs import SheetDialog
from rsegen.gui.model.as_code import command_line, python_code
from rsegen.gui.model.session import Session
from rsegen.gui.window import Window
from rsegen.run.store import write_file
from tests.support.clicking import active, answer, click, said, shown, typed
from tests.support.waiting import exposed, until

Said = QMessageBox.StandardButton


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.session.set("chunk_size", 4)
    window.session.set("maps", 3)
    window.session.add({"kind": "random", "levels": 3})
    with shown(window):
        yield window


def opened(window: Window, folder: Path) -> SheetDialog:
    QTest.keyClick(active(window), Qt.Key.Key_B, Qt.KeyboardModifier.ControlModifier)
    (dialog,) = window.findChildren(SheetDialog)
    exposed(dialog)
    typed(dialog, "folder", str(folder))
    return dialog


def written(dialog: SheetDialog) -> None:
    click(dialog, "start")
    until(lambda: not dialog.form.busy and dialog.form.start.isVisible())


def test_the_sheet_of_the_map_that_is_shown_is_imported_again(window: Window, tmp_path: Path) -> None:
    window.status.index.setValue(2)
    dialog = opened(window, tmp_path / "mine")
    written(dialog)
    assert sorted(os.listdir(tmp_path / "mine")) == [".rsegen.jsonl", "rse_0002.csv", "rse_0002.pdf"]
    assert said(dialog, "outcome") == f"rse_0002.pdf and rse_0002.csv in {tmp_path / 'mine'}"
    assert main(["import", str(tmp_path / "mine" / "rse_0002.csv"), "-o", str(tmp_path / "again")]) == 0
    (again,) = (tmp_path / "again").iterdir()
    assert build(load(again / "recipe.json")) == build(window.session.recipe, 2)


def test_saw_and_timber_come_from_the_form(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path)
    typed(dialog, "kerf_mm_field", "2.5")
    typed(dialog, "stock_cm_field", "300")
    written(dialog)
    scene, saw = compose(window.session.recipe), CutSettings(kerf_mm=2.5, stock_cm=300)
    for format_ in ("pdf", "csv"):
        assert (tmp_path / f"rse_0000.{format_}").read_bytes() == sheet(scene, saw, format_)


def test_saw_and_timber_of_a_recipe_in_inches_equal_the_command(window: Window, tmp_path: Path) -> None:
    window.session.set("units", "in")
    dialog = opened(window, tmp_path)
    written(dialog)
    scene = compose(window.session.recipe)
    for format_ in ("pdf", "csv"):
        assert (tmp_path / f"rse_0000.{format_}").read_bytes() == sheet(scene, None, format_)


def test_stock_that_is_too_short_is_one_line_and_nothing_is_written(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path)
    typed(dialog, "stock_cm_field", "5")
    click(dialog, "start")
    said_of_it = "stock_cm: 5 is shorter than blocks of the highest level, 20 cm; give 22 or more"
    assert said(dialog, "folder_error") == said_of_it
    assert not os.listdir(tmp_path)


def test_an_existing_sheet_is_replaced_only_after_confirmation(window: Window, tmp_path: Path) -> None:
    write_file([b"of another map"], tmp_path / "rse_0000.csv")
    dialog = opened(window, tmp_path)
    asked = answer(Said.No)
    click(dialog, "start")
    assert asked == [f"{tmp_path} already contains a build sheet of rse_0000. Replace it?"]
    assert (tmp_path / "rse_0000.csv").read_text() == "of another map"
    answer(Said.Yes)
    written(dialog)
    assert (tmp_path / "rse_0000.csv").read_bytes() == sheet(compose(window.session.recipe), None, "csv")


@pytest.mark.parametrize("how", ["cancel", "close"])
def test_between_two_pages_it_can_be_stopped_and_nothing_is_written(window: Window, tmp_path: Path, how: str) -> None:
    window.session.set("chunks", [10, 10])
    dialog = opened(window, tmp_path)
    click(dialog, "start")
    until(lambda: dialog.form.bar.value() > 0)
    assert dialog.form.bar.maximum() == 103
    if how == "cancel":
        click(dialog, "cancel")
        until(dialog.form.start.isVisible)
        assert said(dialog, "outcome").startswith("Cancelled: nothing was written after ")
    else:
        QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert not os.listdir(tmp_path)


def test_start_adds_sheets_to_every_map_and_is_spelled_so(window: Window, tmp_path: Path) -> None:
    click(window, "sheets")
    window.outputs.start_into(tmp_path / "mine")
    until(window.forms.start.isVisible)
    recipe = window.session.recipe
    for index in range(3):
        for format_ in ("pdf", "csv"):
            made = (tmp_path / "mine" / f"rse_000{index}" / f"sheet.{format_}").read_bytes()
            assert made == sheet(compose(recipe, index), None, format_)
    (tmp_path / "mine").rename(tmp_path / "kept")
    job = window.forms.start_form.job(recipe)
    assert main(shlex.split(command_line(recipe, str(job.folder), sheets=job.sheets))[1:]) == 0
    assert "sheet=True" in python_code(recipe, "worlds", sheets=job.sheets)
    for path in (tmp_path / "kept").rglob("*.*"):
        assert (tmp_path / "mine" / path.relative_to(tmp_path / "kept")).read_bytes() == path.read_bytes()


def test_a_map_too_large_for_a_sheet_is_one_line_and_no_seed_is_drawn_for_it(window: Window, tmp_path: Path) -> None:
    window.session.set("chunk_size", 61)
    seed = window.session.recipe.seed
    click(window, "sheets")
    click(window, "keep_seed")
    window.outputs.start_into(tmp_path)
    assert said(window, "folder_error").startswith("chunk_size: 61 blocks per side do not fit on a page")
    assert window.session.recipe.seed == seed
    assert not os.listdir(tmp_path)
    click(window, "sheets")
    assert said(window, "folder_error") == ""
