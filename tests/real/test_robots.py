"""Every robot in each real Gazebo: it goes, turns, stands and climbs as its figures say, but for tracks in Sim."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from math import pi
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import BACKENDS, Tracks
from rsegen.simulators.base import Installation
from rsegen.simulators.gazebo_classic import ClassicWorld
from rsegen.simulators.poses import Pose
from rsegen.simulators.server import attempted
from rsegen.simulators.wire import pose_of
from tests.real.courses import Course, driven, served, stair
from tests.real.test_sdformat import said
from tests.support.long import long_unless

A_COURSE_MORE = pytest.mark.long(reason="a server and a course more")
A_ROBOT_MORE = pytest.mark.parametrize(
    "robot", long_unless(ROBOTS["burger"].__eq__, ROBOTS.values(), reason="a server more"), ids=list(ROBOTS)
)
TILT = 0.02
"""Radians: more is not level."""


@A_ROBOT_MORE
@pytest.mark.parametrize("simulator", BACKENDS)
def test_libsdformat_finds_nothing_against_it(
    robot: Robot, simulator: str, check_sdf: Callable[[Path], str], tmp_path: Path
) -> None:
    file = tmp_path / "robot.sdf"
    file.write_text(robot.file("one", simulator, lidar=True))
    assert said(check_sdf(file)) == ["Valid."]


@A_ROBOT_MORE
def test_it_goes_straight_turns_and_stands(robot: Robot, gazebo: Installation, tmp_path: Path) -> None:
    if isinstance(robot.drive, Tracks) and gazebo.backend != "classic":
        pytest.skip(f"tracks in {gazebo}: they have a test of their own")
    v, w = robot.drive.speed / 2, robot.drive.turn / 4
    course = Course(robots={"goes": robot, "turns": robot, "stands": robot})
    commands = {"goes": (v, 0.0), "turns": (0.0, w)}
    early, late = driven(gazebo, tmp_path, course, commands, (1000, 1000))

    assert late["goes"].x - early["goes"].x == pytest.approx(v, rel=0.01)
    assert abs(late["goes"].yaw) < 0.005
    assert (late["turns"].yaw - early["turns"].yaw) % (2 * pi) == pytest.approx(w, rel=0.1)
    assert off(early["turns"], late["turns"]) < 0.01
    assert off(early["stands"], late["stands"]) < 0.0002
    assert abs(late["stands"].yaw - early["stands"].yaw) < 0.001
    assert all(level(pose, 0) for pose in late.values() if pose != late["turns"])


def test_tracks_go_as_commanded_in_sim_or_stand(gazebo_sim: Installation, tmp_path: Path) -> None:
    """DART 6.13 gives tracks the speed of their surface; with an earlier one, as Debian 12's, they do not move."""
    course = Course(robots={"one": ROBOTS["crawler"]})
    (end,) = driven(gazebo_sim, tmp_path, course, {"one": (0.5, 0.0)}, (2000,))
    stands = off(Pose(x=0, y=0, z=0), end["one"]) < 0.0002
    assert stands or end["one"].x == pytest.approx(1.0, rel=0.05)
    assert level(end["one"], 0)
    (robot,) = (result := rsegen.drive(rsegen.Recipe(seed=1), robot="crawler", duration=2, simulator="sim")).robots
    assert any("tracks need the physics engine DART 6.13" in note for note in result.notes) == stands
    assert (robot.metrics.distance < 0.001) == stands


def test_a_drive_on_tracks_repeats_in_sim_on_a_busy_machine(gazebo_sim: Installation) -> None:
    """Belts get their speeds at once; by their plug-in they would get them while the world steps, sooner or later."""
    recipe = rsegen.Recipe(seed=7, unit_cm=3, boundary="none", obstacles=[rsegen.Noise(levels=3)])

    def path() -> np.ndarray:
        drive = rsegen.drive(recipe, robot="crawler", duration=3, simulator="sim", predict=False, contacts=False)
        return np.asarray(drive.robots[0].trajectory.rows)

    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * (os.cpu_count() or 1))]
    try:
        paths = [path() for _ in range(4)]
    finally:
        for program in busy:
            program.kill()
            program.wait()
    first, *others = paths
    if np.ptp(first[:, 1]) < 0.001:
        pytest.skip(f"tracks stand in {gazebo_sim}: their motion needs DART 6.13")
    assert np.ptp(first[:, 1]) > 0.5
    assert [np.array_equal(first, other) for other in others] == [True] * len(others)


@pytest.mark.long(reason="a server and a course more")
@pytest.mark.parametrize(("v", "w"), [(0.3, 0.4), (0.0, 0.5)])
def test_belts_that_are_commanded_one_by_one_go_where_their_plug_in_would_take_them(
    v: float, w: float, gazebo_sim: Installation, tmp_path: Path
) -> None:
    crawler = ROBOTS["crawler"]
    with served(gazebo_sim, Course(robots={"plugin": crawler, "belts": crawler}), tmp_path) as (_, live):
        live.step(500)
        begun = live.poses()
        live.send_command(crawler.command("plugin", v, w, live.backend))
        live.drive("belts", crawler, v, w)
        live.step(1000)
        done = live.poses()
    if off(begun["plugin"], done["plugin"]) < 0.0002 and abs(done["plugin"].yaw) < 0.001:
        pytest.skip(f"tracks stand in {gazebo_sim}: their motion needs DART 6.13")
    moved = [
        (done[name].x - begun[name].x, done[name].y - begun[name].y, done[name].yaw - begun[name].yaw)
        for name in ("plugin", "belts")
    ]
    assert abs(moved[0][2]) > 0.2
    assert moved[0] == pytest.approx(moved[1], abs=0.01)


