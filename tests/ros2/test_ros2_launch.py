"""The launch files of a ROS 2 package, run with stand-ins for ROS's modules, which write down what they are asked."""

from __future__ import annotations

import ast
import json
import re
import runpy
import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, NamedTuple

import pytest
import yaml

import rsegen
from rsegen import Recipe, compose, load
from rsegen.input_files import JOURNAL
from rsegen.ros2 import package as of_packages
from rsegen.ros2.configuration import NAMESPACE, ROBOT
from rsegen.ros2.package import PYTHON
from rsegen.ros2.ros2 import Ros2
from tests.formats.maps import RECIPES
from tests.formats.maps import made as made_files
from tests.ros2.test_robot_files import leaves
from tests.ros2.test_ros2 import NAMED, written
from tests.support.runs import contents

FILES = Path(of_packages.__file__).with_name("package_files")

Context = dict[str, str]
"""Values of launch arguments."""


class Stand:
    """In place of any class of ROS's launch: what it was made of."""

    keywords: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, *arguments: Any, **named: Any) -> None:
        assert named.keys() <= self.keywords, f"{type(self).__name__} of Humble or of Jazzy has no such keyword"
        self.arguments, self.named = arguments, {name: _plain(value) for name, value in named.items()}


class Configuration(Stand):
    def perform(self, context: Context) -> str:
        """Return the value of a launch argument; a KeyError if it is not declared yet."""
        return context[self.arguments[0]]


class Argument(Stand):
    keywords = frozenset({"default_value", "description", "choices"})

    def execute(self, context: Context) -> list[Stand]:
        """Set the default if no value is given, as launch does; a RuntimeError if it is none of the choices."""
        value = context.setdefault(self.arguments[0], self.named["default_value"])
        if value not in self.named.get("choices", [value]):
            raise RuntimeError(f'Argument "{self.arguments[0]}" provided value "{value}" is not valid')
        return []


class Function(Stand):
    keywords = frozenset({"function"})

    def execute(self, context: Context) -> list[Stand]:
        """Return the function's entities, which are not executed."""
        return self.named["function"](context) or []


class Source(Stand):
    def get_launch_description(self, context: Context) -> Description:
        """Return the entities of a launch file."""
        (path,) = self.arguments
        return Description(runpy.run_path(path)["generate_launch_description"]())


class XacroCommand(Stand):
    keywords = frozenset({"on_stderr"})

    def perform(self, context: Context) -> str:
        """Return what stands for the command's output; by default launch fails at what it says on standard error."""
        assert self.named["on_stderr"] == "warn"  # xacro's warnings are there
        (command,) = self.arguments
        return f"output of {''.join(command)}"


class ANode(Stand):
    keywords = frozenset(
        {"package", "executable", "name", "namespace", "arguments", "parameters", "condition", "output"}
    )

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        assert "executable" in named  # launch_ros has no default for it
        for values in named.get("parameters", []):
            for value in values.values() if isinstance(values, dict) else ():
                # launch_ros reads text as YAML: that of a path may be cut off at " #".
                assert not isinstance(value, str) or yaml.safe_load(value) == value, value


class Description(list[Stand]):
    """In place of LaunchDescription."""

    @property
    def entities(self) -> Sequence[Stand]:
        return self


def stand(*keywords: str) -> type[Stand]:
    """Return a class that takes these keywords."""
    return type("Stand", (Stand,), {"keywords": frozenset(keywords)})


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, type({}.items())) else value


def _is_true(context: Context, expression: Sequence[Configuration]) -> bool:
    text = expression[0].perform(context)
    try:
        return {"true": True, "1": True, "false": False, "0": False}[text.lower()]
    except KeyError:
        raise RuntimeError(f"invalid condition expression, got '{text}'") from None


MODULES: Mapping[str, Mapping[str, Any]] = {
    "launch": {"LaunchDescription": Description},
    "launch.actions": {
        "AppendEnvironmentVariable": stand("prepend", "separator"),
        "DeclareLaunchArgument": Argument,
        "IncludeLaunchDescription": stand("launch_arguments", "condition"),
        "LogInfo": stand("msg"),
        "OpaqueFunction": Function,
        "SetEnvironmentVariable": stand(),
    },
    "launch.conditions": {"IfCondition": stand(), "evaluate_condition_expression": _is_true},
    "launch.launch_description_sources": {"PythonLaunchDescriptionSource": Source},
    "launch.substitutions": {
        "Command": XacroCommand,
        "EnvironmentVariable": stand("default_value"),
        "LaunchConfiguration": Configuration,
    },
    "launch_ros": {},
    "launch_ros.actions": {"Node": ANode},
    "launch_ros.parameter_descriptions": {"ParameterValue": stand("value_type")},
    "launch_ros.substitutions": {"FindPackageShare": stand()},
}
"""Imports of the launch files, and what stands for them; keywords are those that both Humble and Jazzy take."""


