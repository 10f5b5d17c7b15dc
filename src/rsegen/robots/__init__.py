"""Robots that drive over maps; each is one file of this folder, which is imported automatically."""

from __future__ import annotations

import os

from rsegen.robots.base import ROBOTS, DrivableRobot, Robot
from rsegen.robots.drives import BACKENDS, Command
from rsegen.robots.sdf_file import SdfRobot, from_file, is_robot_file

__all__ = ["BACKENDS", "ROBOTS", "Command", "Robot", "SdfRobot", "from_file", "is_robot_file", "robot", "robot_of"]


def robot(kind: str, where: str = "robot") -> Robot:
    """The robot of a kind, or an UnknownName that lists the kinds."""
    return ROBOTS.named(kind, where)


def robot_of(what: str | os.PathLike[str] | DrivableRobot) -> DrivableRobot:
    """The robot of a kind or of an SDF file; a robot itself as it is."""
    if isinstance(what, str | os.PathLike):
        return from_file(what) if is_robot_file(what) else robot(os.fspath(what))
    return what
