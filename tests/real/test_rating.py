"""Ratings by drives in a real Gazebo."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rsegen
from rsegen.rating.rating import Rating
from rsegen.simulators.base import Installation


@pytest.mark.long(reason="eight servers, one for each drive")
def test_a_robot_is_rated_by_drives_in_gazebo(gazebo: Installation, tmp_path: Path) -> None:
    by = gazebo.simulator.name
    rating = rsegen.rate("jackal", by=by, seed=16, trials=8, duration=6, motors="classic", output=tmp_path / "out")
    assert isinstance(rating, Rating)
    (curve,) = rating.curves
    assert curve.title == str(gazebo)
    for trial in curve.trials:
        assert trial.crossed is not None
        assert trial.x is not None
        assert trial.crossed == (trial.x > 0.5)
    assert 0 < curve.crossed < 8
    (row, *_) = json.loads((tmp_path / "out" / "rating.json").read_text())["curves"][0]["trials"]
    assert row["drive"].endswith(f"--robot jackal --duration 6 --simulator {by}")
