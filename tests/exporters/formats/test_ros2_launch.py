"""The launch files of a ROS 2 package, run with stand-ins for ROS's modules, which write down what they are asked."""

from __future__ import annotations

import runpy
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
import yaml

import rsegen
from rsegen import Recipe, compose, load
from rsegen.exporters.formats.ros2 import Ros2
from rsegen.io.input_files import JOURNAL
from tests.exporters.formats.maps import RECIPES
from tests.exporters.formats.maps import made as made_files
from tests.exporters.formats.test_ros2 import NAMED, written
from tests.support.runs import contents


class Stand:
    """In place of any class of ROS's launch: what it was made of."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, {name: _plain(value) for name, value in named.items()}

    def perform(self, given: Mapping[str, str]) -> str:
        """The value of a launch argument."""
        return given[self.arguments[0]]


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, type({}.items())) else value


def _is_true(given: Mapping[str, str], expression: Sequence[Stand]) -> bool:
    return {"true": True, "1": True, "false": False, "0": False}[expression[0].perform(given).lower()]


MODULES: Mapping[str, Sequence[str]] = {
    "launch": ["LaunchDescription"],
    "launch.actions": [
        *("DeclareLaunchArgument", "IncludeLaunchDescription", "LogInfo", "OpaqueFunction", "SetEnvironmentVariable")
    ],
    "launch.conditions": ["IfCondition", "evaluate_condition_expression"],
    "launch.launch_description_sources": ["PythonLaunchDescriptionSource"],
    "launch.substitutions": ["EnvironmentVariable", "LaunchConfiguration"],
    "launch_ros": [],
    "launch_ros.actions": ["Node"],
    "launch_ros.parameter_descriptions": ["ParameterValue"],
    "launch_ros.substitutions": ["FindPackageShare"],
}
"""What the launch files import: each name is a class that writes down what it is asked, but these two functions."""

FUNCTIONS = {"LaunchDescription": list, "evaluate_condition_expression": _is_true}


class Launched(NamedTuple):
    """What a launch file starts with some arguments: its nodes, launch files of others, messages, variables."""

    arguments: Mapping[str, Any]
    nodes: Mapping[str, Stand]
    included: Mapping[str, Mapping[str, str]]
    said: Sequence[str]
    variables: Mapping[str, str]


Launch = Callable[..., Launched]


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch) -> Launch:
    """Runs a launch file with arguments."""
    for name, members in MODULES.items():
        module = ModuleType(name)
        for member in members:
            setattr(module, member, FUNCTIONS.get(member) or type(member, (Stand,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    return launched


def launched(file: Path, **given: str) -> Launched:
    found = list(runpy.run_path(str(file))["generate_launch_description"]())
    declared = {one.arguments[0]: one.named for one in found if type(one).__name__ == "DeclareLaunchArgument"}
    arguments = {name: named["default_value"] for name, named in declared.items()} | given
    for one in [one for one in found if type(one).__name__ == "OpaqueFunction"]:
        found += one.named["function"](arguments)
    kinds: dict[str, list[Stand]] = {}
    for one in found:
        kinds.setdefault(type(one).__name__, []).append(one)
    return Launched(
        declared,
        {one.named["executable"]: one for one in kinds.get("Node", ())},
        {_path(one.arguments[0]): one.named["launch_arguments"] for one in kinds.get("IncludeLaunchDescription", ())},
        [one.named["msg"] for one in kinds.get("LogInfo", ())],
        {one.arguments[0]: one.arguments[1].named["default_value"] for one in kinds.get("SetEnvironmentVariable", ())},
    )


def _path(source: Stand) -> str:
    """The place of an included launch file: its path, or PACKAGE/launch/FILE."""
    (place,) = source.arguments
    return place if isinstance(place, str) else place[0].arguments[0] + place[1]


SIM = "ros_gz_sim/launch/gz_sim.launch.py"
SERVER, CLIENT = (f"gazebo_ros/launch/{name}.launch.py" for name in ("gzserver", "gzclient"))


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The folder of a package, whose path has a space in it."""
    return written(NAMED, tmp_path / "my workspace")


