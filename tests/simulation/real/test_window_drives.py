"""A drive from the window: what the command line drives, in a real Gazebo, with a picture of the trajectories."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")
if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QApplication, QCheckBox, QDoubleSpinBox, QLabel

from rsegen.gui.dialogs.job import DriveDialog
from rsegen.recipe.recipe import Recipe
from rsegen.simulation.simulators import Installation
from tests.simulation.simulators.standins import alone_on_path
from tests.support.clicking import click, find, said
from tests.support.waiting import until

pytestmark = pytest.mark.long(reason="a window and a server")


@contextmanager
def opened(tmp_path: Path) -> Iterator[DriveDialog]:
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    app = QApplication.instance() or QApplication([])
    dialog = DriveDialog(Recipe(seed=1, chunks=(2, 2), boundary="none", maps=3), 2)
    dialog.form.folder = tmp_path / "drives"
    dialog.show()
    assert app
    yield dialog
    dialog.close()


def test_robots_drive_over_the_map_that_is_shown(gazebo: Installation, tmp_path: Path) -> None:
    with opened(tmp_path) as dialog:
        find(dialog, QDoubleSpinBox, "duration_field").setValue(4)
        click(dialog, "contacts_field")
        assert not find(dialog, QCheckBox, "contacts_field").isChecked()
        click(dialog, "start")
        until(lambda: dialog.form.written is not None and not dialog.form.busy)
        result = json.loads((tmp_path / "drives" / "rse_0002-burger" / "drive.json").read_text("utf-8"))
        (robot,) = result["robots"]
        words = said(dialog, "outcome")
        assert f"{robot['name']}: {robot['distance']:.2f} m in 4 s" in words
        assert robot["distance"] > 0.3
        assert not find(dialog, QLabel, "trajectories").pixmap().isNull()


def test_a_drive_that_is_cancelled_leaves_nothing(gazebo: Installation, tmp_path: Path) -> None:
    with opened(tmp_path) as dialog:
        find(dialog, QDoubleSpinBox, "duration_field").setValue(3000)
        click(dialog, "start")
        until(lambda: dialog.form.bar.value() >= 1)
        click(dialog, "cancel")
        until(lambda: said(dialog, "outcome").startswith("Cancelled after "))
        assert not (tmp_path / "drives").exists()


def test_a_missing_simulator_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    alone_on_path(tmp_path, monkeypatch)
    with opened(tmp_path) as dialog:
        click(dialog, "start")
        until(lambda: "Gazebo" in said(dialog, "folder_error"))
        assert dialog.form.written is None
