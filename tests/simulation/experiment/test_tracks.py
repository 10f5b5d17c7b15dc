"""The folder of tracks: a file per trial, a picture per cell, and nothing of anybody else's is lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rsegen.errors import OutputError
from rsegen.exporters.scene import compose
from rsegen.simulation.driving.drive_metrics import Trajectory
from rsegen.simulation.experiment.plan import Cell, ExperimentPlan, TableRow
from rsegen.simulation.experiment.tracks import refuse_loss_of_tracks, remove_tracks, write_tracks
from rsegen.simulation.experiment.trial import Outcome, Trial

PLAN = ExperimentPlan(name="p", rows=(TableRow(sizes=(10,)),), paces=("free",), repeats=2)
CELL = Cell(row=0, size=10, pace="free")


@pytest.fixture
def trial() -> Trial:
    outcome = Outcome(load=1, memory=1, cpu=None, speed=1, rtf_min=None, rtf=None, rtf_max=None)
    rows = np.array([[0, 0.1, 0, 0, 0, 0, 0], [1, 0.3, 0, 0, 0, 0, 0]])
    tracks = {name: Trajectory(rows=rows) for name in ("burger_0", "burger_1")}
    return Trial(outcome=outcome, scene=compose(PLAN.rows[0].map_of(10, 1)), trajectories=tracks)


def test_every_trial_has_a_csv_file_and_every_cell_a_picture_of_the_last(trial: Trial, tmp_path: Path) -> None:
    write_tracks(PLAN, tmp_path, CELL, 0, trial)
    assert not list(tmp_path.rglob("*.png"))
    write_tracks(PLAN, tmp_path, CELL, 1, trial)
    names = {path.name for path in (tmp_path / "tracks").iterdir()}
    assert names == {"row1-10-free-0.csv", "row1-10-free-1.csv", "row1-10-free.png", ".rsegen.jsonl"}
    assert (tmp_path / "tracks" / "row1-10-free-0.csv").read_text().splitlines() == [
        "robot,t,x,y,z,roll,pitch,yaw",
        "burger_0,0,0.1,0,0,0,0,0",
        "burger_0,1,0.3,0,0,0,0,0",
        "burger_1,0,0.1,0,0,0,0,0",
        "burger_1,1,0.3,0,0,0,0,0",
    ]
    with Image.open(tmp_path / "tracks" / "row1-10-free.png") as picture:
        assert picture.size == (800, 800)
    refuse_loss_of_tracks(PLAN, tmp_path)
    remove_tracks(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_file_of_somebody_else_is_neither_replaced_nor_removed(trial: Trial, tmp_path: Path) -> None:
    write_tracks(PLAN, tmp_path, CELL, 0, trial)
    (tmp_path / "tracks" / "notes.txt").write_text("mine")
    remove_tracks(tmp_path)
    assert [path.name for path in (tmp_path / "tracks").iterdir()] == ["notes.txt"]
    (tmp_path / "tracks" / "row1-10-free-1.csv").write_text("mine")
    with pytest.raises(OutputError, match=r"row1-10-free-1\.csv: was not written by rsegen"):
        refuse_loss_of_tracks(PLAN, tmp_path)


def test_a_track_that_was_changed_is_not_removed(trial: Trial, tmp_path: Path) -> None:
    write_tracks(PLAN, tmp_path, CELL, 0, trial)
    (tmp_path / "tracks" / "row1-10-free-0.csv").write_text("mine")
    with pytest.raises(OutputError, match="changed since"):
        remove_tracks(tmp_path)
    assert (tmp_path / "tracks" / "row1-10-free-0.csv").read_text() == "mine"
