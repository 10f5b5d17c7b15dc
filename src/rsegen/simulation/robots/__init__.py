"""Robots that drive over maps; each is one file of this folder, which is imported automatically."""

from __future__ import annotations

from rsegen.simulation.robots.base import ROBOTS, Robot
from rsegen.simulation.robots.commands import BACKENDS, Command
from rsegen.simulation.robots.sdf_file import SdfRobot, from_file


def robot(kind: str, where: str = "robot") -> Robot:
    """The robot of a kind, or an UnknownName that lists the kinds."""
    return ROBOTS.named(kind, where)


__all__ = ["BACKENDS", "ROBOTS", "Command", "Robot", "SdfRobot", "from_file", "robot"]