@pytest.mark.parametrize(
    ("given", "options"),
    [
        ({}, "-r"),
        ({"paused": "true"}, ""),
        ({"headless": "True"}, "-s --headless-rendering -r"),
        ({"paused": "true", "verbose": "true"}, "-v 4"),
        ({"options": "-s", "headless": "false"}, "-s"),
        ({"options": "-r -s", "paused": "true"}, "-r -s"),
    ],
)
def test_gazebo_sim_is_launched_with_the_world_and_options(
    package: Path, launch: Launch, given: dict[str, str], options: str
) -> None:
    found = launch(package / "launch" / "gazebo_sim.launch.py", **given)
    arguments = found.included[SIM]
    assert arguments["gz_args"] == f"{options} '{package}/worlds/{NAMED.name}.world'"
    assert arguments["on_exit_shutdown"] == "true"


@pytest.mark.parametrize(("distribution", "messages"), [("humble", "ignition.msgs"), ("jazzy", "gz.msgs")])
def test_the_clock_of_gazebo_sim_is_bridged_by_the_type_of_its_version(
    package: Path, launch: Launch, monkeypatch: pytest.MonkeyPatch, distribution: str, messages: str
) -> None:
    monkeypatch.setenv("ROS_DISTRO", distribution)
    bridge = launch(package / "launch" / "gazebo_sim.launch.py").nodes["parameter_bridge"]
    assert bridge.named["package"] == "ros_gz_bridge"
    assert bridge.named["arguments"] == [f"/clock@rosgraph_msgs/msg/Clock[{messages}.Clock"]


def test_each_gazebo_sim_finds_a_server_configuration_with_the_names_of_its_version(
    package: Path, launch: Launch
) -> None:
    variables = launch(package / "launch" / "gazebo_sim.launch.py").variables
    names = ("Physics", "UserCommands", "SceneBroadcaster", "Sensors", "Imu", "Contact")
    parts = ("physics", "user-commands", "scene-broadcaster", "sensors", "imu", "contact")
    for variable, library, namespace in (
        ("IGN_GAZEBO_SERVER_CONFIG_PATH", "ignition-gazebo", "ignition::gazebo"),
        ("GZ_SIM_SERVER_CONFIG_PATH", "gz-sim", "gz::sim"),
    ):
        plugins = list(ET.parse(variables[variable]).getroot().iter("plugin"))
        assert [one.get("name") for one in plugins] == [f"{namespace}::systems::{name}" for name in names]
        assert [one.get("filename") for one in plugins] == [f"{library}-{part}-system" for part in parts]
        assert {(one.get("entity_name"), one.get("entity_type")) for one in plugins} == {("*", "world")}
    world = (package / "worlds" / f"{NAMED.name}.world").read_text()
    assert "<plugin" not in world  # one would keep the server from reading its configuration


@pytest.mark.parametrize(
    ("given", "pause", "windows"),
    [({}, "false", 1), ({"paused": "True"}, "true", 1), ({"headless": "true"}, "false", 0), ({"gui": "0"}, "false", 0)],
)
def test_gazebo_classic_is_launched_with_the_world_and_a_window(
    package: Path, launch: Launch, given: dict[str, str], pause: str, windows: int
) -> None:
    included = launch(package / "launch" / "gazebo_classic.launch.py", **given).included
    assert included[SERVER]["world"] == str(package / "worlds" / f"{NAMED.name}.world")
    assert included[SERVER]["pause"] == pause
    assert [name for name in included if name == CLIENT] == [CLIENT] * windows


