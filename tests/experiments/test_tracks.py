"""The tracks of an experiment: a file per trial, and a picture per cell."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import rsegen
from rsegen.driving.drive_metrics import Trajectory
from rsegen.errors import Incomplete, NoSpot
from rsegen.experiments import run
from rsegen.experiments.plan import Cell, ExperimentPlan, TableRow
from rsegen.experiments.run import results_of, track_files, track_names
from rsegen.experiments.trial import Outcome, Trial
from rsegen.scene.scene import compose

PLAN = ExperimentPlan(name="p", rows=(TableRow(sizes=(10,)),), paces=("free",), repeats=2)
CELL = Cell(row=0, size=10, pace="free")


@pytest.fixture
def trial() -> Trial:
    outcome = Outcome(load=1, memory=1, cpu=None, speed=1, rtf_min=None, rtf=None, rtf_max=None)
    rows = np.array([[0, 0.1, 0, 0, 0, 0, 0], [1, 0.3, 0, 0, 0, 0, 0]])
    tracks = {name: Trajectory(rows=rows) for name in ("burger_0", "burger_1")}
    return Trial(outcome=outcome, scene=compose(PLAN.rows[0].map_of(10, 1)), trajectories=tracks)


def test_every_trial_has_a_csv_file_and_every_cell_a_picture_of_the_last(trial: Trial) -> None:
    first, last = (track_files(PLAN, CELL, repeat, trial) for repeat in (0, 1))
    assert list(first) == ["tracks/row1-10-free-0.csv"]
    assert list(last) == ["tracks/row1-10-free-1.csv", "tracks/row1-10-free.png"]
    assert {*first, *last} == {*track_names(PLAN)}
    assert b"".join(first["tracks/row1-10-free-0.csv"]).decode().splitlines() == [
        "robot,t,x,y,z,roll,pitch,yaw",
        "burger_0,0,0.1,0,0,0,0,0",
        "burger_0,1,0.3,0,0,0,0,0",
        "burger_1,0,0.1,0,0,0,0,0",
        "burger_1,1,0.3,0,0,0,0,0",
    ]
    with Image.open(BytesIO(b"".join(last["tracks/row1-10-free.png"]))) as picture:
        assert picture.width == 1050  # a column of a paper, 300 pixels per inch


def test_without_robots_no_tracks_are_written(trial: Trial) -> None:
    assert track_files(PLAN, CELL, 1, replace(trial, trajectories={})) == {}


@pytest.mark.parametrize(("before", "error"), [(0, NoSpot), (1, Incomplete)])
def test_a_map_without_room_leaves_complete_trials_and_says_so(
    before: int, error: type[Exception], trial: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error of a user (exit code 2) means that nothing was changed."""
    calls = count()

    def run_trial(*_: object) -> Trial:
        if next(calls) < before:
            return trial
        raise NoSpot("row 1, 20, free: robots", "found spots for 1 of 2")

    monkeypatch.setattr(run, "run_trial", run_trial)
    with pytest.raises(error, match="found spots for 1 of 2") as raised:
        rsegen.experiment(PLAN, tmp_path / "costs", simulator="mujoco")
    assert ("1 of 2 trials are complete" in str(raised.value)) is (before > 0)
    with pytest.raises(NoSpot):  # nothing is changed by the next call
        rsegen.experiment(PLAN, tmp_path / "costs", simulator="mujoco")


def test_progress_is_that_of_the_trials_that_are_made(
    trial: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those that are kept of an earlier call were shown again, as if they ran anew."""
    calls, told = count(), list[int]()

    def run_trial(*_: object) -> Trial:
        if next(calls) == 1:
            raise KeyboardInterrupt
        return trial

    monkeypatch.setattr(run, "run_trial", run_trial)
    with pytest.raises(KeyboardInterrupt):
        rsegen.experiment(PLAN, tmp_path / "costs", simulator="mujoco", progress=lambda done, _: told.append(done))
    assert told == [0, 1]
    for _ in range(2):  # the second time nothing is left to do
        rsegen.experiment(PLAN, tmp_path / "costs", simulator="mujoco", progress=lambda done, _: told.append(done))
        assert told == [0, 1, 1]


def test_outcomes_are_in_the_order_of_their_repeats(trial: Trial) -> None:
    """A line of the journal that was deleted is made again behind the others."""
    first, second = trial.outcome, replace(trial.outcome, speed=2)
    assert results_of({(CELL, 1): second, (CELL, 0): first}) == {CELL: [first, second]}
