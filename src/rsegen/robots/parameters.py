"""The parameters that name a robot, and how its motors act."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated

from rsegen.params.command import Shell
from rsegen.params.sorts import Choice, Reference

if TYPE_CHECKING:
    from rsegen.robots.lookup import DrivableRobot


_ROBOT = Reference(
    "a kind of robot, or a file of one",
    help="kind of robot, or SDF, URDF, Xacro or MJCF file, as 'FILE NAME:=VALUE ...' with arguments",
    types=(object,),
)

RobotModel = Annotated["str | os.PathLike[str] | DrivableRobot", _ROBOT, Shell(metavar="KIND|FILE")]

AnyRobot = Annotated["str | os.PathLike[str] | DrivableRobot | None", _ROBOT, Shell(metavar="KIND|FILE")]

MOTORS = ("reaction", "classic")
"""Models of motors: as in a real robot, whose motors act on the chassis too, and whose wheels and belts hold across by
what slipping leaves of their friction; or as in Gazebo Classic, which sets the speed of a wheel without a torque, and
where wheels and belts hold across as firmly while they slip along."""

MotorModel = Annotated[
    str | None,
    Choice(
        MOTORS,
        help="how motors act in MuJoCo: as real ones, which push the chassis back, or as Gazebo Classic's, which do "
        "not, and whose friction holds sideways what slips along",
    ),
    Shell(default=MOTORS[0]),
]
