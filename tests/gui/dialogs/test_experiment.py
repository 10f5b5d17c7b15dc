"""Experiments from the window with real clicks; the trials are measured by a stand-in."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("PySide6", reason="the window needs pip install 'rsegen[gui]'")

from PySide6.QtCore import QBuffer
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QMessageBox

from rsegen import compose
from rsegen.gui.dialogs.job import ExperimentDialog
from rsegen.gui.model.session import Session
from rsegen.gui.model.simulation import experiment_plans
from rsegen.gui.window import Window
from rsegen.io.input_files import JOURNAL
from rsegen.simulation.experiment import run
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan
from rsegen.simulation.experiment.trial import Outcome, Trial
from rsegen.simulation.simulators import Installation
from tests.simulation.simulators.standins import PROGRAMS, alone_on_path, put
from tests.support.clicking import answer, click, find, said, shown
from tests.support.waiting import exposed, until

PLAN = """
name: small
seconds: 1
repeats: 2
paces: [free]
rows:
  - {robot: burger, robots: 1, sizes: [0, 10], unit_cm: 0.3, levels: 3}
"""
TRIALS = 4


class Trials:
    """Stands in for trials in a simulator, and keeps which were measured; from number `last` on they do not end."""

    def __init__(self) -> None:
        self.measured: list[tuple[Cell, int]] = []
        self.last = TRIALS
        self.lasting = threading.Event()

    def run(
        self, plan: ExperimentPlan, cell: Cell, repeat: int, here: Installation, watch: Callable[[], None]
    ) -> Trial:
        while len(self.measured) >= self.last:
            self.lasting.set()
            watch()
        self.measured.append((cell, repeat))
        outcome = Outcome(load=1.0, memory=150.0, cpu=None, speed=12.5, rtf_min=None, rtf=None, rtf_max=None)
        return Trial(outcome=outcome, scene=compose(plan.rows[cell.row].map_of(10, repeat)), trajectories={})


@pytest.fixture
def trials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Trials:
    put(alone_on_path(tmp_path, monkeypatch), PROGRAMS["classic"])
    found = Trials()
    monkeypatch.setattr(run, "run_trial", found.run)
    monkeypatch.setattr(run, "plot", lambda *_: picture())
    return found


def picture() -> bytes:
    """Stands in for the plot, which takes seconds."""
    image, buffer = QImage(30, 10, QImage.Format.Format_RGB888), QBuffer()
    buffer.open(QBuffer.OpenModeFlag.WriteOnly)
    image.save(buffer, "PNG")  # type: ignore[call-overload]  # its stub says bytes
    return bytes(buffer.data().data())


@pytest.fixture
def dialog(app: QApplication, tmp_path: Path) -> Iterator[ExperimentDialog]:
    (tmp_path / "plan.yaml").write_text(PLAN, "utf-8")
    window = Window(Session.new())
    with shown(window):
        window.outputs.experiment()
        (dialog,) = window.findChildren(ExperimentDialog)
        exposed(dialog)
        dialog.form.folder = tmp_path / "mine"
        dialog.plan.show_file(str(tmp_path / "plan.yaml"))
        yield dialog
        dialog.close()


def ended(dialog: ExperimentDialog) -> None:
    until(lambda: not dialog.form.busy and dialog.form.start.isVisible())


def test_table_and_plot_equal_the_command(trials: Trials, dialog: ExperimentDialog, tmp_path: Path) -> None:
    assert said(dialog, "trials") == "4 trials of 1 s each: 4 s, and the time to load their worlds"
    click(dialog, "start")
    ended(dialog)
    folder = tmp_path / "mine" / "small"
    assert said(dialog, "outcome") == f"4 trials in {folder}"
    assert dialog.form.written == folder
    assert sorted(os.listdir(folder)) == sorted([*run.REPORT_FILES, JOURNAL])
    assert dialog.report.isVisible()
    assert "Experiment: small" in dialog.report.table.toPlainText()
    assert "12.5" in dialog.report.table.toPlainText()
    dialog.report.setCurrentWidget(dialog.report.plot)
    assert not dialog.report.plot.pixmap().isNull()


def test_a_cancelled_experiment_is_continued(trials: Trials, dialog: ExperimentDialog, tmp_path: Path) -> None:
    trials.last = 2
    click(dialog, "start")
    until(trials.lasting.is_set)
    until(lambda: dialog.form.bar.value() == 2)
    click(dialog, "cancel")
    ended(dialog)
    folder = tmp_path / "mine" / "small"
    words = f"Cancelled: 2 of 4 trials are in {folder}; run the same plan into the same folder to continue"
    assert said(dialog, "outcome") == words
    assert not dialog.report.isVisible()
    trials.last = TRIALS
    click(dialog, "start")
    ended(dialog)
    assert said(dialog, "outcome") == f"4 trials in {folder}"
    assert len(trials.measured) == len(set(trials.measured)) == TRIALS
    assert (folder / JOURNAL).read_text("utf-8").count('{"result": ') == TRIALS


def test_closing_cancels_a_trial_that_lasts(trials: Trials, dialog: ExperimentDialog) -> None:
    trials.last = 0
    click(dialog, "start")
    until(trials.lasting.is_set)
    thread = dialog.form.run
    dialog.close()
    assert thread is not None
    assert thread.isFinished()


def test_results_are_deleted_only_after_a_question(trials: Trials, dialog: ExperimentDialog, tmp_path: Path) -> None:
    click(dialog, "start")
    ended(dialog)
    click(dialog, "start_again_field")
    asked = answer(QMessageBox.StandardButton.No)
    click(dialog, "start")
    assert asked == [
        f"{tmp_path / 'mine' / 'small'} already exists. Replace the results in it once the new ones are complete?"
    ]
    assert len(trials.measured) == TRIALS
    trials.last = 2 * TRIALS
    answer(QMessageBox.StandardButton.Yes)
    click(dialog, "start")
    ended(dialog)
    assert len(trials.measured) == 2 * TRIALS
    click(dialog, "start")
    ended(dialog)
    assert len(trials.measured) == 2 * TRIALS


def test_results_of_another_plan_stay(trials: Trials, dialog: ExperimentDialog, tmp_path: Path) -> None:
    click(dialog, "start")
    ended(dialog)
    (tmp_path / "plan.yaml").write_text(PLAN.replace("seconds: 1", "seconds: 2"), "utf-8")
    click(dialog, "start")
    ended(dialog)
    folder = tmp_path / "mine" / "small"
    words = f"{folder}: has the outcomes of another plan; give another folder, or tick Start again"
    assert said(dialog, "folder_error") == words
    assert json.loads((folder / JOURNAL).read_text("utf-8").splitlines()[0])["of"]["seconds"] == 1


def test_both_simulators_have_twice_the_trials_and_a_folder_of_their_own(
    trials: Trials, dialog: ExperimentDialog
) -> None:
    find(dialog, QComboBox, "simulator_field").setCurrentText("both")
    assert said(dialog, "trials").startswith("8 trials of 1 s each")
    assert dialog.job().result_folder.name == "small-both"
    click(dialog, "start")
    until(lambda: said(dialog, "folder_error") != "")
    assert "Gazebo Sim" in said(dialog, "folder_error")
    assert "\n" not in said(dialog, "folder_error")


def test_a_plan_that_is_wrong_is_one_line(dialog: ExperimentDialog, tmp_path: Path) -> None:
    for content, words in (("rows: 3", "not a plan of an experiment"), (PLAN + "pace: x", "pace")):
        path = tmp_path / "plan.yaml"
        path.write_text(content, "utf-8")
        click(dialog, "start")
        assert words in said(dialog, "folder_error")
        assert "\n" not in said(dialog, "folder_error")
        assert not dialog.form.busy


def test_a_missing_simulator_is_reported(
    dialog: ExperimentDialog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    alone_on_path(tmp_path, monkeypatch)
    click(dialog, "start")
    until(lambda: "Gazebo" in said(dialog, "folder_error"))
    assert dialog.form.written is None


def test_every_included_plan_has_a_description(dialog: ExperimentDialog) -> None:
    box = find(dialog, QComboBox, "plan")
    for name, text in experiment_plans().items():
        box.setCurrentText(name)
        QTest.qWait(1)
        assert said(dialog, "about_plan") == text
        assert text.endswith(".")
        assert " trials of " in said(dialog, "trials")
