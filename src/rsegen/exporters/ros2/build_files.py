"""What colcon and rosdep read of a package: package.xml, CMakeLists.txt, the environment hook."""

from __future__ import annotations

from collections.abc import Sequence

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
    """The text of package.xml, which depends on gazebo_ros if the distribution has it, as up to Humble and Iron."""
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
    """The text of CMakeLists.txt; where ROS's linters and pytest are not installed, it builds without tests."""
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
