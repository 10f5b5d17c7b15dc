"""What a robot can do on a map: the same as the commands say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe, compose
from rsegen.gui.model.preview import costs
from rsegen.gui.model.reach import corners
from rsegen.gui.model.simulation import reach
from rsegen.robots import ROBOTS
from rsegen.simulation.driving.routes import followed
from rsegen.standing.spots import Outline, Spot
from rsegen.standing.ways import reach as reached

ROUGH = Recipe(seed=5, chunk_size=4, chunks=(3, 2), boundary="none", obstacles=[Random(levels=3)])


@pytest.mark.parametrize("unit_cm", [0.5, 10])
@pytest.mark.parametrize("name", ["burger", "jackal", "crawler"])
def test_reach_is_that_of_metrics_drive_and_spots(name: str, unit_cm: float) -> None:
    recipe = replace(ROUGH, unit_cm=unit_cm)
    field, robot = compose(recipe).field, ROBOTS[name]
    found, wanted = reach(field, name, 5), reached(field, robot.body)
    assert np.array_equal(found.region, wanted.region)
    crosses = [wanted.west_east.crosses, wanted.south_north.crosses]
    assert [way.is_eastward for way in found.ways if not way.is_too_steep] == [
        is_eastward for is_eastward, each in zip((True, False), crosses, strict=True) if each
    ]
    assert ("crosses west to east" in found.text) == crosses[0]
    if crosses[0] or not any(crosses):
        way = followed(field, robot.body, wanted.west_east)
        assert np.allclose(found.ways[0].points, way.points)
        assert found.ways[0].is_too_steep == (not way.crosses)
    try:
        spots: tuple[Spot, ...] = rsegen.spots(recipe, robot=name, count=2, seed=5)
    except rsegen.UserError:
        spots = ()
    assert found.spots == spots


def test_without_a_robot_and_on_huge_maps_no_reach_is_shown() -> None:
    assert costs(compose(ROUGH)).reach is None
    assert costs(compose(ROUGH), "burger").reach is not None
    huge = Recipe(seed=1, chunk_size=400, boundary="none", obstacles=ROUGH.obstacles)
    assert costs(compose(huge), "burger").reach is None


def test_the_corners_of_a_robot_that_heads_north() -> None:
    spot = Spot(x=1.0, y=2.0, z=0.0, yaw=np.pi / 2)
    found = corners(Outline(-0.1, -0.2, 0.4, 0.2), spot)
    assert np.allclose(found, [(0.8, 1.9), (1.2, 1.9), (1.2, 2.4), (0.8, 2.4)])
