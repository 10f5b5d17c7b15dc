"""Robots of users' own SDF and URDF files in real servers: driven by whatever drive they name, and spawned on a map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot, sin
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import rsegen
from rsegen import Matrix, Recipe
from rsegen.driving.recording import RobotRun, record_drive
from rsegen.driving.routes import Motion, Route
from rsegen.gazebo import sdf
from rsegen.robots.files.sdf_file import SdfRobot, from_file
from rsegen.simulators.base import Installation
from rsegen.simulators.poses import DROP_HEIGHT, Pose
from rsegen.simulators.server import running_server
from tests.robots.makers_robot import makers_robot
from tests.robots.mjcf_robots import WHEELS, two_wheels_mjcf
from tests.robots.tracked_and_legged import legged, tracked
from tests.robots.two_wheels import PLUGINS, in_a_nested_model, two_wheels
from tests.robots.urdf_robots import two_wheels_urdf

V, W = 0.15, 0.5
"""m/s and rad/s; the record of Gazebo Classic has three digits of each place, so all robots are near the origin."""

WHISKER = """\
<body name="whisker" pos="0.1 0 0.1">
  <joint name="nods" axis="0 1 0" stiffness="0.05" damping="0.001"/>
  <joint name="shakes" axis="1 0 0" stiffness="0.05" damping="0.001"/>
  <geom type="sphere" size="0.01" mass="0.005" contype="0" conaffinity="0"/>
</body>
"""
"""A part so light that its damping, taken at the beginning of a step, throws it about."""

CASTER = """\
<geom name="ball" type="capsule" size="0.02 0.03" pos="-0.15 0 -0.03" euler="0 90 0" mass="0.1" condim="1"
  priority="1"/>
"""
"""A shape that Gazebo Classic does not have, on which the robot stands."""

CAMERA = """\
<link name="{0}"><pose>0 0 {2} 0 0 0</pose><inertial><pose>-0.05 0 0.02 0 0 0</pose><mass>0.05</mass>
  <inertia><ixx>1e-8</ixx><iyy>1e-8</iyy><izz>1e-8</izz></inertia></inertial></link>
