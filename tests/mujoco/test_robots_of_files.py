"""Robots of users' files drive in MuJoCo as they are told, and what of their files cannot be is mended and told."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import pi
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from rsegen.errors import FileError, ParameterError
from rsegen.geometry.poses import rotation
from rsegen.mujoco.turning import turn_gain
from rsegen.mujoco.world import MujocoWorld
from rsegen.robots.files.sdf_elements import MOMENTS
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.robots.lookup import DrivableRobot, robot_of
from rsegen.robots.parameters import MOTORS
from rsegen.scene.scene import Scene
from rsegen.simulators.embedded import PlacedRobot
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from tests.mujoco.worlds import FLAT, step_of, world_of

G = 9.81


def friction(mu: float, more: str = "") -> str:
    return f"<surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2>{more}</ode></friction></surface>"


def inertial(mass: float, moment: float) -> str:
    moments = "".join(f"<{name}>{moment}</{name}>" for name in ("ixx", "iyy", "izz"))
    return f"<inertial><mass>{mass}</mass><inertia>{moments}</inertia></inertial>"


def wheel(name: str, x: float, y: float, **given: Any) -> str:
    """Return a wheel of radius 5 cm with its axle, which points to the left if axis is 1."""
    values: dict[str, Any] = {
        "mass": 0.2,
        "moment": 2.5e-4,
        "width": 0.002,
        "mu": 1.0,
        "axis": 1,
        "axle": "",
        "more": "",
    } | given
    return f"""
  <link name="{name}"><pose>{x} {y} 0.05 -{pi / 2} 0 0</pose>{inertial(values["mass"], values["moment"])}
    <collision name="tyre"><geometry><cylinder><radius>0.05</radius><length>{values["width"]}</length></cylinder>
      </geometry>{friction(values["mu"], values["more"])}</collision></link>
  <joint name="{name}_axle" type="revolute"><parent>base</parent><child>{name}</child>
    <axis><xyz>0 0 {values["axis"]}</xyz>{values["axle"]}</axis></joint>"""


def cart(
    folder: Path, wheels: Sequence[str], caster: float | None = 0.0, more: str = "", moment: float = 0.02
) -> SdfRobot:
    """Return a robot of 2 kg on wheels, with a ball in the rear, of a coefficient of friction, that does not turn."""
    ball = f"""<collision name="ball"><pose>-0.15 0 -0.08 0 0 0</pose><geometry><sphere><radius>0.02</radius></sphere>
      </geometry>{friction(caster)}</collision>""" if caster is not None else ""  # fmt: skip
    (
        folder / "cart.sdf"
    ).write_text(f"""<sdf version="1.7"><model name="cart"><link name="base"><pose>0 0 0.1 0 0 0</pose>
      {inertial(2, moment)}<collision name="hull"><geometry><box><size>0.3 0.15 0.04</size></box></geometry></collision>
      {ball}</link>{"".join(wheels)}{more}</model></sdf>""")
    return from_file(folder / "cart.sdf")


def pair(x: float = 0.05, **given: object) -> list[str]:
    return [wheel("left", x, 0.1, **given), wheel("right", x, -0.1, **given)]


def speeds(world: MujocoWorld, robot: DrivableRobot, v: float, w: float) -> tuple[float, float]:
    """Return the speed ahead and the turn rate a second after a command."""
    world.step(500)
    world.drive("robot", robot, v, w)
    world.step(1000)
    before = world.poses()["robot"]
    world.step(500)
    after = world.poses()["robot"]
    way = complex(after.x - before.x, after.y - before.y)
    return (way * np.exp(-1j * (before.yaw + after.yaw) / 2)).real / 0.5, (after.yaw - before.yaw) / 0.5


@pytest.mark.parametrize("axis", [1, -1])
def test_light_wheels_keep_their_speed_under_a_load(tmp_path: Path, axis: int) -> None:
    robot = cart(tmp_path, pair(mass=0.02, moment=2e-5, axis=axis), caster=0.5)
    assert speeds(world_of(robot), robot, 0.2, 0.0) == pytest.approx((0.2, 0.0), abs=2e-4)


@pytest.mark.parametrize("width", [0.002, 0.04])
@pytest.mark.parametrize("w", [0.4, -0.4])
def test_two_wheels_of_any_width_turn_at_their_rate(tmp_path: Path, width: float, w: float) -> None:
    robot = cart(tmp_path, pair(width=width), caster=0.5)
    assert speeds(world_of(robot), robot, 0.0, w)[1] == pytest.approx(w, rel=0.02)


def test_four_thin_wheels_skid_as_statics_has_it(tmp_path: Path) -> None:
    """Each rubs against its way: along the robot w L / 2, across it v - w B / 2, and their moments are in balance."""
    places = [("fl", 0.1, 0.1), ("rl", -0.1, 0.1), ("fr", 0.1, -0.1), ("rr", -0.1, -0.1)]
    robot = cart(tmp_path, [wheel(*place, mu=0.8) for place in places], caster=None)
    assert turn_gain(robot) == pytest.approx(1 + (0.2 / 0.2) ** 2, rel=0.02)


@pytest.mark.parametrize("mu", [0.3, 1.0])
@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_what_slides_slows_by_mu_g_and_stays_on_the_ground(tmp_path: Path, mu: float, speed: float) -> None:
    assert slide(cart(tmp_path, pair(0.15, mu=mu, width=0.02), caster=mu), FLAT, speed) == pytest.approx(
        mu * G, rel=0.01
    )


@pytest.mark.parametrize(("own", "ground"), [(0.6, 0.2), (0.2, 0.6), (1.0, 1.0)])
def test_the_smaller_coefficient_of_friction_counts(tmp_path: Path, own: float, ground: float) -> None:
    robot, patch = cart(tmp_path, pair(0.15, mu=own, width=0.02), caster=own), step_of(0.05, level_friction=(ground,))
    assert slide(robot, patch, 0.5) == pytest.approx(min(own, ground) * G, rel=0.01)


@pytest.mark.parametrize("level_friction", [(0.6,), (0.4,)])
def test_robots_that_are_rougher_than_all_of_a_map_touch_each_other(
    tmp_path: Path, level_friction: tuple[float, ...]
) -> None:
    robot = cart(tmp_path, pair(width=0.02))
    placed = [
        PlacedRobot(name=name, robot=robot, start=Pose(x=x, y=0, z=0.05 + DROP_HEIGHT, yaw=yaw))
        for name, x, yaw in (("west", -0.25, 0.0), ("east", 0.25, pi))
    ]
    world = MujocoWorld(step_of(0.05, friction=0.6, level_friction=level_friction), placed, gains=[1.0, 1.0])
    for name in ("west", "east"):
        world.drive(name, robot, 0.2, 0.0)
    world.step(1000)
    poses = world.poses()
    assert poses["east"].x - poses["west"].x == pytest.approx(0.3, abs=0.005), "their hulls are 0.3 m long"


def test_each_of_two_robots_has_its_own_friction(tmp_path: Path) -> None:
    patch = step_of(0.05, level_friction=(0.4,))
    robots = []
    for name, mu in (("smooth", 0.2), ("rough", 0.8)):
        (tmp_path / name).mkdir()
        robots.append(cart(tmp_path / name, pair(0.15, mu=mu, width=0.02), caster=mu))
    placed = [
        PlacedRobot(robot=robot, start=Pose(x=-0.7, y=y, z=0.055), name=str(y))
        for robot, y in zip(robots, (-0.4, 0.4), strict=True)
    ]
    world = MujocoWorld(patch, placed)
    assert slowing(world, ["-0.4", "0.4"], 0.5) == pytest.approx([0.2 * G, 0.4 * G], rel=0.01)


def slide(robot: SdfRobot, scene: Scene, speed: float) -> float:
    """Return by how much a robot slows, m/s^2, whose motors hold its wheels, and that is thrown ahead."""
    return slowing(
        world_of(robot, scene, Pose(x=-0.7, y=0, z=scene.field.unit * scene.field.levels.max(initial=0) + DROP_HEIGHT)),
        ["robot"],
        speed,
    )[0]


def slowing(world: MujocoWorld, names: Sequence[str], speed: float) -> list[float]:
    world.step(500)
    dofs = [world.model.joint(name).dofadr[0] for name in names]
    heights = [world.poses()[name].z for name in names]
    world.data.qvel[dofs] = speed
    world.step(10)
    before = world.data.qvel[dofs]
    for _ in range(30):
        world.step(1)
        assert [world.poses()[name].z for name in names] == pytest.approx(heights, abs=2e-5)
    return [float(change) for change in (before - world.data.qvel[dofs]) / 0.03]


def test_tracks_drive_to_where_they_head() -> None:
    robot = robot_of("crawler")
    world = world_of(robot, at=Pose(x=0, y=0, z=DROP_HEIGHT, yaw=pi / 2))
    assert speeds(world, robot, 0.3, 0.0) == pytest.approx((0.3, 0.0), abs=1e-3)
    assert world.poses()["robot"].y > 0.35


def test_motors_that_are_too_weak_are_told_with_the_torque_that_wheels_take(tmp_path: Path) -> None:
    weak = "<limit><effort>0.02</effort></limit><dynamics><friction>0.05</friction></dynamics>"
    robot = cart(tmp_path, pair(axle=weak))
    world = world_of(robot)
    assert speeds(world, robot, 0.2, 0.0)[0] == pytest.approx(0.0, abs=1e-4)
    (note,) = world.notes()
    assert note == (
        "robot: the motors of its wheels are too weak for 75% of the time: its model has 0.02 Nm for each, of"
        " which their joints take 0.05 Nm; wheels slip on the ground from 0.589 Nm on"
    )


@pytest.mark.parametrize(("tag", "torque", "drives"), [("max_wheel_torque", 0.02, False), ("wheelTorque", 3, True)])
def test_the_torque_of_a_plug_in_is_that_of_the_motors(
    tmp_path: Path, tag: str, torque: float, *, drives: bool
) -> None:
    joints = "".join(f"<{side}_joint>{side}_axle</{side}_joint>" for side in ("left", "right"))
    plugin = f'<plugin name="d" filename="libgazebo_ros_diff_drive.so">{joints}<{tag}>{torque}</{tag}></plugin>'
    rubs = "<dynamics><friction>0.05</friction></dynamics>"
    robot = cart(tmp_path, pair(axle=rubs), more=plugin)
    assert robot.read_drive is not None
    assert robot.read_drive.origin == "gazebo_ros_diff_drive"
    world = world_of(robot)
    assert speeds(world, robot, 0.2, 0.0)[0] == pytest.approx(0.2 if drives else 0.0, abs=1e-3)
    assert [f"its model has {torque} Nm for each" in note for note in world.notes()] == [True] * (not drives)


@pytest.mark.parametrize("motors", MOTORS)
def test_the_friction_of_joints_that_motors_overcome_does_not_slow_a_robot_down(tmp_path: Path, motors: str) -> None:
    rubs = "<limit><effort>2</effort></limit><dynamics><damping>0.05</damping><friction>0.2</friction></dynamics>"
    robot = cart(tmp_path, pair(axle=rubs))
    assert speeds(world_of(robot, motors=motors), robot, 0.2, 0.0)[0] == pytest.approx(0.2, abs=2e-3)


@pytest.mark.parametrize("effort", ["0", "-1", "1e16", "inf", "5"])
def test_an_effort_that_limits_nothing_is_none(tmp_path: Path, effort: str) -> None:
    robot = cart(tmp_path, pair(axle=f"<limit><effort>{effort}</effort></limit>"))
    world = world_of(robot)
    assert speeds(world, robot, 0.2, 0.0)[0] == pytest.approx(0.2, abs=1e-4)
    assert not list(world.notes())


FRAME = """<link name="imu"><pose>0 0 0.3 0 0 0</pose></link>
  <joint name="imu_joint" type="fixed"><parent>base</parent><child>imu</child></joint>"""


def test_masses_are_those_of_the_file_as_in_gazebo(tmp_path: Path) -> None:
    """A link without <inertial> has SDF's default: 1 kg, 1 kg m^2. With it TurtleBot3 climbs 1 cm, without it 3 mm."""
    robot = cart(tmp_path, pair(), more=FRAME)
    world = world_of(robot)
    assert world.model.body("robot").subtreemass[0] == pytest.approx(3.4, abs=1e-4)
    assert world.model.body("robot/imu").inertia == pytest.approx(np.ones(3))
    assert robot.remarks == ("each link without <inertial> weighs 1 kg, with 1 kg m^2, as SDF has it: imu",)


