"""The files of a ROS 2 package that do not depend on its maps: manifest, build file, launch files, configurations.

    name of the package, files of robots --common_files--> the text of each file

Launch files look for the maps next to them, so packages of one name can be joined: only the maps differ. colcon and
rosdep read package.xml, CMakeLists.txt and the environment hook.

A Gazebo Sim server loads the systems of its configuration for a world that names none, as the package's worlds do. Up
to 6.7 it loads only these, so physics, user commands and scene broadcaster are named too. The names are those of the
installed version: `ignition-gazebo-...` in Fortress, `gz-sim-...` from Garden on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from types import MappingProxyType

from rsegen.exporters.gazebo.sdf import system_name
from rsegen.exporters.ros2.bridge import CLOCK, bridge_yaml, robot_topics
from rsegen.exporters.ros2.elevation import NODE
from rsegen.exporters.ros2.launch import CLASSIC, SIM, SPAWN_ROBOT
from rsegen.exporters.ros2.nav2 import NAV2
from rsegen.exporters.ros2.nodes import ELEVATION, MAP_SERVER, NAVIGATION, RVIZ, TEST
from rsegen.exporters.ros2.readme import readme
from rsegen.exporters.ros2.rviz import RVIZ_CONFIG

_EXEC_DEPENDS = (
    "grid_map_msgs",
    "grid_map_rviz_plugin",
    "launch",
    "launch_ros",
    "nav2_behaviors",
    "nav2_bt_navigator",
    "nav2_controller",
    "nav2_costmap_2d",
    "nav2_lifecycle_manager",
    "nav2_map_server",
    "nav2_navfn_planner",
    "nav2_planner",
    "nav2_regulated_pure_pursuit_controller",
    "python3-numpy",
    "rclpy",
    "robot_state_publisher",
    "ros_gz_bridge",
    "ros_gz_sim",
    "rviz2",
    "sdformat_urdf",
    "std_msgs",
    "teleop_twist_keyboard",
    "tf2_ros",
    "xacro",
)
_LINTERS = ("ament_cmake_flake8", "ament_cmake_lint_cmake", "ament_cmake_pep257", "ament_cmake_xmllint")


def package_xml(package: str) -> str:
    """Return the text of package.xml, which depends on gazebo_ros if the distribution has it, as up to Humble and
    Iron.
    """
    # Format 3 (REP 149), which has conditions.
    return f"""\
<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>1.0.0</version>
  <description>Random Step Environments as worlds and models for Gazebo, RViz and Nav2; made by rsegen.</description>
  <maintainer email="you@example.com">you</maintainer>
  <license file="LICENSE">Apache-2.0</license>
  <url type="website">https://example.com</url>
  <buildtool_depend>ament_cmake</buildtool_depend>
{_depends("exec_depend", _EXEC_DEPENDS)}\
  <exec_depend condition="$ROS_DISTRO == humble or $ROS_DISTRO == iron">gazebo_ros</exec_depend>
{_depends("test_depend", (*_LINTERS, "ament_cmake_pytest", "ament_lint_auto"))}\
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""


def _depends(tag: str, packages: Sequence[str]) -> str:
    return "".join(f"  <{tag}>{package}</{tag}>\n" for package in packages)


def cmake_lists(package: str) -> str:
    """Return the text of CMakeLists.txt; if ROS's linters and pytest are not installed, it builds without tests."""
    # Nothing is compiled: files are installed, and the hook adds the models to Gazebo's search paths.
    return f"""\
cmake_minimum_required(VERSION 3.8)
project({package} NONE)

find_package(ament_cmake REQUIRED)

install(FILES LICENSE README.md DESTINATION share/${{PROJECT_NAME}})
install(
  DIRECTORY config launch maps models nodes robots urdf worlds
  DESTINATION share/${{PROJECT_NAME}}
)
ament_environment_hooks("${{CMAKE_CURRENT_SOURCE_DIR}}/env-hooks/${{PROJECT_NAME}}.dsv.in")

if(BUILD_TESTING)
  find_package(ament_lint_auto QUIET)
  if(ament_lint_auto_FOUND)
    ament_lint_auto_find_test_dependencies()
  endif()
  find_package(ament_cmake_pytest QUIET)
  if(ament_cmake_pytest_FOUND)
    ament_add_pytest_test(launch_files test/test_launch_files.py)
  endif()
endif()

ament_package()
"""


ENVIRONMENT_HOOK = "".join(
    f"prepend-non-duplicate;{variable};share/@PROJECT_NAME@/models\n"
    for variable in ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
)
"""The search paths for models of Gazebo Classic, Gazebo Sim and Ignition."""

_SYSTEMS = MappingProxyType(
    {
        "Physics": "",
        "UserCommands": "",
        "SceneBroadcaster": "",
        "Sensors": "<render_engine>ogre2</render_engine>",
        "Imu": "",
        "Contact": "",
        "Altimeter": "",
        "ForceTorque": "",
        "Magnetometer": "",
        "NavSat": "",
    }
)
"""Systems of a server with the parameters of each."""


def _config(backend: str) -> str:
    return f"<server_config>\n  <plugins>\n{''.join(_plugins(backend))}  </plugins>\n</server_config>\n"


def _plugins(backend: str) -> Iterator[str]:
    for kind, parameters in _SYSTEMS.items():
        name = system_name(kind, backend)
        yield f"""\
    <plugin entity_name="*" entity_type="world"
            filename="{name.library}"
            name="{name.class_name}">{parameters}</plugin>
"""


FORTRESS = _config("fortress")
GARDEN_AND_LATER = _config("sim")


def common_files(package: str, robots: Mapping[str, Mapping[str, str]], robot: str) -> Mapping[str, str]:
    """The text of each file of a package of this name by its path, except those of its maps.

    robots: the files of each robot by its kind; robot: the one that is spawned by default, or `none`
    """
    own = "topics of a robot of your own: those of Gazebo Sim's plug-ins for a model named robot"
    return {
        "LICENSE": files("rsegen.exporters.ros2").joinpath("LICENSE").read_text("utf-8"),
        "README.md": readme(package, robots),
        "package.xml": package_xml(package),
        "CMakeLists.txt": cmake_lists(package),
        f"env-hooks/{package}.dsv.in": ENVIRONMENT_HOOK,
        "config/clock_bridge.yaml": bridge_yaml("the time of Gazebo Sim", [CLOCK]),
        "config/fortress_server.config": FORTRESS,
        "config/map.rviz": RVIZ_CONFIG,
        "config/nav2.yaml": NAV2,
        "config/robot_bridge.yaml": bridge_yaml(own, robot_topics()),
        "config/server.config": GARDEN_AND_LATER,
        "launch/elevation.launch.py": ELEVATION,
        "launch/gazebo_classic.launch.py": CLASSIC,
        "launch/gazebo_sim.launch.py": SIM,
        "launch/map_server.launch.py": MAP_SERVER,
        "launch/navigation.launch.py": NAVIGATION.replace("@ROBOT@", robot),
        "launch/rviz.launch.py": RVIZ,
        "launch/spawn_robot.launch.py": SPAWN_ROBOT.replace("@ROBOT@", robot),
        "nodes/elevation.py": NODE,
        **{f"robots/{kind}/{name}": text for kind, texts in robots.items() for name, text in texts.items()},
        "test/test_launch_files.py": TEST,
    }