def test_wheels_stop_on_command(gazebo: Installation, tmp_path: Path) -> None:
    course = Course(robots={"one": ROBOTS["burger"]})
    _, early, late = driven(gazebo, tmp_path, course, {"one": (0.22, 0.0)}, (500, 500, 1000), stop_after=1)
    assert off(early["one"], late["one"]) < 0.0002


@pytest.mark.parametrize(
    ("kind", "heights", "climbed"),
    [
        ("burger", [0.010], True),
        pytest.param("burger", [0.020], False, marks=A_COURSE_MORE),
        pytest.param("jackal", [0.050], True, marks=A_COURSE_MORE),
        ("jackal", [0.110], False),
        pytest.param("crawler", [0.100, 0.200], True, marks=A_COURSE_MORE),
        pytest.param("crawler", [0.400], False, marks=A_COURSE_MORE),
    ],
)
def test_a_robot_climbs_its_rated_step_and_no_higher_one_in_classic(
    kind: str, heights: Sequence[float], climbed: bool, gazebo_classic: Installation, tmp_path: Path
) -> None:
    robot = ROBOTS[kind]
    end = climbing(robot, heights, gazebo_classic, tmp_path)
    assert level(end, sum(heights)) == climbed
    assert climbed == (max(heights) <= robot.climbs)


@pytest.mark.parametrize(
    ("kind", "height", "climbed"),
    [("burger", 0.003, True), ("burger", 0.010, False), ("jackal", 0.030, True), ("jackal", 0.050, False)],
)
def test_wheels_climb_less_in_sim(
    kind: str, height: float, climbed: bool, gazebo_sim: Installation, tmp_path: Path
) -> None:
    """A step of 5 cm stops a Jackal at its front wheels, and a step of 1 cm a Burger at its caster of 5 mm radius."""
    assert level(climbing(ROBOTS[kind], [height], gazebo_sim, tmp_path), height) == climbed


def test_motors_turn_the_chassis_the_other_way_but_not_in_classic(gazebo: Installation, tmp_path: Path) -> None:
    """Afloat, nothing else turns it: where motors act back, wheels that spin up lift its nose."""
    course = Course(robots={"one": ROBOTS["burger"]}, afloat=1.0)
    (end,) = driven(gazebo, tmp_path, course, {"one": (0.22, 0.0)}, (200,))
    assert end["one"].z == pytest.approx(1.0, abs=0.1)
    assert end["one"].pitch == pytest.approx(0, abs=1e-6) if gazebo.backend == "classic" else end["one"].pitch < -0.1


@pytest.mark.long(reason="a server more")
def test_flippers_and_arm_reach_the_commanded_angles(gazebo_classic: Installation, tmp_path: Path) -> None:
    angles = {"left_flipper_pivot": 0.6, "right_flipper_pivot": 0.9, "shoulder_joint": 0.8}
    course = Course(robots={"one": ROBOTS["crawler"].holding({"right_flipper_pivot": 0.9})})

    def moved() -> Mapping[str, Pose]:
        with served(gazebo_classic, course, tmp_path) as (server, live):
            for joint in ("left_flipper_pivot", "shoulder_joint"):
                name, *words = ROBOTS["crawler"].servo_command("one", joint, angles[joint]).shell
                command = [str(gazebo_classic.commands[name]), *words]
                subprocess.run(command, env=os.environ | dict(server.environment), timeout=60, check=True)
            live.step(2000)
            assert isinstance(live, ClassicWorld)
            links = (link for model in live._models().values() for link in model.get("link", []))
            return {link["name"]: pose_of(link["pose"]) for link in links}

    links = attempted(moved)[0]
    turned = {
        "left_flipper_pivot": "left_flipper",
        "right_flipper_pivot": "right_flipper",
        "shoulder_joint": "shoulder",
    }
    assert {joint: -links[f"one::{link}"].pitch for joint, link in turned.items()} == pytest.approx(angles, abs=0.05)


def climbing(robot: Robot, heights: Sequence[float], gazebo: Installation, folder: Path) -> Pose:
    """Place of it after 1.2 m at an easy speed, with a stair 0.2 m before its front."""
    course = Course(robots={"one": robot}, stair=stair(0.2 + robot.size[0], heights))
    v = min(robot.drive.speed, 0.3)
    steps = int(1000 * (1.2 + 2 * robot.size[0]) / v)
    (end,) = driven(gazebo, folder, course, {"one": (v, 0.0)}, (steps,))
    return end["one"]


def off(early: Pose, late: Pose) -> float:
    return max(abs(late.x - early.x), abs(late.y - early.y), abs(late.z - early.z))


def level(pose: Pose, height: float) -> bool:
    return abs(pose.z - height) < 0.002 and abs(pose.pitch) < TILT and abs(pose.roll) < TILT