def test_moments_of_inertia_about_any_axes_are_those_of_the_file(tmp_path: Path) -> None:
    """Their principal axes may be found mirrored, which is no rotation."""
    rng, parts, tensors = np.random.default_rng(4), "", {}
    for name in "abcdefgh":
        turn = rotation(*rng.uniform(-pi, pi, 3))
        own, (roll, pitch, yaw) = turn @ np.diag([1e-3, 2e-3, 2.5e-3]) @ turn.T, rng.uniform(-1, 1, 3)
        values = zip(MOMENTS, own[np.triu_indices(3)], strict=True)
        moments = "".join(f"<{moment}>{value}</{moment}>" for moment, value in values)
        parts += f"""<link name="{name}"><inertial><pose>0 0.1 0 {roll} {pitch} {yaw}</pose><mass>0.4</mass><inertia>
          {moments}</inertia></inertial></link><joint name="{name}_on" type="fixed"><parent>base</parent>
          <child>{name}</child></joint>"""
        tensors[name] = rotation(roll, pitch, yaw) @ own @ rotation(roll, pitch, yaw).T
    world = world_of(cart(tmp_path, pair(), more=parts))
    for name, tensor in tensors.items():
        body, turn = world.model.body(f"robot/{name}"), np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        axes = turn.reshape(3, 3)
        assert axes @ np.diag(body.inertia) @ axes.T == pytest.approx(tensor, abs=1e-9), name
        assert body.ipos == pytest.approx([0, 0.1, 0])


