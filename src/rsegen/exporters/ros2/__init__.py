"""What every ROS 2 package has whatever maps are in it: manifest, build file, launch files, configurations, licence.

name of the package --common_files--> the text of each file

The launch files look for the maps beside them, so packages of one name can be joined: only the maps differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files

from rsegen.exporters.ros2 import build_files, gazebo_launch, map_launch, rviz, server_configs


def common_files(package: str) -> Mapping[str, str]:
    """The text of each file of a package of this name by its path, except those of its maps."""
    return {
        "LICENSE": files(__name__).joinpath("LICENSE").read_text("utf-8"),
        "package.xml": build_files.package_xml(package),
        "CMakeLists.txt": build_files.cmake_lists(package),
        f"env-hooks/{package}.dsv.in": build_files.ENVIRONMENT_HOOK,
        "config/fortress_server.config": server_configs.FORTRESS,
        "config/server.config": server_configs.GARDEN_AND_LATER,
        "config/map.rviz": rviz.CONFIG,
        "launch/gazebo_classic.launch.py": gazebo_launch.CLASSIC,
        "launch/gazebo_sim.launch.py": gazebo_launch.SIM,
        "launch/map_server.launch.py": map_launch.MAP_SERVER,
        "launch/rviz.launch.py": map_launch.RVIZ,
        "launch/spawn_robot.launch.py": gazebo_launch.SPAWN_ROBOT,
        "test/test_launch_files.py": map_launch.TEST,
    }
