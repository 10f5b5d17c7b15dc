"""Maps as they were built: blocks are higher and friction is other than drawn, and what holds a robot has a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rsegen.robots.lookup import robot_of
from rsegen.simulators.embedded import AsBuilt
from rsegen.simulators.poses import Pose
from tests.mujoco.worlds import step_of, world_of

PLATFORM = step_of(0.05)
ON_IT = Pose(x=0.0, y=0.0, z=0.055)


@pytest.mark.parametrize("error", [-0.004, 0.003])
def test_a_robot_stands_as_much_higher_as_its_blocks(error: float) -> None:
    shape = PLATFORM.field.shape
    heights = []
    for errors in (np.full(shape, np.nan), np.full(shape, error)):
        world = world_of("burger", PLATFORM, ON_IT, built=AsBuilt(heights=errors))
        world.step(500)
        heights.append(world.poses()["robot"].z)
    assert heights[1] - heights[0] == pytest.approx(error, abs=3e-5), "a wheel on two boxes sinks in less"


def test_blocks_without_an_error_are_as_drawn() -> None:
    as_drawn = world_of("burger", PLATFORM, ON_IT)
    built = world_of("burger", PLATFORM, ON_IT, built=AsBuilt(heights=np.full(PLATFORM.field.shape, np.nan)))
    for world in (as_drawn, built):
        world.drive("robot", robot_of("burger"), 0.1, 0.0)
        world.step(1000)
    assert as_drawn.data.qpos.tobytes() == built.data.qpos.tobytes()
    assert as_drawn.poses()["robot"].x > 0.05


@pytest.mark.parametrize("robot", ["jackal", "crawler"])
def test_friction_is_multiplied_for_every_contact(robot: str) -> None:
    frictions = []
    for share in (1.0, 0.5):
        world = world_of(robot, PLATFORM, replace(ON_IT, z=0.06), built=AsBuilt(friction=share))
        world.step(400)
        assert len(world.data.contact.dist) > 0
        frictions.append(np.sort(world.data.contact.friction[:, 0]))
    assert frictions[1].max() == pytest.approx(frictions[0].max() / 2)
    assert frictions[1].min() == pytest.approx(frictions[0].min() / 2)


def test_the_part_that_holds_a_robot_is_named() -> None:
    wall = step_of(0.3)
    before = Pose(x=-1.3, y=0.0, z=0.005)
    world = world_of("jackal", wall, before)
    assert world.held_by("robot") is None, "on the ground"
    world.drive("robot", robot_of("jackal"), 0.3, 0.0)
    world.step(3000)
    part = world.held_by("robot")
    assert part is not None
    assert part.partition("::")[0] in {"base", "front_left_wheel", "front_right_wheel"}
    assert world.poses()["robot"].x < -1.0
