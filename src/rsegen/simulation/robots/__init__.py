"""Robots that drive over the maps: every file of this folder that registers one, found by being there."""

from __future__ import annotations

from rsegen.simulation.robots.base import ROBOTS, Robot
from rsegen.simulation.robots.commands import SIMULATORS, Command
from rsegen.simulation.robots.own import OwnRobot, from_file


def robot(kind: str, where: str = "robot") -> Robot:
    """The robot of a kind, or an UnknownName that lists the kinds."""
    return ROBOTS.named(kind, where)


__all__ = ["ROBOTS", "SIMULATORS", "Command", "OwnRobot", "Robot", "from_file", "robot"]
