"""Robots rest level a second after their start, wherever a seed puts them, and stay upright when they are driven."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.starts import starts
from rsegen.driving.recording import record_drive
from rsegen.driving.robot_runs import robot_runs
from rsegen.robots.base import ROBOTS
from rsegen.simulators.base import Installation
from rsegen.writing.target_worlds import world_of


@pytest.mark.slow
def test_robots_that_start_at_spots_stay_upright_in_a_random_drive(gazebo: Installation) -> None:
    if gazebo.backend != "classic":
        pytest.skip("what the limits of spots were tried in is Gazebo Classic")
    scene = world_of("framed-2x2").scene()
    for seed in (2, 3):
        (run,) = robot_runs(scene.field, ROBOTS["jackal"], "random", count=1, seed=seed)
        with world_of(scene).on_disk() as world:
            track = record_drive(gazebo, world, [run], 2.0, contacts=False).trajectories[run.name]
        assert np.degrees(track.tilt).max() < 45


@pytest.mark.long(reason="a drive per robot")
def test_every_start_on_a_rough_map_is_level_and_the_robot_stays_upright(
    gazebo: Installation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.starts.DRIVE", 2.0)
    found = list(starts(gazebo, ["turtlebot"], seeds=(1,), routes=["random"]))
    driven = [each for each in found if each.tilt is not None]
    assert [each for each in driven if not each.is_good] == []
    assert {each.robot for each in driven} >= {"burger", "jackal"}
