"""What is measured on tracks that are known by heart."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from rsegen.simulation.driving.drive_metrics import Trajectory, drive_metrics

T = np.arange(0, 10.01, 0.05)


def trajectory(x: np.ndarray, **columns: np.ndarray) -> Trajectory:
    zeros = np.zeros_like(T)
    names = ("y", "z", "roll", "pitch", "yaw")
    return Trajectory(rows=np.stack([T, x, *(columns.get(name, zeros) for name in names)], axis=1))


def test_a_way_at_half_a_metre_a_second() -> None:
    found = drive_metrics(trajectory(0.5 * T - 1, z=0.01 * T), 0.5, finish_x=2.0)
    assert (found.seconds, found.distance, found.stuck, found.tipped, found.tilt) == (10, 5, 0, 0, 0)
    assert found.crossed == pytest.approx(6.05)
    assert found.climbed == pytest.approx(0.1)


def test_the_fall_at_the_start_is_no_climb() -> None:
    fall = np.maximum(0.2 - 9.81 / 2 * T**2, 0.0)
    hill = 0.03 * np.exp(-((T - 5) ** 2))
    assert drive_metrics(trajectory(0.1 * T, z=fall), 0.1).climbed == 0
    assert drive_metrics(trajectory(0.1 * T, z=fall + hill), 0.1).climbed == pytest.approx(0.03, abs=1e-3)
    assert drive_metrics(trajectory(0.1 * T, z=0.2 - hill), 0.1).climbed == pytest.approx(0, abs=1e-3)


def test_a_way_that_ends_before_the_far_side_did_not_cross() -> None:
    found = drive_metrics(trajectory(np.minimum(0.5 * T, 2.0)), 0.5, finish_x=2.5)
    assert found.crossed is None
    assert found.stuck == 6
    assert drive_metrics(trajectory(0.5 * T), 0.5).crossed is None


def test_a_robot_that_lies_on_its_side_has_tipped_over_and_one_that_gets_up_again_twice() -> None:
    found = trajectory(0.1 * T, roll=np.where(T > 3, pi / 2, 0.0))
    assert drive_metrics(found, 0.1).tipped == 1
    assert found.has_tipped
    again = trajectory(0.1 * T, pitch=np.where((T > 3) & (T < 4) | (T > 6) & (T < 7), pi, 0.0))
    assert drive_metrics(again, 0.1).tipped == 2
    assert not again.has_tipped
    assert drive_metrics(again, 0.1).tilt == pytest.approx(pi, abs=1e-3)


def test_a_track_as_csv_is_read_back() -> None:
    found = trajectory(0.123456 * T)
    text = "".join(found.csv())
    assert text.startswith("t,x,y,z,roll,pitch,yaw\n0,0,0,0,0,0,0\n")
    rows = np.loadtxt(text.splitlines()[1:], delimiter=",")
    assert np.allclose(rows, found.rows, atol=1e-4)
