"""Contract of all robots: a new file is tested here the moment it exists."""

from __future__ import annotations

from math import atan2, inf
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rsegen import Recipe
from rsegen.errors import ParameterError, UnknownName
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import BACKENDS, Tracks, Wheels
from rsegen.robots.links import Box, Cylinder, Solid, Sphere, posed
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.wire import parse_text

ROBOT = pytest.mark.parametrize("robot", ROBOTS.values(), ids=list(ROBOTS))
SIMULATOR = pytest.mark.parametrize("simulator", BACKENDS)


def parsed(robot: Robot, simulator: str = "classic") -> ElementTree.Element:
    return ElementTree.fromstring(robot.model("one", simulator, lidar=True))  # our own


def number(element: ElementTree.Element, path: str) -> float:
    return float(element.findtext(path, "nan"))


@ROBOT
def test_masses_add_up(robot: Robot) -> None:
    masses = [number(link, "inertial/mass") for link in parsed(robot).findall("link")]
    assert all(mass > 0 for mass in masses)
    assert sum(masses) == pytest.approx(robot.mass)


@ROBOT
def test_inertias_are_physical(robot: Robot) -> None:
    for link in parsed(robot).findall("link"):
        least, middle, most = sorted(number(link, f"inertial/inertia/{axis}") for axis in ("ixx", "iyy", "izz"))
        assert least > 0
        assert most <= least + middle + 1e-9, link.get("name")


@ROBOT
def test_every_collision_has_friction(robot: Robot) -> None:
    collisions = list(parsed(robot).iter("collision"))
    assert collisions
    for collision in collisions:
        assert number(collision, "surface/friction/ode/mu") >= 0
        assert number(collision, "surface/friction/ode/mu2") >= 0


@ROBOT
def test_joints_join_links_in_a_tree(robot: Robot) -> None:
    names = [link.name for link in robot.links]
    assert sorted(joint.child for joint in robot.joints) == sorted(names[1:])
    assert {joint.parent for joint in robot.joints} <= set(names)


@ROBOT
@SIMULATOR
def test_plugins_belong_to_the_simulator_and_name_existing_joints(robot: Robot, simulator: str) -> None:
    model = parsed(robot, simulator)
    beginning = {"classic": "lib", "sim": "gz-sim-", "fortress": "ignition-gazebo-"}[simulator]
    names = {part.get("name") for part in (*model.findall("joint"), *model.findall("link"))}
    plugins = model.findall("plugin")
    assert plugins
    assert all(plugin.get("filename", "").startswith(beginning) for plugin in plugins)
    for tag in ("left_joint", "right_joint", "joint", "joint_name", "body", "link", "robot_base_frame"):
        assert {found.text for plugin in plugins for found in plugin.iter(tag)} <= names, tag


@ROBOT
@pytest.mark.parametrize("simulator", ["sim", "fortress"])
def test_odometry_in_gazebo_sim_names_both_its_frames(robot: Robot, simulator: str) -> None:
    plugins = parsed(robot, simulator).findall("plugin")
    (publisher,) = (each for each in plugins if each.get("name", "").endswith("::OdometryPublisher"))
    assert publisher.findtext("odom_frame") == "one/odom"
    assert publisher.findtext("odom_topic") == "/model/one/ground_truth"
    assert publisher.findtext("robot_base_frame") == robot.links[0].name


@ROBOT
@SIMULATOR
def test_commands_name_the_robot_and_its_speeds_are_bounded(robot: Robot, simulator: str) -> None:
    command = robot.command("one", robot.drive.speed, -robot.drive.turn, simulator)
    assert "/one/" in command.topic
    assert command.topic in command.shell
    assert command.text in command.shell
    fast, sharp = 1.01 * robot.drive.speed, 1.01 * robot.drive.turn
    for v, w, at_fault in ((fast, 0, "v"), (0, sharp, "w"), (float("nan"), 0, "v")):
        with pytest.raises(ParameterError, match=rf"^{at_fault}: .* is outside"):
            robot.command("one", v, w, simulator)


