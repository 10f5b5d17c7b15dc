"""The files of a ROS 2 package that do not depend on its maps: manifest, build file, launch files, configurations.

    name of the package --common_files--> the text of each file

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
from rsegen.exporters.ros2.launch import CLASSIC, MAP_SERVER, RVIZ, RVIZ_CONFIG, SIM, SPAWN_ROBOT, TEST

_EXEC_DEPENDS = (
    "launch",
    "launch_ros",
    "nav2_lifecycle_manager",
    "nav2_map_server",
    "robot_state_publisher",
    "ros_gz_bridge",
    "ros_gz_sim",
    "rviz2",
    "tf2_ros",
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

install(FILES LICENSE DESTINATION share/${{PROJECT_NAME}})
install(DIRECTORY config launch maps models urdf worlds DESTINATION share/${{PROJECT_NAME}})
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


def common_files(package: str) -> Mapping[str, str]:
    """The text of each file of a package of this name by its path, except those of its maps."""
    return {
        "LICENSE": files("rsegen.exporters.ros2").joinpath("LICENSE").read_text("utf-8"),
        "package.xml": package_xml(package),
        "CMakeLists.txt": cmake_lists(package),
        f"env-hooks/{package}.dsv.in": ENVIRONMENT_HOOK,
        "config/fortress_server.config": FORTRESS,
        "config/server.config": GARDEN_AND_LATER,
        "config/map.rviz": RVIZ_CONFIG,
        "launch/gazebo_classic.launch.py": CLASSIC,
        "launch/gazebo_sim.launch.py": SIM,
        "launch/map_server.launch.py": MAP_SERVER,
        "launch/rviz.launch.py": RVIZ,
        "launch/spawn_robot.launch.py": SPAWN_ROBOT,
        "test/test_launch_files.py": TEST,
    }
