"""Robots that drive over maps; each is one file of this folder, which is imported automatically."""

from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.drives import BACKENDS, Command
from rsegen.robots.lookup import poses, robot, robot_of
from rsegen.robots.sdf_file import SdfRobot, from_file, is_robot_file
from rsegen.robots.xacro_files import with_arguments

__all__ = [
    "BACKENDS",
    "ROBOTS",
    "Command",
    "Robot",
    "SdfRobot",
    "from_file",
    "is_robot_file",
    "poses",
    "robot",
    "robot_of",
    "with_arguments",
]
