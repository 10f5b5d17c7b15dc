"""Robots that drive over the maps: every file of this folder that registers one, found by being there."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from importlib import import_module

from rsegen.errors import UnknownName
from rsegen.robots.base import Robot, registered
from rsegen.robots.commands import SIMULATORS, Command
from rsegen.robots.own import OwnRobot, from_file

for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

ROBOTS: Mapping[str, Robot] = registered()
"""Every robot by its kind."""


def robot(kind: str, where: str = "robot") -> Robot:
    """The robot of a kind, or an UnknownName that lists the kinds."""
    if kind not in ROBOTS:
        raise UnknownName.among(where, "robot", kind, ROBOTS)
    return ROBOTS[kind]


__all__ = ["ROBOTS", "SIMULATORS", "Command", "OwnRobot", "Robot", "from_file", "robot"]