<joint name="{0}_joint" {3}<parent>{1}</parent><child>{0}</child></joint>
"""
JOINTS = (
    'type="fixed">',
    'type="revolute"><axis><xyz>0 0 1</xyz></axis>',
    'type="revolute"><axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>',
)
"""Links of a camera on a mast, with moments of inertia of a grain, and their joints: fixed, endless, limited."""

PLAIN = Recipe(name="plain", chunk_size=10, boundary="none", seed=1)


@dataclass(frozen=True, kw_only=True, slots=True)
class Circle(Route):
    """Always the same speed and turn rate."""

    name: ClassVar[str] = "circle"
    period: ClassVar[float] = 0.5

    def motion(self, at: Pose) -> Motion:
        """To the left."""
        return Motion(V, W)


@dataclass(frozen=True, kw_only=True, slots=True)
class Straight(Route):
    """Always the same speed."""

    name: ClassVar[str] = "straight on"
    period: ClassVar[float] = 0.5

    def motion(self, at: Pose) -> Motion:
        """Straight on."""
        return Motion(V, 0)


@pytest.fixture
def robots(tmp_path: Path) -> Mapping[str, SdfRobot]:
    """The same robot with every drive, by its wheels, whose axes point to the right, in URDF, and as makers ship it."""
    found = {}
    for name, plugin in PLUGINS.items():
        file = tmp_path / f"{name}.sdf"
        file.write_text(two_wheels(plugin, axis=1 if plugin else -1))
        found[name] = from_file(file)
    file = tmp_path / "nested.sdf"
    file.write_text(in_a_nested_model(two_wheels().replace('version="1.6"', 'version="1.8"')))
    found["nested"] = from_file(file)
    file = tmp_path / "mine.urdf"
    file.write_text(two_wheels_urdf())
    mujoco = from_file(
        two_wheels_mjcf(tmp_path, more=WHISKER, wheels=WHEELS.replace("<joint ", '<joint damping="0.3" '))
    )
    makers = from_file(makers_robot(tmp_path / "workspace"))
    return {**found, "urdf": from_file(file), "mujoco": mujoco, "makers": makers}


def test_any_drive_goes_ahead_and_left_as_commanded_without_errors(
    gazebo: Installation, robots: Mapping[str, SdfRobot], tmp_path: Path
) -> None:
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(PLAIN), ()))))
    runs = [
        RobotRun(name=name, robot=robot, start=Pose(x=0, y=lane - 2.5, z=0.001), route=Circle)
        for lane, (name, robot) in enumerate(robots.items())
    ]
    recording = record_drive(gazebo, world, runs, 3, contacts=False)
    assert list(recording.errors) == []
    for run in runs:
        rows = recording.trajectories[run.name].rows
        late, early = rows[-1], rows[int(1 / 0.05)]
        seconds = late[0] - early[0]
        assert late[6] - early[6] == pytest.approx(W * seconds, rel=0.1), run.name
        chord = 2 * V / W * sin(W * seconds / 2)
        assert hypot(late[1] - early[1], late[2] - early[2]) == pytest.approx(chord, rel=0.1), run.name
        assert late[3] == pytest.approx(run.robot.lift, abs=0.003), run.name


def test_tracks_that_the_user_names_drive_as_commanded_and_flippers_keep_their_angles(
    gazebo_classic: Installation, tmp_path: Path
) -> None:
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(PLAIN), ()))))
    (tmp_path / "tracked.sdf").write_text(tracked())
    robot = from_file(tmp_path / "tracked.sdf", tracks="left+left_flipper,right+right_flipper")
    run = RobotRun(name="tracked", robot=robot, start=Pose(x=0, y=0, z=0.001), route=Straight)
    recording = record_drive(gazebo_classic, world, [run], 3, contacts=False)
    assert list(recording.errors) == []
    rows = recording.trajectories["tracked"].rows
    late, early = rows[-1], rows[int(1 / 0.05)]
    assert late[1] - early[1] == pytest.approx(V * (late[0] - early[0]), rel=0.1)
    assert np.abs(rows[:, [2, 4, 5, 6]]).max() < 0.01
    # A flipper that hangs down would lift the robot; by its other joints, at their angles, it is as high as its tracks.
    assert np.abs(rows[10:, 3] - robot.lift).max() < 0.003


def test_a_camera_that_weighs_little_does_not_throw_its_robot_off(gazebo_classic: Installation, tmp_path: Path) -> None:
    """In ODE a fixed joint between bodies of very different inertia fails; such robots leapt in the first second."""
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(PLAIN), ()))))
    parts = "".join(map(CAMERA.format, ("mast", "pan", "tilt"), ("base", "mast", "pan"), (0.2, 0.3, 0.4), JOINTS))
    (tmp_path / "mine.sdf").write_text(two_wheels().replace("</model>", f"{parts}</model>"))
    run = RobotRun(name="mine", robot=from_file(tmp_path / "mine.sdf"), start=Pose(x=0, y=0, z=0.001), route=Straight)
    recording = record_drive(gazebo_classic, world, [run], 2, contacts=False)
    rows = recording.trajectories["mine"].rows
    late, early = rows[-1], rows[int(1 / 0.05)]
    assert late[1] - early[1] == pytest.approx(V * (late[0] - early[0]), rel=0.1)
    assert np.abs(rows[10:, 3] - run.robot.lift).max() < 0.003


def test_legs_stand_if_their_joints_are_held_and_fall_if_not(
    gazebo_classic: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world, file = tmp_path / "ground.world", tmp_path / "legged.urdf"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(PLAIN), ()))))
    file.write_text(legged())
    robot = from_file(file)
    with running_server(gazebo_classic, world) as server:
        monkeypatch.setenv("GAZEBO_MASTER_URI", server.environment["GAZEBO_MASTER_URI"])
        placed = rsegen.spawn(file, at=(0, 0), simulator="classic")
        with server.connect() as live:
            free = f'<sdf version="1.7">{robot.text.replace("legged", "free")}</sdf>'
            live.spawn(free, Pose(x=0, y=2, z=robot.lift + DROP_HEIGHT))
            live.step(2000)
            poses = live.poses()
    assert placed.notes[0].startswith("legged: has no wheels or tracks, so its joints are held as its model has them: ")
    assert poses["legged"].z == pytest.approx(robot.lift, abs=0.003)
    assert max(abs(poses["legged"].roll), abs(poses["legged"].pitch)) < 0.01
    assert poses["free"].z < robot.lift / 2


@pytest.mark.long(reason="a server more")
def test_the_file_of_a_robot_is_spawned_on_an_even_place_of_the_map(
    gazebo: Installation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The map is a plateau of 7 x 7 cells in a sea of steps, beside the origin and turned."""
    rows = np.random.default_rng(1).integers(0, 9, (14, 14))
    rows[5:12, 5:12] = 3
    course = Recipe(
        name="course",
        chunk_size=14,
        boundary="none",
        unit_cm=2,
        seed=1,
        obstacles=(Matrix.of(rows),),
    )
    monkeypatch.chdir(tmp_path)
    Path("mine.sdf").write_text(two_wheels())
    world = tmp_path / "ground.world"
    world.write_bytes(b"".join(sdf.utf8(sdf.world(rsegen.compose(PLAIN), ()))))
    with running_server(gazebo, world) as server:
        for name in ("GAZEBO_MASTER_URI", "GZ_PARTITION", "GZ_IP"):
            monkeypatch.setenv(name, server.environment.get(name, "http://127.0.0.1:1"))
        simulator = gazebo.simulator.name
        rsegen.spawn(course, at=(1, -2, 0, 0.5), simulator=simulator)
        placed = rsegen.spawn("mine.sdf", simulator=simulator)
        assert placed.name == "my_robot"
        with server.connect() as live:
            live.step(500)
            at = live.poses()["my_robot"]
    assert placed.at.z == pytest.approx(3 * 0.02 + 0.03 + DROP_HEIGHT)
    assert at.z == pytest.approx(3 * 0.02 + 0.03, abs=0.003)
    assert max(abs(at.roll), abs(at.pitch)) < 0.03
