"""Find a robot by the name of its kind or by the path of its file."""

from __future__ import annotations

import os

from rsegen.robots.base import ROBOTS, DrivableRobot, Robot
from rsegen.robots.sdf_file import from_file, is_robot_file


def robot(kind: str, where: str = "robot") -> Robot:
    """Return the robot of a kind, or raise an UnknownName that lists the kinds."""
    return ROBOTS.named(kind, where)


def robot_of(what: str | os.PathLike[str] | DrivableRobot) -> DrivableRobot:
    """Return the robot of a kind or of a file; a robot itself as it is."""
    if isinstance(what, str | os.PathLike):
        return from_file(what) if is_robot_file(what) else robot(os.fspath(what))
    return what