def test_moments_of_inertia_that_fit_into_no_shape_are_told(tmp_path: Path) -> None:
    robot = cart(tmp_path, pair(), moment=5.0)
    assert world_of(robot).model.body("robot/base").inertia.max() == pytest.approx(5.0)
    assert robot.remarks == ("the moments of inertia of base are far more than fit into their shapes",)
    assert cart(tmp_path, pair()).remarks == ()


def test_the_friction_of_a_wheel_has_the_direction_of_its_axle(tmp_path: Path) -> None:
    """A direction in the plane of a wheel turns with it, and is meant to be that in which it rolls."""
    places = [("fl", 0.1, 0.1), ("rl", -0.1, 0.1), ("fr", 0.1, -0.1), ("rr", -0.1, -0.1)]
    slippery = "<fdir1>1 0 0</fdir1>"
    robot = cart(
        tmp_path, [wheel(*place, mu=0.8, more=slippery).replace("<mu2>0.8", "<mu2>0.2") for place in places], None
    )
    assert turn_gain(robot) == pytest.approx(1.07, abs=0.06)
    assert speeds(world_of(robot), robot, 0.2, 0.0) == pytest.approx((0.2, 0.0), abs=1e-3)


def test_a_wheel_without_friction_in_one_direction_stands_on_the_ground(tmp_path: Path) -> None:
    wheels = [part.replace("<mu2>1.0", "<mu2>0") for part in pair(more="<fdir1>1 0 0</fdir1>")]
    robot = cart(tmp_path, wheels)
    world = world_of(robot)
    assert speeds(world, robot, 0.2, 0.0) == pytest.approx((0.2, 0.0), abs=1e-3)
    assert world.poses()["robot"].z == pytest.approx(0.0, abs=1e-4)


