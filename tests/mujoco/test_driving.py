"""Robots that drive in MuJoCo do as they are told on flat ground, and physics says what they can climb."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.errors import SimulatorFailed
from rsegen.mujoco import contacts as mujoco_contacts
from rsegen.mujoco.turning import turned_within
from rsegen.mujoco.world import MujocoWorld
from rsegen.recipe.examples import EXAMPLES
from rsegen.recipe.recipe_file import load
from rsegen.robots.base import ROBOTS
from rsegen.robots.lookup import robot_of
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from tests.mujoco.worlds import FLAT, step_of, world_of

EACH = pytest.mark.parametrize("kind", list(ROBOTS))
WHEELED = pytest.mark.parametrize("motors", ["reaction", "classic"])


def settled(world: MujocoWorld) -> Pose:
    world.step(500)
    return world.poses()["robot"]


@EACH
@WHEELED
def test_a_robot_drives_straight_at_its_speed(kind: str, motors: str) -> None:
    world, robot = world_of(kind, motors=motors), robot_of(kind)
    settled(world)
    world.drive("robot", robot, 0.2, 0.0)
    world.step_with_contacts(1000)
    before = world.poses()["robot"]
    world.step_with_contacts(1000)
    after = world.poses()["robot"]
    assert after.x - before.x == pytest.approx(0.2, rel=0.01)
    assert abs(after.y) < 1e-4
    # Two shapes in one place, of which Classic's belts are, share their load but for some digits.
    assert abs(after.yaw) < (1e-3 if (kind, motors) == ("crawler", "classic") else 1e-4)
    # It stands on its wheels or belts all the time, and sinks in by less than a tenth of a millimetre.
    driven = [share for part, share in world.shares()["robot"].items() if "hull" not in part]
    assert len(driven) >= 3
    assert min(driven) > 0.9
    assert abs(after.z) < 1e-4


@EACH
@pytest.mark.parametrize(("v", "w"), [(0.0, 0.4), (0.0, -0.4), (0.2, 0.3)])
def test_a_robot_turns_at_the_rate_that_it_is_told(kind: str, v: float, w: float) -> None:
    world, robot = world_of(kind), robot_of(kind)
    settled(world)
    world.drive("robot", robot, v, w)
    world.step(1000)
    before = world.poses()["robot"].yaw
    world.step(2000)
    assert world.poses()["robot"].yaw - before == pytest.approx(2 * w, rel=0.1)


@EACH
def test_a_robot_that_is_told_nothing_stays_where_it_is(kind: str) -> None:
    world = world_of(kind)
    first = settled(world)
    world.step(2000)
    assert world.poses()["robot"].distance(first) < 1e-5


CART = """\
<sdf version="1.6"><model name="cart">
  <link name="base"><pose>0 0 0.05 0 0 0</pose><inertial><mass>0.2</mass>
    <inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>
    <collision name="ball"><pose>-0.15 0 -0.04 0 0 0</pose><geometry><sphere><radius>0.01</radius></sphere></geometry>
      <surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision></link>
  {wheels}
</model></sdf>"""
WHEEL = """\
  <link name="{side}"><pose>0 {y} 0.05 -1.5707963 0 0</pose><inertial><mass>1</mass>
    <inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.002</izz></inertia></inertial>
    <collision name="tyre"><geometry><cylinder><radius>0.05</radius><length>0.02</length></cylinder></geometry>
      <surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2></ode></friction></surface></collision></link>
  <joint name="{side}_axle" type="continuous"><parent>base</parent><child>{side}</child>
    <axis><xyz>0 0 1</xyz></axis></joint>
