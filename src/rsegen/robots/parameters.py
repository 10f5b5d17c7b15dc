"""The parameter that names a robot."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated

from rsegen.params.command import Shell
from rsegen.params.sorts import Reference

if TYPE_CHECKING:
    from rsegen.robots.lookup import DrivableRobot


_ROBOT = Reference(
    "a kind of robot, or a file of one",
    help="kind of robot, or SDF, URDF or Xacro file, as 'FILE NAME:=VALUE ...' with arguments",
    types=(object,),
)

RobotModel = Annotated["str | os.PathLike[str] | DrivableRobot", _ROBOT, Shell(metavar="KIND|FILE")]

AnyRobot = Annotated["str | os.PathLike[str] | DrivableRobot | None", _ROBOT, Shell(metavar="KIND|FILE")]