class Launched(NamedTuple):
    """Outcome of a launch file with some arguments: its nodes, launch files of others, messages, variables.

    Nodes are known by their names, or by their programs if they keep their own names. `first` has the folders that are
    put at the beginning of variables.
    """

    arguments: Mapping[str, Any]
    nodes: Mapping[str, Stand]
    included: Mapping[str, Mapping[str, str]]
    said: Sequence[str]
    variables: Mapping[str, str]
    first: Mapping[str, str]


class Launch:
    """Runs launch files with arguments, entity by entity, as launch does; `started` is what began, until an error."""

    def __init__(self) -> None:
        self.started: list[Stand] = []

    def __call__(self, file: Path, **given: str) -> Launched:
        self.started = []
        context, entities = dict(given), runpy.run_path(str(file))["generate_launch_description"]()
        for entity in entities:
            done = entity.execute(context) if isinstance(entity, Argument | Function) else [entity]
            self.started += [one for one in done if _is_run(one, context)]
        declared = {one.arguments[0]: one.named for one in entities if isinstance(one, Argument)}
        return Launched(
            declared,
            {one.named.get("name") or one.named["executable"]: one for one in self._of("launch_ros.actions", "Node")},
            {
                _path(one.arguments[0]): one.named["launch_arguments"]
                for one in self._of("launch.actions", "IncludeLaunchDescription")
            },
            [one.named["msg"] for one in self._of("launch.actions", "LogInfo")],
            {
                one.arguments[0]: one.arguments[1].named["default_value"]
                for one in self._of("launch.actions", "SetEnvironmentVariable")
            },
            {
                one.arguments[0]: one.arguments[1]
                for one in self._of("launch.actions", "AppendEnvironmentVariable")
                if one.named["prepend"]
            },
        )

    def _of(self, module: str, name: str) -> list[Stand]:
        return [one for one in self.started if isinstance(one, MODULES[module][name])]


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch) -> Launch:
    """Stand-ins for ROS's modules, and what runs a launch file with them."""
    for name, members in MODULES.items():
        module = ModuleType(name)
        for member, stands in members.items():
            setattr(module, member, stands)
        monkeypatch.setitem(sys.modules, name, module)
    return Launch()


def _is_run(one: Stand, context: Context) -> bool:
    """Return whether the condition of a node or launch file, if any, is met."""
    condition = one.named.get("condition")
    return condition is None or _is_true(context, condition.arguments)


def _path(source: Stand) -> str:
    """The place of an included launch file: its path, or PACKAGE/launch/FILE."""
    (place,) = source.arguments
    return place if isinstance(place, str) else place[0].arguments[0] + place[1]


def text_of(value: Stand) -> str:
    """The text of a parameter that is not read as YAML."""
    assert value.named["value_type"] is str
    text: str = value.arguments[0]
    return text


SIM = "ros_gz_sim/launch/gz_sim.launch.py"
SERVER, CLIENT = (f"gazebo_ros/launch/{name}.launch.py" for name in ("gzserver", "gzclient"))


LAUNCH_FILES = [path.split("/")[1].removesuffix(".launch.py") for path in PYTHON if path.startswith("launch/")]


@pytest.mark.parametrize("path", PYTHON)
def test_a_file_of_a_package_is_the_one_in_the_sources_and_python_of_every_version(path: str, package: Path) -> None:
    source = FILES / path
    text = source.read_text("utf-8")
    assert (package / path).read_text("utf-8") == text.replace("@ROBOT@", "none")
    ast.parse(text, path, feature_version=(3, 10))  # that of Humble


def test_every_file_in_the_folder_of_sources_is_in_packages() -> None:
    assert {path.relative_to(FILES).as_posix() for path in FILES.rglob("*.py")} == set(PYTHON)


