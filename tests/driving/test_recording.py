"""Records of few digits, sharpened by the poses that are known exactly."""

from __future__ import annotations

from itertools import pairwise
from math import hypot

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen.driving.recording import with_more_digits
from rsegen.field.stepfield import Array
from rsegen.simulators.poses import Record

STEP, PERIOD = 0.05, 0.5


def _way(x: float, y: float, yaw: float, turn: float) -> Array:
    """The rows t, x, y, z, roll, pitch, yaw of a robot that drives in an arc for ten seconds, at 0.1 m/s."""
    t = np.arange(0, 10 + STEP / 2, STEP)
    heading = yaw + turn * t
    ways = np.cumsum(0.1 * STEP * np.stack([np.cos(heading), np.sin(heading)]), axis=1)
    wrapped = (heading + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([t, x + ways[0], y + ways[1], 0.01 * np.sin(t), 0.1 * np.cos(t), 0 * t, wrapped])


def _record(rows: Array, digits: int | None = None) -> Record:
    said = [[float(f"{each:.{digits}g}") if digits else float(each) for each in row] for row in rows[:, 1:]]
    return [(float(t), {"robot": pose}) for t, pose in zip(rows[:, 0], said, strict=True)]


def _poses(record: Record) -> Array:
    return np.array([poses["robot"] for _, poses in record])


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(-3.1, 3.1), st.floats(-0.3, 0.3))
def test_poses_far_from_the_origin_are_exact_to_a_millimetre(x: float, y: float, yaw: float, turn: float) -> None:
    rows = _way(x, y, yaw, turn)
    every = round(PERIOD / STEP)
    sharp = _poses(with_more_digits(_record(rows, 3), _record(rows[::every]), 3))
    assert np.abs(sharp[:, :3] - rows[:, 1:4]).max() < 1e-3
    turned = (sharp[:, 3:] - rows[:, 4:] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(turned).max() < 5e-3
    np.testing.assert_allclose(sharp[::every, :3], rows[::every, 1:4], atol=1e-9)


def test_a_drive_ten_metres_from_the_origin_is_as_long_as_it_was() -> None:
    rows = _way(-11, 0, 0, 0)
    coarse = _record(rows, 3)

    def length(record: Record) -> float:
        return sum(hypot(*(after - before)) for before, after in pairwise(_poses(record)[:, :2]))

    assert length(_record(rows)) == pytest.approx(1.0)
    assert len({poses["robot"][0] for _, poses in coarse}) < 13  # the record has steps of 10 cm
    assert length(with_more_digits(coarse, _record(rows[::10]), 3)) == pytest.approx(1.0, abs=1e-3)


def test_what_the_record_says_between_known_poses_stays() -> None:
    rows = _way(0.2, 0.1, 0, 0)
    rows[105, 3] = 0.5  # it is thrown up between two known poses
    sharp = _poses(with_more_digits(_record(rows, 3), _record(rows[::10]), 3))
    assert sharp[105, 2] == pytest.approx(0.5, abs=1e-3)


def test_a_robot_that_is_not_known_stays_as_recorded() -> None:
    record = _record(_way(5, 0, 0, 0), 3)
    assert with_more_digits(record, [], 3) == record
    assert with_more_digits(record, [(0.0, {"other": [0.0] * 6})], 3) == record
