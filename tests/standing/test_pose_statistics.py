"""Statistics of a robot's poses all over a field."""

from __future__ import annotations

import numpy as np
import pytest

import rsegen
from rsegen.standing.pose_statistics import PoseStatistics, pose_statistics

JACKAL = rsegen.robot_of("jackal")
FIELD = rsegen.build(rsegen.Recipe(seed=1, unit_cm=2, boundary="none", obstacles=[rsegen.Random(levels=4)]))


def test_statistics_are_those_of_the_poses_of_every_block_and_heading() -> None:
    found = pose_statistics(FIELD, JACKAL.body)
    middles = (np.arange(10) - 4.5) * FIELD.block_width
    x, y, heading = (each.ravel() for each in np.meshgrid(middles, middles, np.radians(np.arange(8) * 45)))
    every = rsegen.poses(FIELD, JACKAL, x, y, heading)
    tilts, clearances = np.sort(every.tilt[every.stands]), every.clearance[every.stands & np.isfinite(every.clearance)]
    assert found.stands == pytest.approx(every.stands.mean())
    assert found.tilt_median == pytest.approx(np.median(tilts))
    assert found.tilt_p90 == pytest.approx(tilts[round(0.9 * (len(tilts) - 1))], abs=np.diff(tilts).max())
    assert found.clearance_least == pytest.approx(clearances.min())
    assert found.clearance_median == pytest.approx(np.median(clearances))
    ways = rsegen.stable_poses(FIELD, JACKAL, x, y, heading)
    assert (ways.count > 1).any()
    assert found.ambiguous == pytest.approx((ways.count > 1).mean(), abs=0.1)  # of a sample of 128 of 800


def test_on_level_ground_every_pose_stands_and_is_level() -> None:
    flat = rsegen.build(rsegen.Recipe(seed=1, boundary="none"))
    found = pose_statistics(flat, JACKAL.body)
    assert found.stands == 1
    assert found.ambiguous == 0
    assert found.tilt_p90 == pytest.approx(0, abs=1e-3)
    assert found.clearance_least == pytest.approx(found.clearance_median, abs=1e-6)
    assert found.clearance_least is not None
    assert found.clearance_least > 0.03  # the chassis of a Jackal


def test_where_a_robot_never_stands_it_has_no_tilt_and_no_clearance() -> None:
    """A row of cells at the foot of a wall of three metres: everywhere half of the robot is on it."""
    wall = np.array([[False] * 9, [True] * 9])
    foot = rsegen.StepField(levels=np.zeros_like(wall, np.int16), frame=wall, block_width=0.1, unit=0.1, frame_height=3)
    found = pose_statistics(foot, JACKAL.body)
    assert found == PoseStatistics(
        stands=0, ambiguous=None, tilt_median=None, tilt_p90=None, clearance_median=None, clearance_least=None
    )


@pytest.mark.slow
def test_statistics_by_name_are_those_of_reach() -> None:
    from rsegen.measuring.catalogue import metric_by

    reached = JACKAL.reach(FIELD).poses
    assert metric_by("reach.poses.tilt_p90", JACKAL)(FIELD) == reached.tilt_p90
    with pytest.raises(rsegen.UserError, match=r"by: reach\.poses\.stands is measured with a robot"):
        metric_by("reach.poses.stands", rsegen.StepLimits(climb_cm=10))(FIELD)