def test_launch_files_name_the_robot_and_the_map_as_bridge_and_rviz_do(package: Path) -> None:
    spawn, rviz = ((package / "launch" / f"{name}.launch.py").read_text("utf-8") for name in ("spawn_robot", "rviz"))
    assert f"spawner(simulator, '{ROBOT}', ['-file'" in spawn
    assert f"'robot_name', default_value='{ROBOT}'" in spawn
    assert f"NAMESPACE = '{NAMESPACE}'\n" in rviz


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The folder of a package, whose path has spaces in it, and what YAML takes for a comment."""
    return written(NAMED, tmp_path / "my #1 workspace")


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


def test_the_clock_of_gazebo_sim_is_bridged(package: Path, launch: Launch) -> None:
    bridge = launch(package / "launch" / "gazebo_sim.launch.py").nodes["clock_bridge"]
    assert (bridge.named["package"], bridge.named["executable"]) == ("ros_gz_bridge", "parameter_bridge")
    (parameters,) = bridge.named["parameters"]
    (topic,) = yaml.safe_load(Path(text_of(parameters["config_file"])).read_text())
    assert topic == {
        "ros_topic_name": "/clock",
        "ros_type_name": "rosgraph_msgs/msg/Clock",
        "gz_topic_name": "/clock",
        "gz_type_name": "gz.msgs.Clock",
        "direction": "GZ_TO_ROS",
    }


@pytest.mark.parametrize("wanted", ["rviz", "nav2", "elevation"])
def test_what_is_requested_is_launched_in_the_time_of_the_simulation(
    package: Path, launch: Launch, wanted: str
) -> None:
    file = package / "launch" / "gazebo_sim.launch.py"
    name = {"nav2": "navigation"}.get(wanted, wanted)
    included = launch(file, robot="jackal", **{wanted: "true"}).included
    (more,) = included.keys() - launch(file, robot="jackal").included.keys()
    assert more == str(package / "launch" / f"{name}.launch.py")
    assert included[more] == {"use_sim_time": "true"}


@pytest.mark.parametrize("name", ["rviz", "map_server", "navigation", "elevation"])
def test_without_a_simulation_nodes_use_the_time_of_the_system(package: Path, launch: Launch, name: str) -> None:
    """`use_sim_time` with nobody who publishes /clock would stop their clocks at 0."""
    assert (
        launch(package / "launch" / f"{name}.launch.py", robot="jackal").arguments["use_sim_time"]["default_value"]
        == "false"
    )


def test_each_gazebo_sim_finds_a_server_configuration_with_the_names_of_its_version(
    package: Path, launch: Launch
) -> None:
    variables = launch(package / "launch" / "gazebo_sim.launch.py").variables
    names = ["Physics", "UserCommands", "SceneBroadcaster", "Sensors", "Imu", "Contact"]
    names += ["Altimeter", "ForceTorque", "Magnetometer", "NavSat"]
    parts = ["physics", "user-commands", "scene-broadcaster", "sensors", "imu", "contact"]
    parts += ["altimeter", "forcetorque", "magnetometer", "navsat"]
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
def test_a_robot_of_a_file_or_topic_is_spawned_west_of_the_map_or_at_a_given_place(
    package: Path, launch: Launch, simulator: str, command: tuple[str, str, str]
) -> None:
    file, (name, executable, named) = package / "launch" / "spawn_robot.launch.py", command
    west = -NAMED.field.extent[0] / 2 - 1
    node = launch(file, simulator=simulator, robot_topic="robot_description").nodes[executable]
    assert node.named["package"] == name
    assert node.named["arguments"][:4] == [named, "robot", "-topic", "robot_description"]
    assert place_of(node) == {"-x": west, "-y": 0, "-z": 0.1, "-R": 0, "-P": 0, "-Y": 0}
    own = package / "my robot.sdf"
    own.write_text("<sdf/>")
    given = {"robot": str(own), "robot_name": "r2", "x": "-3", "y": "-1e-5", "yaw": "1.5"}
    found = launch(file, simulator=simulator, **given)
    node = found.nodes[executable]
    assert node.named["arguments"][:4] == [named, "r2", "-file", str(own)]
    assert place_of(node) == {"-x": -3, "-y": -1e-5, "-z": 0.1, "-R": 0, "-P": 0, "-Y": 1.5}
    assert ("robot_bridge" in found.nodes) == (simulator == "sim")
    assert found.said == [f"The robot {own} starts at the given coordinates."]


def place_of(node: Stand) -> dict[str, float]:
    """The coordinates of a spawner, as argparse in spawn_entity.py reads them: no exponents."""
    values = node.named["arguments"][4:]
    assert all(re.fullmatch(r"-?\d+\.\d+", value) for value in values[1::2])
    return {name: float(value) for name, value in zip(values[::2], values[1::2], strict=True)}


def test_a_urdf_of_the_user_is_expanded_by_xacro_and_spawned_from_its_description(
    package: Path, launch: Launch
) -> None:
    own = package / "my robot.urdf"
    own.write_text("<robot name='r'><link name='l'/></robot>")
    nodes = launch(package / "launch" / "spawn_robot.launch.py", robot=str(own), bridge="none").nodes
    (description,) = nodes["robot_state_publisher"].named["parameters"]
    assert text_of(description["robot_description"]) == f"output of xacro '{own}'"
    assert nodes["create"].named["arguments"][:4] == ["-name", "robot", "-topic", "robot_description"]
    assert "robot_bridge" not in nodes
    assert frame_of(nodes["odom_frame"])["x"] == -NAMED.field.extent[0] / 2 - 1  # its wheels count from there


def frame_of(node: Stand) -> dict[str, float]:
    """The pose of a static frame in map."""
    arguments = node.named["arguments"]
    assert arguments[-4:-1] == ["--frame-id", "map", "--child-frame-id"]
    pairs = zip(arguments[:-4:2], arguments[1:-4:2], strict=True)
    return {name.removeprefix("--"): float(value) for name, value in pairs}


@pytest.mark.parametrize("kind", ["burger", "crawler", "jackal"])
def test_a_robot_of_rsegen_is_spawned_with_its_description_bridge_and_frames(
    package: Path, launch: Launch, kind: str
) -> None:
    found = launch(package / "launch" / "spawn_robot.launch.py", robot=kind)
    folder = package / "robots" / kind
    assert found.nodes["create"].named["arguments"][:4] == ["-name", "robot", "-file", str(folder / "model.sdf")]
    assert (folder / "model.sdf").is_file()
    (bridge,) = found.nodes["robot_bridge"].named["parameters"]
    assert text_of(bridge["config_file"]) == str(folder / "bridge.yaml")
    assert bridge["use_sim_time"] is True
    (parameters,) = found.nodes["robot_state_publisher"].named["parameters"]
    assert parameters["use_sim_time"] is True
    assert parameters["robot_description"].arguments[0] == (folder / f"{kind}.urdf").read_text()
    assert set(frame_of(found.nodes["odom_frame"]).values()) == {0.0}
    assert frame_of(found.nodes["wheel_odom_frame"])["x"] == -NAMED.field.extent[0] / 2 - 1
    assert found.said == [f"The robot {kind} starts on the ground west of the map."]
    without = launch(package / "launch" / "spawn_robot.launch.py", robot=kind, localized="false")
    assert found.nodes.keys() - without.nodes.keys() == {"odom_frame"}
    without = launch(package / "launch" / "spawn_robot.launch.py", robot=kind, bridge="none")
    assert found.nodes.keys() - without.nodes.keys() == {"robot_bridge"}


WRONG = (
    ({"robot": "jackle"}, "robot: jackle is neither none"),
    ({"robot": "jackal", "x": "west"}, "x: west is not a number of metres or radians"),
    ({"robot": "jackal", "yaw": "nan"}, "yaw: nan is not a number of metres or radians"),
    ({"robot": "jackal", "bridge": "topics.yaml"}, r"bridge: .*/topics\.yaml is not a file"),
    ({"robot": "jackal", "localized": "no"}, "invalid condition expression, got 'no'"),
    ({"robot": "jackal", "start": "west"}, 'Argument "start" provided value "west" is not valid'),
    ({"robot": "jackal", "map": "peak"}, 'Argument "map" provided value "peak" is not valid'),
    ({"robot": "jackal", "paused": "yes"}, "invalid condition expression, got 'yes'"),
    ({"robot": "jackal", "elevation": "on"}, "invalid condition expression, got 'on'"),
    ({"robot": "none", "nav2": "true"}, "give robot:=burger"),
    ({"robot": "jackal", "nav2": "true", "nav2_params": "mine.yaml"}, r"nav2_params: .*/mine\.yaml is not a file"),
    ({"robot": "jackal", "nav2": "true", "z": "up"}, "z: up is not a number of metres or radians"),
)


@pytest.mark.parametrize(("given", "problem"), WRONG, ids=[" ".join(given) for given, _ in WRONG])
def test_a_wrong_argument_is_refused_before_gazebo_or_anything_else_starts(
    package: Path, launch: Launch, given: dict[str, str], problem: str
) -> None:
    """At a later error launch ends, and leaves what it has started."""
    with pytest.raises(RuntimeError, match=problem):
        launch(package / "launch" / "gazebo_sim.launch.py", **given)
    assert processes(launch) == []


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("gazebo_classic", {"paused": "yes"}),
        ("gazebo_classic", {"gui": "no"}),
        ("gazebo_classic", {"verbose": "all"}),
        ("navigation", {"robot": "jackle"}),
        ("rviz", {"rviz": "yes"}),
        ("spawn_robot", {"robot": "jackal", "localized": "no"}),
    ],
)
def test_a_wrong_argument_of_the_other_files_starts_nothing(
    package: Path, launch: Launch, name: str, given: dict[str, str]
) -> None:
    with pytest.raises(RuntimeError):
        launch(package / "launch" / f"{name}.launch.py", **given)
    assert processes(launch) == []


def test_gazebo_classic_starts_after_the_file_that_checks_the_robot(package: Path, launch: Launch) -> None:
    included = launch(package / "launch" / "gazebo_classic.launch.py").included
    assert list(included) == [str(package / "launch" / "spawn_robot.launch.py"), SERVER, CLIENT]


def processes(launch: Launch) -> list[Stand]:
    """The nodes and launch files that began."""
    names = {"launch_ros.actions": "Node", "launch.actions": "IncludeLaunchDescription"}
    kinds = tuple(MODULES[module][name] for module, name in names.items())
    return [one for one in launch.started if isinstance(one, kinds)]


def test_the_package_s_models_come_before_those_of_the_same_name_in_other_packages(
    package: Path, launch: Launch
) -> None:
    models = str(package / "models")
    first = launch(package / "launch" / "gazebo_sim.launch.py").first
    assert first == {"GZ_SIM_RESOURCE_PATH": models, "IGN_GAZEBO_RESOURCE_PATH": models}
    assert launch(package / "launch" / "gazebo_classic.launch.py").first == {"GAZEBO_MODEL_PATH": models}


@pytest.mark.parametrize("name", LAUNCH_FILES)
def test_a_link_to_a_map_that_was_removed_is_no_map(package: Path, launch: Launch, name: str) -> None:
    """`colcon build --symlink-install` leaves them in the installed package."""
    (package / "worlds" / "a_0000.world").symlink_to(package / "gone.world")
    found = launch(package / "launch" / f"{name}.launch.py", robot="none" if "gazebo" in name else "jackal")
    assert found.arguments["map"] == found.arguments["map"] | {"default_value": NAMED.name, "choices": [NAMED.name]}


def test_the_default_robot_starts_on_its_spot_unless_the_ground_is_wanted(tmp_path: Path, launch: Launch) -> None:
    scene = compose(Recipe(seed=3, chunk_size=8, boundary="none"))
    package = written(scene, tmp_path, Ros2(robot="burger"))
    file = package / "launch" / "spawn_robot.launch.py"
    spot = json.loads((package / "maps" / scene.name / "start_poses.json").read_text())["burger"]
    found = launch(file)
    assert found.said == ["The robot burger starts on its spot on the map."]
    assert frame_of(found.nodes["wheel_odom_frame"]) == spot
    assert launch(file, start="ground").said == ["The robot burger starts on the ground west of the map."]
    assert launch(file, robot="jackal").said == ["The robot jackal starts on the ground west of the map."]
    assert launch(file, robot="none").nodes == {}
    assert launch(package / "launch" / "navigation.launch.py").nodes.keys() == NAV2 | {"lifecycle_manager_navigation"}


def test_no_robot_is_spawned_unless_one_is_named_and_its_file_is_there(package: Path, launch: Launch) -> None:
    file = package / "launch" / "spawn_robot.launch.py"
    found = launch(file)
    assert not found.nodes
    assert found.said == ["No robot is spawned: give robot:=burger, crawler, jackal or a file."]
    with pytest.raises(RuntimeError, match=r"none\.sdf is neither none, burger, crawler, jackal, nor a file"):
        launch(file, robot=str(package / "none.sdf"))
    with pytest.raises(RuntimeError, match="burger drives in Gazebo Sim; give a file"):
        launch(file, robot="burger", simulator="classic")
    assert launch(package / "launch" / "gazebo_classic.launch.py").arguments["robot"]["default_value"] == "none"


NAV2 = {"planner_server", "controller_server", "behavior_server", "bt_navigator"}


@pytest.mark.parametrize(("distribution", "between"), [("humble", "/"), ("jazzy", "::")])
def test_nav2_gets_the_parameters_of_all_robots_then_those_of_one_and_the_names_of_its_plug_ins(
    package: Path, launch: Launch, monkeypatch: pytest.MonkeyPatch, distribution: str, between: str
) -> None:
    monkeypatch.setenv("ROS_DISTRO", distribution)
    found = launch(package / "launch" / "navigation.launch.py", robot="jackal")
    assert found.nodes.keys() == NAV2 | {"lifecycle_manager_navigation"}
    for name in NAV2:
        common, own, more = found.nodes[name].named["parameters"]
        assert (common, own) == (
            str(package / "config" / "nav2.yaml"),
            str(package / "robots" / "jackal" / "nav2.yaml"),
        )
        assert more["GridBased.plugin"] == f"nav2_navfn_planner{between}NavfnPlanner"
        assert more["use_sim_time"].arguments == ("use_sim_time",)
    (manager,) = found.nodes["lifecycle_manager_navigation"].named["parameters"]
    assert set(manager["node_names"]) == NAV2
    assert str(package / "launch" / "map_server.launch.py") in found.included


def test_nav2_wants_a_robot_of_rsegen_or_parameters(package: Path, launch: Launch) -> None:
    file = package / "launch" / "navigation.launch.py"
    with pytest.raises(RuntimeError, match="give robot:=burger, crawler, jackal, or nav2_params:=FILE of your robot"):
        launch(file)
    with pytest.raises(RuntimeError, match=r"nav2_params: .*/mine\.yaml is not a file"):
        launch(file, nav2_params=str(package / "mine.yaml"))
    own = package / "mine.yaml"
    own.write_text("{}")
    assert launch(file, nav2_params=str(own)).nodes["planner_server"].named["parameters"][1] == str(own)


def test_nav2_s_common_parameters_have_a_point_where_ros_wants_one(package: Path) -> None:
    """Only the size of a rolling costmap is an integer in Nav2."""
    whole = {
        name
        for name, value in leaves(yaml.safe_load((package / "config" / "nav2.yaml").read_text()))
        if isinstance(value, int) and not isinstance(value, bool)
    }
    assert whole == {f"local_costmap.local_costmap.ros__parameters.{side}" for side in ("width", "height")}


def test_the_map_server_is_activated_by_a_lifecycle_manager(package: Path, launch: Launch) -> None:
    nodes = launch(package / "launch" / "map_server.launch.py").nodes
    (grid,) = nodes["map_server"].named["parameters"]
    assert text_of(grid["yaml_filename"]) == str(package / "maps" / NAMED.name / "map.yaml")
    (manager,) = nodes["lifecycle_manager_map"].named["parameters"]
    assert manager["autostart"] is True
    assert manager["node_names"] == [nodes["map_server"].named["name"]]


def test_rviz_shows_what_the_package_publishes(package: Path) -> None:
    config = yaml.safe_load((package / "config" / "map.rviz").read_text())["Visualization Manager"]
    displays = {display["Name"]: display for display in config["Displays"]}
    assert {display["Class"].partition("/")[0] for display in displays.values()} == {
        "rviz_default_plugins",
        "grid_map_rviz_plugin",
    }
    topics = {
        topic["Value"]
        for display in displays.values()
        for topic in (display.get("Topic"), display.get("Description Topic"))
        if topic
    }
    bridged = {
        topic["ros_topic_name"] for topic in yaml.safe_load((package / "robots" / "burger" / "bridge.yaml").read_text())
    }
    assert topics - bridged == {
        "/step_field/robot_description",
        "/robot_description",
        "/map",
        "/plan",
        "/global_costmap/costmap",
        "/elevation",
    }
    latched = {"Step field", "Robot", "Occupancy grid", "Costmap of Nav2", "Elevation"}
    for name, display in displays.items():
        topic = display.get("Topic") or display.get("Description Topic") or {}
        assert (topic.get("Durability Policy") == "Transient Local") == (name in latched), name


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