def test_mecanum_wheels_are_driven_as_ordinary_ones(tmp_path: Path) -> None:
    places = [("fl", 0.1, 0.1), ("rl", -0.1, 0.1), ("fr", 0.1, -0.1), ("rr", -0.1, -0.1)]
    rollers = "<fdir1>1 0 1</fdir1>"
    robot = cart(tmp_path, [wheel(*place, more=rollers).replace("<mu2>1.0", "<mu2>0") for place in places], None)
    world = world_of(robot)
    assert speeds(world, robot, 0.2, 0.0) == pytest.approx((0.2, 0.0), abs=1e-3)
    assert "cart: its mecanum wheels are driven as ordinary ones" in next(world.notes())


@pytest.mark.parametrize("name", ["slip1", "slip2"])
def test_wheels_that_slip_under_any_force_in_gazebo_are_told(tmp_path: Path, name: str) -> None:
    def slipping(slip: float) -> tuple[str, ...]:
        return cart(tmp_path, pair(more=f"<{name}>{slip}</{name}>")).remarks

    (remark,) = slipping(0.035)
    assert remark.startswith(f"what it drives on has <{name}> 0.035, so in Gazebo it slips")
    assert slipping(0.0) == ()


def test_steered_wheels_are_refused(tmp_path: Path) -> None:
    fork = """<link name="{side}_fork"><pose>0.1 {y} 0.05 0 0 0</pose>{inertial}</link>
      <joint name="{side}_steering" type="revolute"><parent>base</parent><child>{side}_fork</child>
        <axis><xyz>0 0 1</xyz><limit><lower>-0.5</lower><upper>0.5</upper></limit></axis></joint>"""
    sides = (("left", 0.1), ("right", -0.1))
    forks = "".join(fork.format(side=side, y=y, inertial=inertial(0.1, 1e-4)) for side, y in sides)
    front = [wheel(f"{side}_front", 0.1, y).replace("<parent>base", f"<parent>{side}_fork") for side, y in sides]
    rear = [wheel(f"{side}_rear", -0.1, y) for side, y in sides]
    robot = cart(tmp_path, [*front, *rear], None, forks)
    with pytest.raises(ParameterError, match=r"^cart: left_front_axle, right_front_axle are steered wheels"):
        _ = robot.drive


