"""Robots with wheels keep their speed in MuJoCo, and roll up blocks as far as their shapes allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.mujoco_drives import drive_recording, rim_speeds
from benchmarks.mujoco_robots import motors
from rsegen.driving.robot_runs import robot_runs
from rsegen.driving.routes import Motion
from rsegen.field.stepfield import Array, StepField
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import Wheels
from tests.standing.stands import field_of

KINDS = ("burger", "jackal")
FLAT = np.zeros((10, 10), int)


def driven(field: StepField, kind: str, seconds: float) -> Array:
    """Return the trajectory of a robot on its way across a field."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    runs = robot_runs(field, ROBOTS[kind], "straight", count=1, seed=1)
    return drive_recording(field, runs, seconds).trajectories[runs[0].name].rows


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_crosses_a_flat_field_straight_at_its_speed(kind: str) -> None:
    t, x, y = driven(field_of(FLAT), kind, 3.0)[:, :3].T
    assert t[:3] == pytest.approx([0, 0.05, 0.1])
    assert (x[-1] - x[20]) / (t[-1] - t[20]) == pytest.approx(ROBOTS[kind].driving_speed, rel=0.01)
    assert np.abs(y).max() < 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_a_drive_ends_when_all_routes_are_done(kind: str) -> None:
    t, x = driven(field_of(FLAT), kind, 30.0)[:, :2].T
    assert t[-1] < 10
    assert x[-1] > 0.5


@pytest.mark.parametrize(("kind", "step", "crosses"), [("burger", 0.005, True), ("burger", 0.008, False)])
def test_the_burger_is_held_at_a_step_that_is_higher_than_its_caster(kind: str, step: float, *, crosses: bool) -> None:
    x = driven(field_of(FLAT + 1, unit=step), kind, 10.0)[:, 1]
    assert (x[-1] > 0.5) == crosses


def test_a_wheel_rolls_up_the_edge_of_a_block() -> None:
    # With several contacts of two shapes it is held at edges that are far below its axle.
    levels = FLAT.copy()
    levels[2::2] = 1
    assert driven(field_of(levels, unit=0.03), "jackal", 8.0)[-1, 1] > 0.5


def test_wheels_turn_as_classic_is_told_to_turn_them() -> None:
    drive = ROBOTS["jackal"].drive
    assert isinstance(drive, Wheels)
    left, right = rim_speeds(drive, Motion(0.4, 0.5))
    assert (left + right) / 2 == pytest.approx(0.4)
    assert (right - left) / drive.separation == pytest.approx(0.5 * drive.slip)


def test_a_motor_has_the_torque_of_its_joint() -> None:
    robot = ROBOTS["burger"]
    assert "forcerange" not in motors(robot)
    strong = replace(robot, joints=tuple(replace(joint, effort=0.5) for joint in robot.joints))
    assert motors(strong).count('forcerange="-0.5 0.5"') == 2


def test_tracks_cannot_be_driven() -> None:
    with pytest.raises(TypeError, match="crawler has no wheels"):
        motors(ROBOTS["crawler"])


def test_robots_side_by_side_have_a_trajectory_each() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    robot: Robot = ROBOTS["burger"]
    field = field_of(FLAT)
    runs = robot_runs(field, robot, "straight", count=3, seed=1)
    trajectories = drive_recording(field, runs, 1.0).trajectories
    assert [float(trajectories[run.name].rows[-1, 2]) for run in runs] == pytest.approx(
        [run.start.y for run in runs], abs=1e-3
    )
