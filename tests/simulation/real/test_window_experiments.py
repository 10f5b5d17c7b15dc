"""An experiment from the window: the trials that the command line runs, in a real Gazebo."""

from __future__ import annotations

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
from PySide6.QtWidgets import QApplication, QComboBox

from rsegen.gui.dialogs.job import ExperimentDialog
from rsegen.simulation.experiment.run import REPORT_FILES, load_summary
from rsegen.simulation.simulators import Installation
from tests.support.clicking import click, find, said
from tests.support.waiting import until

pytestmark = pytest.mark.long(reason="a window and servers")

PLAN = """
name: tiny
seconds: {seconds}
repeats: 1
paces: [free]
rows:
  - {{robot: burger, robots: 1, sizes: [0, 10], unit_cm: 0.3, levels: 3}}
"""


@contextmanager
def opened(tmp_path: Path, seconds: int) -> Iterator[ExperimentDialog]:
    QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    app = QApplication.instance() or QApplication([])
    (tmp_path / "plan.yaml").write_text(PLAN.format(seconds=seconds), "utf-8")
    dialog = ExperimentDialog()
    dialog.form.folder = tmp_path / "mine"
    dialog.plan.show_file(str(tmp_path / "plan.yaml"))
    dialog.show()
    assert app
    yield dialog
    dialog.close()


def test_its_table_and_plot_are_shown(gazebo: Installation, tmp_path: Path) -> None:
    with opened(tmp_path, seconds=2) as dialog:
        find(dialog, QComboBox, "simulator_field").setCurrentText(gazebo.simulator.name)
        click(dialog, "start")
        until(lambda: dialog.form.written is not None and not dialog.form.busy)
        assert said(dialog, "folder_error") == ""
        folder = tmp_path / "mine" / f"tiny-{gazebo.simulator.name}"
        assert {*REPORT_FILES} <= {path.name for path in folder.iterdir()}
        plan, results, _, command = load_summary(folder / "summary.json")
        assert [len(results[cell]) for cell in plan.cells] == [1, 1]
        assert command.startswith("rsegen experiment ")
        assert gazebo.simulator.title in dialog.report.table.toPlainText()
        assert not dialog.report.plot.pixmap().isNull()


def test_cancel_ends_a_trial_and_its_server(gazebo: Installation, tmp_path: Path) -> None:
    with opened(tmp_path, seconds=3000) as dialog:
        click(dialog, "start")
        until((tmp_path / "mine" / "tiny" / ".rsegen.jsonl").exists)
        click(dialog, "cancel")
        until(lambda: said(dialog, "outcome").startswith("Cancelled: 0 of 2 trials are in "))
        assert not dialog.form.busy
        assert not dialog.report.isVisible()