@pytest.mark.parametrize(
    ("simulator", "command"),
    [("sim", ("ros_gz_sim", "create", "-name")), ("classic", ("gazebo_ros", "spawn_entity.py", "-entity"))],
)
def test_a_robot_is_spawned_west_of_the_map_or_at_a_given_place(
    package: Path, launch: Launch, simulator: str, command: tuple[str, str, str]
) -> None:
    file, (name, executable, named) = package / "launch" / "spawn_robot.launch.py", command
    west = -NAMED.field.extent[0] / 2 - 1
    node = launch(file, simulator=simulator, robot_topic="robot_description").nodes[executable]
    assert node.named["package"] == name
    place = ["-x", str(west), "-y", "0.0", "-z", "0.1", "-Y", "0.0"]
    assert node.named["arguments"] == [named, "robot", "-topic", "robot_description", *place]
    given = {"robot_file": str(file), "robot_name": "r2", "x": "-3", "yaw": "1.5"}
    node = launch(file, simulator=simulator, **given).nodes[executable]
    place = ["-x", "-3", "-y", "0.0", "-z", "0.1", "-Y", "1.5"]
    assert node.named["arguments"] == [named, "r2", "-file", str(file), *place]


def test_no_robot_is_spawned_unless_one_is_named_and_its_file_is_there(package: Path, launch: Launch) -> None:
    file = package / "launch" / "spawn_robot.launch.py"
    found = launch(file)
    assert not found.nodes
    assert found.said == ["No robot is spawned: robot_file and robot_topic are empty."]
    with pytest.raises(RuntimeError, match=r"robot_file: .*/none\.sdf is not a file"):
        launch(file, robot_file=str(package / "none.sdf"))


def test_the_map_server_is_activated_by_a_lifecycle_manager(package: Path, launch: Launch) -> None:
    nodes = launch(package / "launch" / "map_server.launch.py").nodes
    (grid,) = nodes["map_server"].named["parameters"]
    assert grid["yaml_filename"] == str(package / "maps" / NAMED.name / "map.yaml")
    (manager,) = nodes["lifecycle_manager"].named["parameters"]
    assert manager["autostart"] is True
    assert manager["node_names"] == [nodes["map_server"].named["name"]]


def test_rviz_shows_the_urdf_of_the_map_whose_meshes_are_in_the_package(package: Path, launch: Launch) -> None:
    nodes = launch(package / "launch" / "rviz.launch.py").nodes
    (parameters,) = nodes["robot_state_publisher"].named["parameters"]
    robot = ET.fromstring(parameters["robot_description"].arguments[0])
    meshes = [mesh.get("filename", "") for mesh in robot.iter("mesh")]
    assert meshes
    for mesh in meshes:
        assert (package / mesh.removeprefix(f"package://{package.name}/")).is_file()
    link = robot.find("link")
    assert link is not None
    place = ["--frame-id", "map", "--child-frame-id", link.get("name")]
    assert nodes["static_transform_publisher"].named["arguments"] == place
    (_, shown) = nodes["rviz2"].named["arguments"]
    displays = yaml.safe_load(Path(shown).read_text())["Visualization Manager"]["Displays"]
    namespace = nodes["robot_state_publisher"].named["namespace"]
    assert displays[0]["Description Topic"]["Value"] == f"/{namespace}/robot_description"


def test_maps_that_are_joined_are_one_package_in_which_map_chooses(tmp_path: Path, launch: Launch) -> None:
    recipe = Recipe(seed=3, chunk_size=2, maps=3, obstacles=RECIPES["one block"].obstacles)
    made = rsegen.export_maps([recipe], tmp_path / "src", [Ros2(package="fields")])
    package = tmp_path / "src" / "fields"
    names = [recipe.map_name(index) for index in recipe.indices]
    assert [one.folder for one in made] == [package] * 3
    assert sorted(name for one in made for name in one.names) == sorted(contents(package).keys() - {JOURNAL})
    assert [load(package / "recipes" / f"{name}.json") for name in names] == [*map(recipe.alone, recipe.indices)]
    file = package / "launch" / "gazebo_sim.launch.py"
    choice = launch(file).arguments["map"]
    assert (choice["default_value"], choice["choices"]) == (names[0], names)
    for index, name in enumerate(names):
        arguments = launch(file, map=name).included[SIM]
        assert arguments["gz_args"].endswith(f"/{name}.world")
        for path, content in made_files(Ros2(package="fields"), compose(recipe, index)).items():
            assert (package.parent / path).read_bytes() == content, path
