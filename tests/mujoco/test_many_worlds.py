"""Robots in many worlds of mujoco_warp drive as one does in MuJoCo: over blocks, on wheels and on belts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rsegen import Random, Recipe
from rsegen.errors import ParameterError
from rsegen.robots.lookup import robot_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import Pose
from tests.support.late_import import LateImport

pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from rsegen.mujoco.world import MujocoWorld  # it needs MuJoCo
from tests.mujoco.worlds import world_of

many_worlds = LateImport("rsegen.mujoco.many_worlds", reason="mujoco_warp is not installed")

pytestmark = [pytest.mark.long(reason="Warp, 0.4 GB, which compiles its kernels"), pytest.mark.slow]

WORLDS = 3


def _on_blocks(robot: str, unit: float, motors: str) -> MujocoWorld:
    """A robot before random blocks that it climbs, a little aside and turned."""
    recipe = Recipe(seed=7, unit_cm=unit, boundary="none", obstacles=[Random(levels=4)])
    reach = float(robot_of(robot).body.high[0])
    return world_of(robot, compose(recipe), Pose(x=-0.51 - reach, y=0.03, z=0.005, yaw=0.1), motors=motors)


@pytest.mark.parametrize("motors", MOTORS)
@pytest.mark.parametrize(("robot", "unit", "steps"), [("crawler", 2, 600), ("jackal", 1, 500)])
def test_robots_drive_over_blocks_as_in_one_world(robot: str, unit: float, steps: int, motors: str) -> None:
    one, other = _on_blocks(robot, unit, motors), _on_blocks(robot, unit, motors)
    many = many_worlds.ManyWorlds(other, WORLDS, device="cpu")
    known, (start, *_) = robot_of(robot), many.poses()
    v, w = known.drive.speed / 2, known.drive.turn / 5
    one.drive("robot", known, v, w)
    many.drive(v, w)
    blocks = slice(1, min(one.shapes.directions))  # MuJoCo has the plane, the blocks and then the robot
    assert blocks.stop > 20
    touched = np.zeros(WORLDS)
    for _ in range(steps // 50):
        one.step(50)
        many.step(50)
        touched += many.touches(blocks).numpy()

    place, own = many.poses(), one.data.qpos[:3]
    assert (touched > 0).all()
    assert own[2] > 0.001, "it has not climbed"
    assert np.linalg.norm(own[:2] - start[:2]) > 0.5 * v * steps / 1000
    assert np.abs(place[:, :3] - own).max() < 0.001
    assert np.ptp(place, axis=0).max() == 0, "worlds that begin alike stay alike"


@pytest.mark.parametrize("motors", MOTORS)
def test_each_world_drives_at_its_own_speed(motors: str) -> None:
    many = many_worlds.ManyWorlds(world_of("crawler", motors=motors), WORLDS, device="cpu")
    v, w = np.array([0.5, 0.5, -0.3]), np.array([0.0, 0.8, 0.0])
    many.drive(v, w)
    many.step(500)
    places = many.poses()

    for world in range(WORLDS):
        one = world_of("crawler", motors=motors)
        one.drive("robot", robot_of("crawler"), float(v[world]), float(w[world]))
        one.step(500)
        assert np.abs(places[world] - one.data.qpos[:7]).max() < 2e-4
    assert places[0, 0] > 0.2
    assert places[2, 0] < -0.1
    assert abs(places[1, 6]) > 0.05, "it has turned"


def test_a_wedged_belt_stalls() -> None:
    many = many_worlds.ManyWorlds(world_of("crawler"), WORLDS, device="cpu")
    many.limit = 1.0  # N: it counts as wedged as soon as it stands
    many.step(200)
    before = many.poses()
    many.drive(0.5, 0.0)
    many.step(300)
    assert np.abs(many.poses()[:, 0] - before[:, 0]).max() < 0.01


def test_worlds_with_two_robots_are_refused() -> None:
    placed = [
        PlacedRobot(name=name, robot=robot_of("burger"), start=Pose(x=0, y=y, z=0)) for name, y in (("a", -1), ("b", 1))
    ]
    with pytest.raises(ParameterError, match="2 robots in it"):
        many_worlds.ManyWorlds(MujocoWorld(compose(Recipe(boundary="none")), placed), WORLDS, device="cpu")


def test_flippers_turn_to_their_targets() -> None:
    many: Any = many_worlds.ManyWorlds(world_of("crawler"), WORLDS, device="cpu")
    one = world_of("crawler")
    joint = one.model.joint("robot/left_flipper_pivot")
    ctrl = many.data.ctrl.numpy()
    ctrl[:, one.model.actuator("robot/left_flipper_pivot").id] = [0.0, 0.5, 1.0]
    many.data.ctrl.assign(ctrl)
    many.step(800)
    angles = many.data.qpos.numpy()[:, joint.qposadr[0]]
    assert angles == pytest.approx([0.0, 0.5, 1.0], abs=0.03)
