"""Maps of data sets, opened with real clicks and keys."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QAction, QDropEvent, QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QFileDialog, QLabel, QMessageBox, QSpinBox

from rsegen import Dataset, Random, Recipe, build, compose, make_dataset
from rsegen.gui.dialogs.gallery import PICTURE_SIDE as SIDE
from rsegen.gui.dialogs.gallery import DatasetDialog
from rsegen.gui.model.session import Session
from rsegen.gui.widgets.plan_painting import square_image
from rsegen.gui.window import Window
from tests.support.clicking import active, answer, find, shown, typed
from tests.support.waiting import exposed, until

LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier
OBSTACLE = Random(levels=5)
RECIPE = Recipe(seed=7, chunk_size=6, chunks=(2, 1), maps=40, first_map=1000, obstacles=[OBSTACLE])
Said = QMessageBox.StandardButton


@pytest.fixture
def window(app: QApplication) -> Iterator[Window]:
    window = Window(Session.new())
    with shown(window):
        yield window


@pytest.fixture
def rubble(tmp_path: Path) -> Path:
    make_dataset(RECIPE, tmp_path / "rubble")
    return tmp_path / "rubble"


def asked(window: Window) -> DatasetDialog:
    (dialog,) = window.findChildren(DatasetDialog)
    exposed(dialog)
    return dialog


def is_of(picture: QLabel, image: QImage) -> bool:
    return picture.pixmap().toImage().convertToFormat(image.format()) == image


def press_open(dialog: DatasetDialog) -> None:
    (buttons,) = dialog.findChildren(QDialogButtonBox)
    QTest.mouseClick(buttons.button(QDialogButtonBox.StandardButton.Open), LEFT)


def test_the_map_that_is_asked_for_is_that_of_the_data_set(
    window: Window, rubble: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", staticmethod(lambda *_: str(rubble)))
    QTest.keyClick(active(window), Qt.Key.Key_O, CONTROL | Qt.KeyboardModifier.ShiftModifier)
    dialog = asked(window)
    typed(dialog, "place", "17")
    press_open(dialog)
    assert not dialog.isVisible()
    assert window.session.recipe == RECIPE.alone(1017)
    assert np.array_equal(build(window.session.recipe, 1017).blocks, Dataset(rubble)[17])
    assert window.status.index.value() == 1017
    assert window.session.path is None
    assert not window.session.unsaved


def test_the_index_is_within_the_data_set_and_has_a_picture(window: Window, rubble: Path) -> None:
    window.files.open(rubble)
    dialog = asked(window)
    number = find(dialog, QSpinBox, "place")
    assert (number.minimum(), number.maximum(), number.value()) == (0, 39, 0)
    picture = find(dialog, QLabel, "picture")
    for place in (0, 3):
        number.setValue(place)
        wanted = square_image(compose(RECIPE, 1000 + place), SIDE)
        until(partial(is_of, picture, wanted))
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert window.session.recipe != RECIPE.alone(1003)


def test_a_map_of_the_second_recipe_is_shown_and_opened(window: Window, tmp_path: Path) -> None:
    other = replace(RECIPE, name="other", seed=8, first_map=0)
    make_dataset([RECIPE, other], tmp_path / "both")
    window.files.open(tmp_path / "both")
    dialog = asked(window)
    assert any("80 maps of 12 x 6 blocks\n2 recipes" in label.text() for label in dialog.findChildren(QLabel))
    typed(dialog, "place", "43")
    until(partial(is_of, find(dialog, QLabel, "picture"), square_image(compose(other, 3), SIDE)))
    press_open(dialog)
    assert window.session.recipe == other.alone(3)


def test_the_manifest_will_do_and_so_will_its_name_with_a_number(
    window: Window, rubble: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = str(rubble / "manifest.json")
    monkeypatch.setattr(QFileDialog, "getOpenFileName", staticmethod(lambda *_: (manifest, "")))
    QTest.keyClick(active(window), Qt.Key.Key_O, CONTROL)
    typed(asked(window), "place", "5")
    QTest.keyClick(asked(window), Qt.Key.Key_Return)
    assert window.session.recipe == RECIPE.alone(1005)
    window.files.open(Path(f"{rubble}#39"))
    assert window.session.recipe == RECIPE.alone(1039)


def test_a_map_is_among_the_recent_files_and_opens_from_there(window: Window, rubble: Path) -> None:
    window.files.open(Path(f"{rubble}#4"))
    window.document.open(Session.new())
    window.files.recent.fill()
    action = window.files.recent.actions()[0]
    assert action.text() == f"{rubble}#4"
    action.trigger()
    assert window.session.recipe == RECIPE.alone(1004)


@pytest.mark.parametrize("name", ["", "manifest.json"])
def test_a_data_set_is_dropped(window: Window, rubble: Path, name: str) -> None:
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(rubble / name))])
    copy, none = Qt.DropAction.CopyAction, Qt.KeyboardModifier.NoModifier
    window.dropEvent(QDropEvent(QPointF(window.rect().center()), copy, data, LEFT, none))
    typed(asked(window), "place", "2")
    press_open(asked(window))
    assert window.session.recipe == RECIPE.alone(1002)


def damaged(folder: Path) -> str:
    """Break a manifest, and say what is then said."""
    path = folder / "manifest.json"
    found = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps({**found, "maps": 41}), "utf-8")
    return f"{path}: maps: 41 does not match the recipes, which give 40"


def test_a_number_beyond_them_and_a_data_set_that_is_damaged_are_one_line_each(window: Window, rubble: Path) -> None:
    before = window.session
    beyond = answer(Said.Ok)
    window.files.open(Path(f"{rubble}#40"))
    assert beyond == [f"{rubble}#40: there is no map 40 in the data set; give 0..39"]
    expected, amiss = damaged(rubble), answer(Said.Ok)
    window.files.open(rubble)
    assert amiss == [expected]
    none = answer(Said.Ok)
    window.files.open(rubble.parent)
    assert none == [f"{rubble.parent}: has no manifest.json, so it is not a data set of rsegen"]
    assert window.session is before


def test_unsaved_changes_are_asked_for(window: Window, rubble: Path) -> None:
    window.session.add({"kind": "peak", "levels": 3})
    before = window.session
    window.files.open(rubble)
    question = answer(Said.Cancel)
    press_open(asked(window))
    assert question == ["Save the changes of untitled?"]
    assert window.session is before


@pytest.mark.parametrize("what", ["number", "manifest"])
def test_on_the_command_line_either_is_one_line_without_a_window(rubble: Path, what: str) -> None:
    target, expected = f"{rubble}#40", f"{rubble}#40: there is no map 40 in the data set; give 0..39"
    if what == "manifest":
        target, expected = str(rubble), damaged(rubble)
    run = subprocess.run([sys.executable, "-m", "rsegen", "gui", target], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (2, f"rsegen: {expected}\n")


def test_the_command_line_opens_a_map_and_asks_for_one(rubble: Path) -> None:
    """In a program of its own, whose window is looked at by a timer."""
    for target, seen in ((f"{rubble}#3", "1003"), (str(rubble), "dataset_dialog")):
        run = subprocess.run([sys.executable, "-c", LOOKED, target], capture_output=True, text=True, check=False)
        assert seen in run.stdout.split(), run.stderr


LOOKED = """
import sys
from pathlib import Path
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QDialog
from rsegen.gui import application

def look():
    for widget in QApplication.topLevelWidgets():
        if hasattr(widget, "session"):
            print(widget.session.recipe.first_map, *(each.objectName() for each in widget.findChildren(QDialog)))
    QApplication.instance().exit(0)

class Application(QApplication):
    def exec(self):
        QTimer.singleShot(0, look)
        return super().exec()

application.QApplication = Application
application.run(Path(sys.argv[1]))
"""


def test_it_is_in_the_menu(window: Window) -> None:
    names = [action.objectName() for action in window.findChildren(QAction)]
    assert "Open a map of a data set" in names
