"""The parameters that name a robot, and how the motors of its wheels act."""

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
"""Kinds of wheel motors: with a torque that acts on the chassis too, as real ones have; or as in Gazebo Classic's
drive, which sets the speed of a wheel without a torque."""

MotorModel = Annotated[
    str | None,
    Choice(
        MOTORS,
        help="how motors of wheels act in MuJoCo: with their reaction on the chassis, as real motors do, or without "
        "it, as Gazebo Classic's",
    ),
    Shell(default=MOTORS[0]),
]
