"""Maps exported from the window with real clicks and keys, judged by the programs that read them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QCheckBox, QLabel, QMessageBox, QPushButton, QWidget

from rsegen import build, compose, generate, save
from rsegen.cli import main
from rsegen.errors import pip_install
from rsegen.exporters.formats import FORMATS
from rsegen.exporters.formats.arrays import Arrays
from rsegen.gui.dialogs.outputs import ExportDialog
from rsegen.gui.model.session import Session
from rsegen.gui.widgets.layouts import tooltip
from rsegen.gui.window import Window
from rsegen.io.input_files import JOURNAL
from rsegen.params import extras
from rsegen.params.registry import summary
from tests.support.clicking import active, answer, click, find, said, shown, typed
from tests.support.waiting import exposed, until

Said = QMessageBox.StandardButton
CONTROL_SHIFT = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    window.session.add({"kind": "random", "levels": 3})
    with shown(window):
        yield window


def opened(window: Window, folder: Path) -> ExportDialog:
    QTest.keyClick(active(window), Qt.Key.Key_E, CONTROL_SHIFT)
    (dialog,) = window.findChildren(ExportDialog)
    exposed(dialog)
    typed(dialog, "folder", str(folder))
    return dialog


def exported(dialog: ExportDialog, *formats: str) -> None:
    for name in formats:
        click(dialog, f"format_{name}")
    click(dialog, "start")
    until(lambda: not dialog.form.busy and dialog.form.start.isVisible())


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_trimesh_reads_the_export_and_the_command_writes_the_same(window: Window, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh", reason="needs pip install 'rsegen[mesh]'")
    pytest.importorskip("scipy", reason="needs pip install 'rsegen[mat]'")
    dialog = opened(window, tmp_path / "mine")
    exported(dialog, "stl", "arrays")
    assert said(dialog, "outcome") == f"1 map as arrays, stl in {tmp_path / 'mine'}"
    field = build(window.session.recipe)
    mesh = trimesh.load(tmp_path / "mine" / "rse_0000" / "stl" / "rse_0000.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(field.heights.sum() * field.block_width**2, rel=1e-5)
    assert np.array_equal(np.load(tmp_path / "mine" / "rse_0000" / "arrays" / "levels.npy"), field.levels)
    save(window.session.recipe, tmp_path / "field.yaml")
    assert main(["export", str(tmp_path / "field.yaml"), "--to", "arrays,stl", "-o", str(tmp_path / "command")]) == 0
    assert files(tmp_path / "mine") == files(tmp_path / "command")


def test_options_of_a_ticked_format_are_shown_and_used(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path)
    options = find(dialog, QWidget, "options_heightmap")
    assert not options.isVisible()
    click(dialog, "format_heightmap")
    assert options.isVisible()
    typed(options, "pixels_field", "3")
    exported(dialog)
    home = tmp_path / "rse_0000"
    with Image.open(home / "heightmap" / "rse_0000.png") as image:
        assert image.size == tuple(3 * cells for cells in build(window.session.recipe).shape)
    assert json.loads((home / "formats.json").read_text("utf-8")) == {"heightmap": {"pixels": 3}}


def test_every_format_is_listed_in_the_words_of_the_command(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path)
    assert [(box.text(), box.toolTip()) for box in dialog.findChildren(QCheckBox) if box.text() in FORMATS] == [
        (name, tooltip(summary(cls))) for name, cls in FORMATS.items()
    ]
    assert not dialog.form.start.isEnabled()
    click(dialog, "format_urdf")
    assert dialog.form.start.isEnabled()


def test_all_maps_are_exported_or_the_one_that_is_shown(window: Window, tmp_path: Path) -> None:
    window.session.set("maps", 3)
    window.status.index.setValue(1)
    dialog = opened(window, tmp_path / "one")
    click(dialog, "alone")
    exported(dialog, "heightmap")
    assert os.listdir(tmp_path / "one") == ["rse_0001"]
    click(dialog, "alone")
    typed(dialog, "folder", str(tmp_path / "all"))
    exported(dialog)
    assert sorted(os.listdir(tmp_path / "all")) == ["rse_0000", "rse_0001", "rse_0002"]


def test_a_format_whose_library_is_missing_is_grey_with_install_instructions(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == "pxr" else find_spec(name))
    dialog = opened(window, tmp_path)
    box = find(dialog, QCheckBox, "format_usd")
    assert not box.isEnabled()
    assert said(dialog, "missing_usd") == f"usd needs pxr, which is not installed; {pip_install(['usd'])}"
    click(dialog, "format_usd")
    assert not box.isChecked()
    assert not dialog.findChildren(QLabel, "missing_mjcf")


def test_formats_that_exist_are_replaced_only_after_a_question(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path)
    exported(dialog, "urdf")
    before = os.stat(tmp_path / "rse_0000" / "urdf").st_ino
    asked = answer(Said.No)
    click(dialog, "start")
    assert asked == [f"{tmp_path} already contains maps named rse. Write or replace their urdf?"]
    assert os.stat(tmp_path / "rse_0000" / "urdf").st_ino == before
    answer(Said.Yes)
    exported(dialog)
    assert os.stat(tmp_path / "rse_0000" / "urdf").st_ino != before


def test_a_world_gets_a_format_and_stays_as_it_is(window: Window, tmp_path: Path) -> None:
    generate(window.session.recipe, tmp_path)
    before = files(tmp_path)
    dialog = opened(window, tmp_path)
    answer(Said.Yes)
    exported(dialog, "urdf")
    after = files(tmp_path)
    assert {name for name in before if before[name] != after[name]} == {f"rse_0000/{JOURNAL}"}
    assert (tmp_path / "rse_0000" / "urdf").is_dir()


def test_the_world_of_another_map_is_never_replaced(window: Window, tmp_path: Path) -> None:
    generate(replace(window.session.recipe, seed=99), tmp_path)
    before = files(tmp_path)
    dialog = opened(window, tmp_path)
    answer(Said.Yes)
    exported(dialog, "urdf")
    assert said(dialog, "folder_error").startswith(f"{tmp_path / 'rse_0000'}: has the world of another map in it")
    assert files(tmp_path) == before


def test_an_option_that_cannot_be_is_one_line_and_nothing_is_written(window: Window, tmp_path: Path) -> None:
    dialog = opened(window, tmp_path / "mine")
    click(dialog, "format_occupancy")
    typed(find(dialog, QWidget, "options_occupancy"), "climb_cm_field", "high")
    click(dialog, "start")
    assert said(dialog, "folder_error").startswith("occupancy.climb_cm: 'high' is not a number")
    assert not (tmp_path / "mine").exists()


def test_a_file_in_the_folders_place_is_one_line(window: Window, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    dialog = opened(window, tmp_path / "taken")
    click(dialog, "format_urdf")
    click(dialog, "start")
    assert said(dialog, "folder_error") == f"{tmp_path / 'taken'}: is a file; give a folder"


def test_an_error_of_a_library_is_one_line_and_leaves_nothing(
    window: Window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: Arrays, scene: object) -> NoReturn:
        raise RuntimeError("out of ink")

    monkeypatch.setattr(Arrays, "files", broken)
    monkeypatch.setattr(Arrays, "extra", None)
    dialog = opened(window, tmp_path / "mine")
    exported(dialog, "arrays")
    assert said(dialog, "folder_error") == "internal error, please report it: RuntimeError('out of ink')"
    assert not (tmp_path / "mine").exists()


def begun(window: Window, folder: Path) -> ExportDialog:
    """The export of so many maps that it is not over soon."""
    window.session.set("maps", 2000)
    dialog = opened(window, folder)
    click(dialog, "format_heightmap")
    click(dialog, "start")
    until(lambda: dialog.form.bar.value() > 0)
    return dialog


def whole(folder: Path) -> int:
    """How many maps are there, each of them whole, and nothing else."""
    for home in folder.iterdir():
        wanted = {"recipe.json", "formats.json", JOURNAL, f"heightmap/{home.name}.png", "heightmap/heightmap.json"}
        assert set(files(home)) == wanted
    return len(list(folder.iterdir()))


def test_it_is_cancelled_between_two_maps(window: Window, tmp_path: Path) -> None:
    dialog = begun(window, tmp_path)
    assert not find(dialog, QCheckBox, "format_heightmap").isEnabled()
    click(dialog, "cancel")
    until(dialog.form.start.isVisible)
    assert 0 < whole(tmp_path) < 2000
    assert said(dialog, "outcome") == f"Cancelled: {whole(tmp_path)} of 2000 maps are in {tmp_path}"


@pytest.mark.parametrize("close", ["the dialog", "the window"])
def test_closing_while_it_writes_leaves_whole_maps(window: Window, tmp_path: Path, close: str) -> None:
    dialog = begun(window, tmp_path)
    if close == "the dialog":
        QTest.keyClick(dialog, Qt.Key.Key_Escape)
    else:
        window.session.save(tmp_path.parent / f"{tmp_path.name}.yaml")
        window.close()
    assert 0 < whole(tmp_path) < 2000
    made = whole(tmp_path)
    QTest.qWait(200)
    assert whole(tmp_path) == made
    assert not window.findChildren(ExportDialog) or close == "the window"


def test_while_maps_are_written_or_wrong_nothing_is_exported(window: Window, tmp_path: Path) -> None:
    (action,) = (each for each in window.findChildren(QAction) if each.objectName() == "Export for other programs")
    button = find(window, QPushButton, "export")
    assert action.isEnabled()
    assert button.isEnabled()
    window.session.set("chunk_size", -1)
    assert not action.isEnabled()
    assert not button.isEnabled()
    window.session.undo()
    window.session.set("maps", 2000)
    window.outputs.start_into(tmp_path)
    assert not action.isEnabled()
    assert not button.isVisible()
    window.forms.start_form.stop()
    until(button.isVisible)
    assert action.isEnabled()


def test_the_button_opens_it_and_the_folder_is_remembered(window: Window, tmp_path: Path) -> None:
    exported(opened(window, tmp_path / "mine"), "urdf")
    (dialog,) = window.findChildren(ExportDialog)
    dialog.close()
    until(lambda: not window.findChildren(ExportDialog))
    click(window, "export")
    (dialog,) = window.findChildren(ExportDialog)
    assert dialog.form.folder == tmp_path / "mine"
    assert window.forms.start_form.folder != tmp_path / "mine"
    assert compose(window.session.recipe).name == "rse_0000"