@pytest.mark.parametrize("simulator", ["sim", "fortress"])
def test_belts_are_commanded_as_their_plug_in_does(simulator: str) -> None:
    """Speeds and centre of a turn as in TrackedVehicle's UpdateVelocity: sides about a centre to the left."""
    drive = ROBOTS["crawler"].drive
    assert isinstance(drive, Tracks)
    at, angles = np.array([1.0, 2.0, 0.3]), (0.1, -0.2, 2.5)

    def told(v: float, w: float) -> tuple[dict[str, float], set[tuple[float, ...]]]:
        commands = list(drive.belt_commands("one", v, w, posed((*at, *angles)), simulator))
        values = {command.topic: parse_text(command.text) for command in commands}
        assert {command.type.rpartition(".")[0] for command in commands} == {
            {"sim": "gz.msgs", "fortress": "ignition.msgs"}[simulator]
        }
        speeds, centres = dict[str, float](), set[tuple[float, ...]]()
        for topic, value in values.items():
            belt, kind = topic.removeprefix("/model/one/link/").split("/")
            if kind == "track_cmd_vel":
                speeds[belt] = float(value["data"])
            else:
                assert kind == "track_cmd_center_of_rotation"
                centres.add(tuple(float(value[axis]) for axis in "xyz"))
        assert len(values) == 2 * len(speeds)
        return speeds, centres

    to_left = Rotation.from_euler("xyz", angles).apply([0, 1, 0])
    speeds, (centre,) = told(0.3, -0.5)
    aside = -0.5 * drive.separation / 2 / drive.efficiency
    assert speeds == {
        **dict.fromkeys(drive.left, pytest.approx(0.3 - aside)),
        **dict.fromkeys(drive.right, pytest.approx(0.3 + aside)),
    }
    assert centre == pytest.approx(at + 0.3 / -0.5 * to_left)
    _, (centre,) = told(0.0, 0.5)
    assert centre == pytest.approx(at)
    speeds, (centre,) = told(0.3, 0.0)
    assert (set(speeds.values()), centre) == ({0.3}, (inf,) * 3)


@pytest.mark.parametrize(("slip", "spread"), [(1.0, 1.0), (1.5, 1.0), (1.0, 1.25)])
def test_a_command_to_classic_turns_a_robot_of_wheels_at_the_rate_that_is_asked_for(slip: float, spread: float) -> None:
    """Its DiffDrive has the wheels at their joints, and a robot that slips turns like one of wider set wheels."""
    drive = Wheels(left=("l",), right=("r",), separation=0.3, radius=0.05, speed=1, turn=2, slip=slip, spread=spread)
    told: Any = parse_text(drive.classic_command("one", 0.2, -1.2).text)
    yaw = 2 * atan2(float(told["orientation"]["z"]), float(told["orientation"]["w"]))
    difference = yaw * drive.separation * spread  # of the speeds of the wheels
    assert difference / (drive.separation * slip) == pytest.approx(-1.2)
    assert float(told["position"]["x"]) == 0.2


@pytest.mark.parametrize("solid", [Box(size=(0.3, 0.2, 0.5)), Cylinder(radius=0.2, length=0.7), Sphere(radius=0.4)])
def test_moments_of_a_solid_are_those_of_its_points(solid: Solid) -> None:
    points = np.moveaxis(np.indices((100,) * 3), 0, -1).reshape(-1, 3) / 100 - 0.495
    x, y, z = points.T
    if isinstance(solid, Box):
        is_inside = (abs(points) < np.array(solid.size) / 2).all(axis=1)
    elif isinstance(solid, Cylinder):
        is_inside = (np.hypot(x, y) < solid.radius) & (abs(z) < solid.length / 2)
    else:
        is_inside = np.linalg.norm(points, axis=1) < solid.radius
    squares = (points[is_inside] ** 2).mean(axis=0)
    assert solid.moments(3.0) == pytest.approx(3.0 * (squares.sum() - squares), rel=0.01)


@ROBOT
def test_output_is_the_same_every_time(robot: Robot) -> None:
    assert robot.file("one") == robot.file("one")


@ROBOT
def test_wrong_words_are_refused_in_one_line(robot: Robot) -> None:
    with pytest.raises(UnknownName, match="unknown simulator 'clasic'; did you mean 'classic'"):
        robot.model("one", "clasic")
    with pytest.raises(ParameterError, match="name: "):
        robot.model("one/two")
    with pytest.raises(UnknownName, match="joint with a motor"):
        robot.holding({"nose": 1})


@ROBOT
@pytest.mark.parametrize("name", ["a..b", "1st-course", "_x"])
def test_a_name_that_a_recipe_takes_is_taken_for_a_robot_too(robot: Robot, name: str) -> None:
    assert Recipe(name=name).name == name
    assert f'<model name="{name}">' in robot.file(name, "sim")
    assert name in robot.command(name, 0.1, 0.0, "sim").topic


def test_an_unknown_robot_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownName, match=r"did you mean 'burger'.*burger, crawler, jackal"):
        robot_of_kind("burgr")


def test_a_burger_s_wheels_gather_speed_in_gazebo_sim() -> None:
    """Straight on as fast as on the spot: 1 m/s^2 at the wheels."""
    plugin = next(
        each for each in parsed(robot_of_kind("burger"), "sim").iter("plugin") if "DiffDrive" in each.get("name", "")
    )
    assert number(plugin, "max_linear_acceleration") == -number(plugin, "min_linear_acceleration") == 1
    assert number(plugin, "max_angular_acceleration") * 0.16 / 2 == pytest.approx(1)
    assert "acceleration" not in robot_of_kind("burger").model("one", "classic")


def test_a_robot_that_would_have_to_climb_onto_the_ground_is_refused() -> None:
    with pytest.raises(ParameterError, match="crossable_by: burger starts on the floor, 3 units below"):
        Recipe(ground_level=3, crossable_by="burger")