def test_a_belt_runs_down_in_front_of_every_shape(tmp_path: Path) -> None:
    """A track of several boxes climbs a step with its upright face, as a belt does."""
    track = """<link name="{side}"><pose>0 {y} 0.05 0 0 0</pose>{inertial}
        <collision name="front"><pose>0.1 0 0 0 0 0</pose>{box}</collision>
        <collision name="rear"><pose>-0.1 0 0 0 0 0</pose>{box}</collision></link>
      <joint name="{side}_joint" type="fixed"><parent>base</parent><child>{side}</child></joint>"""
    sides, box = (("left", 0.15), ("right", -0.15)), "<geometry><box><size>0.2 0.05 0.1</size></box></geometry>"
    cart(tmp_path, [track.format(side=side, y=y, inertial=inertial(2, 0.01), box=box) for side, y in sides], None)
    robot = from_file(tmp_path / "cart.sdf", tracks="left,right")
    world = world_of(robot, step_of(0.01, friction=2.0), Pose(x=-1.25, y=0, z=DROP_HEIGHT))
    world.step(500)
    world.drive("robot", robot, 0.2, 0.0)
    world.step(4000)
    at = world.poses()["robot"]
    assert at.x > -0.7
    assert at.z == pytest.approx(0.01, abs=0.002)


def test_shapes_of_one_file_share_its_hull_and_the_file_is_read_again_once_it_changes(tmp_path: Path) -> None:
    def side_of(size: float, at: float) -> str:
        """Return a collision shape of a mesh that is a cube, scaled."""
        mesh = f"<mesh><uri>part.stl</uri><scale>{size} {size} {size}</scale></mesh>"
        return f'<collision name="c{at}"><pose>0 {at} 0.1 0 0 0</pose><geometry>{mesh}</geometry></collision>'

    def half_sides(world: MujocoWorld) -> list[float]:
        return sorted(round(float(extent[3]), 6) for extent in world.model.geom_aabb[world.model.geom_dataid >= 0])

    load = f"""<link name="load"><pose>0 0 0.2 0 0 0</pose>{inertial(0.1, 1e-4)}
      {side_of(1, 0.1)}{side_of(1, -0.1)}{side_of(0.5, 0)}</link>
      <joint name="held" type="fixed"><parent>base</parent><child>load</child></joint>"""
    trimesh.creation.box((0.04, 0.04, 0.04)).export(tmp_path / "part.stl")
    robot = cart(tmp_path, pair(), more=load)
    world = world_of(robot)
    assert world.model.nmesh == 2
    assert "robot: 3 of its collision shapes are meshes, which touch with their convex hulls" in world.notes()
    assert half_sides(world) == [0.01, 0.02, 0.02]
    trimesh.creation.box((0.06, 0.06, 0.06)).export(tmp_path / "part.stl")
    os.utime(tmp_path / "part.stl", (1, 1))  # as clocks of files may be coarse
    assert half_sides(world_of(robot)) == [0.015, 0.03, 0.03]


@pytest.mark.parametrize(
    "more", ["", inertial(0.1, 1e-4).join(('<link name="far">', "</link>"))], ids=["all", "a part"]
)
def test_links_on_joints_in_a_loop_are_refused(tmp_path: Path, more: str) -> None:
    ends = ("far", "far") if more else ("left", "base")
    loop = f'<joint name="loop" type="fixed"><parent>{ends[0]}</parent><child>{ends[1]}</child></joint>'
    robot = cart(tmp_path, [wheel("left", 0, 0.15), wheel("right", 0, -0.15)], more=more + loop)
    with pytest.raises(FileError, match=rf"the joints above link {ends[1]} form a loop"):
        world_of(robot)
