"""Robots rest level a second after their start, wherever a seed puts them, and stay upright when they are driven."""

from __future__ import annotations

import pytest

from benchmarks.starts import starts
from rsegen.simulation.simulators import Installation


@pytest.mark.long(reason="a drive per robot, map, route and seed")
def test_every_start_on_rough_maps_is_level_and_the_robot_stays_upright(gazebo: Installation) -> None:
    found = list(starts(gazebo, ["turtlebot", "mixed-course"], seeds=(1, 2)))
    driven = [each for each in found if each.tilt is not None]
    assert [each for each in driven if not each.is_good] == []
    places = {(each.example, each.robot) for each in driven if each.route == "random"}
    assert places >= {(example, robot) for example in ("turtlebot", "mixed-course") for robot in ("burger", "jackal")}
