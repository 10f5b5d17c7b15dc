"""What every ROS 2 package has whatever maps are in it: manifest, build file, launch files, configurations, licence.

name of the package --common_files--> the text of each file

The launch files look for the maps beside them, so packages of one name can be joined: only the maps differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files

from rsegen.exporters.ros2.build_files import ENVIRONMENT_HOOK, cmake_lists, package_xml
from rsegen.exporters.ros2.gazebo_launch import CLASSIC, SIM, SPAWN_ROBOT
from rsegen.exporters.ros2.map_launch import MAP_SERVER, RVIZ, TEST
from rsegen.exporters.ros2.rviz import RVIZ_CONFIG
from rsegen.exporters.ros2.server_configs import FORTRESS, GARDEN_AND_LATER


def common_files(package: str) -> Mapping[str, str]:
    """The text of each file of a package of this name by its path, except those of its maps."""
    return {
        "LICENSE": files(__name__).joinpath("LICENSE").read_text("utf-8"),
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