"""


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.5, 1.0])
def test_wheels_climb_what_statics_let_them(mu: float, tmp_path: Path) -> None:
    """A wheel of radius r rolls up h = r (1 - 1 / sqrt(1 + mu^2)) at most: the force on the edge is within its cone.

    Of this cart nearly all the weight is on its two wheels; the rest is on a ball without friction.
    """
    wheels = "".join(WHEEL.format(side=side, y=y, mu=mu) for side, y in (("left", 0.1), ("right", -0.1)))
    file = tmp_path / "cart.sdf"
    file.write_text(CART.format(wheels=wheels))
    limit = 0.05 * (1 - 1 / sqrt(1 + mu * mu))
    assert climbed(str(file), 0.95 * limit, speed=0.01)
    assert not climbed(str(file), 1.09 * limit, speed=0.01)


def climbed(robot: str, height: float, motors: str = "reaction", speed: float = 0.1) -> bool:
    """Return whether the whole robot drives up a step, from 2 cm before it; it has touched the step in any case."""
    model = robot_of(robot)
    start = Pose(x=-1.0 - float(model.body.high[0]) - 0.02, y=0.0, z=DROP_HEIGHT)
    world = world_of(model, step_of(height), start, motors=motors)
    settled(world)
    world.drive("robot", model, speed, 0.0)
    touched, beyond, places = False, -1.0 - float(model.body.low[0]) + 0.01, [start.x]
    for _ in range(round(3 * (beyond - start.x) / speed / 0.1)):
        contacts = world.step_with_contacts(100)
        touched |= any("step_0000" in name for contact in contacts for name in contact.collisions)
        places.append(world.poses()["robot"].x)
        is_stuck = touched and places[-1] - places[-21:][0] < 0.01 * speed  # in two seconds
        if places[-1] > beyond or (is_stuck and len(places) > 20):
            break
    assert touched
    at = world.poses()["robot"]
    return at.x > beyond and at.z > 0.9 * height


def test_a_caster_is_lifted_over_an_edge_only_without_the_reaction_of_the_motors() -> None:
    assert climbed("burger", 0.008, motors="classic")
    assert not climbed("burger", 0.008, motors="reaction")
    assert climbed("burger", 0.001, motors="reaction")


@pytest.mark.parametrize(("kind", "height", "friction", "v"), [("crawler", 0.03, 0.3, 0.2), ("jackal", 0.05, 1, 0.4)])
def test_what_slips_holds_across_only_as_in_classic(kind: str, height: float, friction: float, v: float) -> None:
    """One side meets a step and slips there; a real robot is turned towards it by the other side."""
    step = step_of(height, friction=friction)
    levels = step.field.levels.copy()
    levels[:, 10:] = 0
    scene, turned = replace(step, field=replace(step.field, levels=levels)), {}
    for motors in ("reaction", "classic"):
        world = world_of(kind, scene, Pose(x=-1.6, y=0.0, z=DROP_HEIGHT), motors=motors)
        settled(world)
        world.drive("robot", robot_of(kind), v, 0.0)
        met, yaws = False, []
        for _ in range(30):
            contacts = world.step_with_contacts(100)
            met |= any("step_0000" in name for contact in contacts for name in contact.collisions)
            yaws.append(abs(world.poses()["robot"].yaw))
        assert met
        turned[motors] = max(yaws)
    assert turned["reaction"] > 0.3
    assert turned["classic"] < turned["reaction"] / 3


@pytest.mark.parametrize(
    ("v", "w", "turned"),
    [(0.0, 0.75, 0.753), (0.0, 1.5, 1.506), (0.1, 0.5, 0.022), (0.4, 0.8, 0.772), (0.4, -0.8, -0.772)],
)
def test_belts_turn_as_in_classic_without_a_measured_gain(v: float, w: float, turned: float) -> None:
    """Rates of turn, rad/s, in Gazebo Classic 11.1; at 0.1 m/s its plug-in has the robot hardly turn at all."""
    world = world_of("crawler", motors="classic")
    world.gains = [7.0]  # unused
    settled(world)
    world.drive("robot", robot_of("crawler"), v, w)
    world.step(500)
    assert turned_within(world, 2.0) / 2.0 == pytest.approx(turned, abs=0.02)


@pytest.mark.slow
def test_belts_climb_a_step_as_high_as_their_ends() -> None:
    assert climbed("crawler", 0.1)
    assert not climbed("crawler", 0.4)


def test_friction_across_a_belt_is_that_of_its_drive() -> None:
    """At rest it holds against a push to the side up to mu2 of its weight, and along it up to mu."""
    robot = robot_of("crawler")
    weight = 9.81 * robot.mass  # type: ignore[union-attr]  # an included robot
    for direction, mu in (((0, 1, 0), 0.5), ((1, 0, 0), 1.0)):
        for share, slides in ((0.9, False), (1.1, True)):
            world = world_of(robot)
            first = settled(world)
            body = world.model.body("robot/base").id
            world.data.xfrc_applied[body, :3] = share * mu * weight * np.array(direction)
            world.step(500)
            assert (world.poses()["robot"].distance(first) > 0.05) == slides, (direction, share)


def test_a_robot_that_starts_inside_a_block_is_refused() -> None:
    message = r"^MuJoCo: .*step_0000::map::blocks.* are 9. mm inside each other: no robot can start there"
    with pytest.raises(SimulatorFailed, match=message):
        world_of("jackal", step_of(0.1), Pose(x=0, y=0, z=DROP_HEIGHT))


def test_robots_touch_each_other() -> None:
    robot = robot_of("jackal")
    placed = [
        PlacedRobot(robot=robot, name="one", start=Pose(x=0, y=0, z=DROP_HEIGHT)),
        PlacedRobot(robot=robot, name="other", start=Pose(x=1.0, y=0, z=DROP_HEIGHT)),
    ]
    world = MujocoWorld(FLAT, placed)
    world.step(500)
    world.drive("one", robot, 0.4, 0.0)
    world.drive("other", robot, 0.1, 0.0)
    touched = False
    for _ in range(40):
        contacts = world.step_with_contacts(100)
        touched |= any({name.split("::")[0] for name in contact.collisions} == {"one", "other"} for contact in contacts)
    assert touched
    poses = world.poses()
    assert poses["other"].x > 1.0 + 1.2 * 0.1 * 4  # it was pushed
    assert poses["other"].x - poses["one"].x > 0.3  # neither is inside the other


DRIVEN = """
import json, rsegen
recipe = rsegen.Recipe(name="same", seed=7, boundary="none", unit_cm=4, obstacles=[rsegen.Random(levels=3)])
result = rsegen.drive(recipe, robot="crawler", route="straight", duration=3, seed=1, predict=False)
print(json.dumps([row.hex() for row in result.robots[0].trajectory.rows.ravel().tolist()]))
"""


@pytest.mark.slow
def test_the_same_drive_gives_the_same_bits_in_every_process() -> None:
    one, other = (
        json.loads(subprocess.run([sys.executable, "-c", DRIVEN], capture_output=True, check=True, text=True).stdout)
        for _ in range(2)
    )
    assert len(one) == 7 * 61
    assert len(set(one)) > 300  # it has moved
    assert one == other


def test_a_tracked_robot_crosses_a_field_of_blocks() -> None:
    recipe = rsegen.Recipe(name="low", seed=5, boundary="none", unit_cm=3, obstacles=[rsegen.NormalRandom(levels=3)])
    result = rsegen.drive(recipe, robot="crawler", seed=1, predict=False)
    (robot,) = result.robots
    assert result.simulator.startswith("MuJoCo ")
    assert robot.metrics.crossed is not None
    on_blocks = [contact for _, contacts in result.contact_samples for contact in contacts]
    assert any("low_0000" in name for contact in on_blocks for name in contact.collisions)
    assert robot.metrics.climbed > 0.02


@pytest.mark.parametrize(("weights", "moves"), [(0, True), (100, False)])
def test_belts_stall_while_they_are_pressed_with_many_weights(
    weights: int, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some ten contacts share what presses: each has more than the limit, which is lower here, as blocks are hard."""
    monkeypatch.setattr(mujoco_contacts, "_WEDGED", 5.0)
    robot = robot_of("crawler")
    world = world_of(robot)
    first = settled(world)
    world.drive("robot", robot, 0.4, 0.0)
    pressed = world.model.body("robot/base").id
    world.data.xfrc_applied[pressed, 2] = -weights * 9.81 * robot.mass  # type: ignore[union-attr]  # an included robot
    world.step(1000)
    assert world.data.ncon >= 8
    assert (world.poses()["robot"].x - first.x > 0.3) == moves
    world.data.xfrc_applied[pressed, 2] = 0.0
    world.step(1000)
    assert world.poses()["robot"].x - first.x > 0.3


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])
def test_a_drive_in_a_pit_has_a_result(seed: int) -> None:
    """On this map a track was wedged in the pit after four seconds, and pulled the robot into a block."""
    (robot,) = rsegen.drive(
        load(EXAMPLES["stairs-and-stones"]), robot="crawler", route="random", duration=6, seed=seed, predict=False
    ).robots
    assert robot.metrics.seconds == pytest.approx(6)
    assert robot.metrics.touched
