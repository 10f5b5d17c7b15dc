"""The format `ros2`: the map as a package for `colcon build`, with launch files for both Gazebos."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from rsegen.exporters.formats.base import Format, register
from rsegen.exporters.gazebo import sdf, single
from rsegen.exporters.scene import Scene


@register
@dataclass(frozen=True, kw_only=True, slots=True)
class Ros2(Format):
    """A ROS 2 package (ament_cmake) with the map's model, a world, and launch files for both Gazebos."""

    name: ClassVar[str] = "ros2"

    @property
    def bytes_a_cell(self) -> int:
        """The memory of a world."""
        return 600

    def files(self, scene: Scene) -> Mapping[str, Iterable[bytes]]:
        """The files of the package, in a folder of its name."""
        package = package_name(scene.name)
        texts = {
            "package.xml": _package_xml(package, scene),
            "CMakeLists.txt": _cmake(package),
            f"env-hooks/{package}.dsv.in": _HOOK,
            "launch/gazebo_classic.launch.py": _CLASSIC.format(package=package, world=scene.name),
            "launch/gazebo_sim.launch.py": _SIM.format(package=package, world=scene.name),
        }
        found = {path: [text.encode()] for path, text in texts.items()} | dict(_model(scene))
        found[f"worlds/{scene.name}.world"] = sdf.utf8(sdf.world(scene, [_INCLUDE.format(name=scene.name)]))
        return {f"{package}/{path}": content for path, content in found.items()}


def package_name(name: str) -> str:
    """A map's name as a ROS package name (REP 144): lower case, digits, single underscores, a letter first."""
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    return plain if plain[:1].isalpha() else f"map_{plain}"


def _model(scene: Scene) -> Iterator[tuple[str, Iterable[bytes]]]:
    """The files of the map's model, made by mesh type `single`; the package has a world of its own."""
    for path, content in single.files(scene).items():
        if path != f"{scene.name}.world":
            yield f"models/{scene.name}/{path}", content


def _package_xml(package: str, scene: Scene) -> str:
    """The text of package.xml, which depends on gazebo_ros if the distribution has it, as up to Humble and Iron."""
    return f"""\
<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>1.0.0</version>
  <description>The Random Step Environment {scene.name} as a model and a world for Gazebo; made by rsegen.</description>
  <maintainer email="you@example.com">you</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <exec_depend>ament_index_python</exec_depend>
  <exec_depend>launch</exec_depend>
  <exec_depend condition="$ROS_DISTRO == humble or $ROS_DISTRO == iron">gazebo_ros</exec_depend>
  <exec_depend>ros_gz_sim</exec_depend>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""


def _cmake(package: str) -> str:
    return f"""\
cmake_minimum_required(VERSION 3.8)
project({package} NONE)

find_package(ament_cmake REQUIRED)

install(DIRECTORY launch models worlds DESTINATION share/${{PROJECT_NAME}})
ament_environment_hooks("${{CMAKE_CURRENT_SOURCE_DIR}}/env-hooks/${{PROJECT_NAME}}.dsv.in")
ament_package()
"""


_HOOK = "".join(
    f"prepend-non-duplicate;{variable};share/@PROJECT_NAME@/models\n"
    for variable in ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
)
"""The search paths for models of Gazebo Classic, Gazebo Sim and Ignition."""

_INCLUDE = """\
    <include>
      <uri>model://{name}</uri>
    </include>
"""

_IMPORTS = """\
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
"""

_CLASSIC = f'''\
"""Opens the map in Gazebo Classic: ros2 launch {{package}} gazebo_classic.launch.py [gui:=false]."""

{_IMPORTS}\
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

WORLD = Path(get_package_share_directory("{{package}}")) / "worlds" / "{{world}}.world"
GAZEBO = Path(get_package_share_directory("gazebo_ros")) / "launch"


def generate_launch_description():
    server = PythonLaunchDescriptionSource(str(GAZEBO / "gzserver.launch.py"))
    window = PythonLaunchDescriptionSource(str(GAZEBO / "gzclient.launch.py"))
    return LaunchDescription(
        [
            DeclareLaunchArgument("gui", default_value="true", description="whether there is a window"),
            IncludeLaunchDescription(server, launch_arguments={{{{"world": str(WORLD)}}}}.items()),
            IncludeLaunchDescription(window, condition=IfCondition(LaunchConfiguration("gui"))),
        ]
    )
'''

_SIM = f'''\
"""Opens the map in Gazebo Sim: ros2 launch {{package}} gazebo_sim.launch.py [options:="-r -s"]."""

{_IMPORTS}\
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

WORLD = Path(get_package_share_directory("{{package}}")) / "worlds" / "{{world}}.world"
GAZEBO = Path(get_package_share_directory("ros_gz_sim")) / "launch"


def generate_launch_description():
    gazebo = PythonLaunchDescriptionSource(str(GAZEBO / "gz_sim.launch.py"))
    arguments = [LaunchConfiguration("options"), " ", str(WORLD)]
    return LaunchDescription(
        [
            DeclareLaunchArgument("options", default_value="-r", description="of gz sim: -r runs, -s has no window"),
            IncludeLaunchDescription(gazebo, launch_arguments={{{{"gz_args": arguments}}}}.items()),
        ]
    )
'''
