"""Find a robot by the name of its kind or by the path of its file, and how it stands."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeAlias

from numpy.typing import ArrayLike

from rsegen.errors import FileError, ParameterError, refuse_other, shown
from rsegen.field.crossing import CrossingModel
from rsegen.field.stepfield import StepField
from rsegen.robots.base import ROBOTS, Robot
from rsegen.robots.files.sdf_file import SUFFIXES, SdfRobot, from_file, is_robot_file
from rsegen.standing import resting, stable
from rsegen.standing.kinds import RobotWithRoom
from rsegen.standing.resting import Poses
from rsegen.standing.stable import StablePoses

DrivableRobot: TypeAlias = Robot | SdfRobot
"""A robot that can be driven over a map: of a kind, or of a file."""


def reads(path: Path, start: bytes) -> str:
    """Return what reads the file of a robot (`Capability.reads`); a world in SDF is none."""
    is_known = path.suffix.lower() in SUFFIXES and (path.suffix != ".xml" or b"<mujoco" in start)
    return "rsegen robot" if is_known and b"<world" not in start else ""


def chosen_robot(
    robot: str | os.PathLike[str] | DrivableRobot, wheels: str | None, tracks: str | None, **limits: object
) -> DrivableRobot:
    """Return a robot of a kind or of a file; only a file's takes wheels, tracks, size, speed and turn rate."""
    given_limits = {name: value for name, value in limits.items() if value is not None}
    if wheels and tracks:
        raise ParameterError("tracks", "excludes wheels; name only those on which the robot drives")
    if isinstance(robot, str | os.PathLike) and is_robot_file(robot):
        return from_file(robot, wheels, tracks).given(given_limits)
    for name in [*given_limits, *(["wheels"] if wheels else []), *(["tracks"] if tracks else [])]:
        kind = robot_of(robot).kind
        raise ParameterError(name, f"is for the robot of a file; {shown(kind)} has its own")
    return robot_of(robot)


def robot_of_kind(kind: str, where: str = "robot") -> Robot:
    """Return the robot of a kind, or raise an UnknownName that lists the kinds."""
    return ROBOTS.named(kind, where)


def robot_of(what: str | os.PathLike[str] | DrivableRobot, where: str = "robot") -> DrivableRobot:
    """Return a robot by its kind or file.

    Parameters
    ----------
    what : str, path or robot
        A kind, or an SDF, URDF, Xacro or MJCF file, as `FILE NAME:=VALUE ...` with arguments; a robot is returned as
        it is.
    where : str, default 'robot'
        By which errors name it.

    Returns
    -------
    Robot or SdfRobot
        The robot.

    Raises
    ------
    UnknownName
        If there is no such kind.
    FileError
        If the file is no robot.
    ParameterError
        If it is anything else.
    """
    if isinstance(what, str | os.PathLike):
        if is_robot_file(what):
            return from_file(what)
        if what not in ROBOTS and os.path.isfile(what):
            if os.fspath(what).lower().endswith(".proto"):
                raise FileError(f"{os.fspath(what)}: a PROTO of Webots; export it as URDF there, and use that file")
            raise FileError(
                f"{os.fspath(what)}: robots are read from files named {', '.join('*' + s for s in SUFFIXES)}"
            )
        return robot_of_kind(os.fspath(what), where)
    if not isinstance(what, Robot | SdfRobot):
        raise ParameterError(where, f"{shown(what)} is no robot; use a kind, as in 'burger', or a file of one")
    return what


def robot_file(robot: object) -> str | None:
    """Return the file of a robot, with its arguments, as a user named it; None for a kind, or a robot in Python."""
    return os.fspath(robot) if isinstance(robot, str | os.PathLike) and is_robot_file(robot) else None


def crosser(what: object, where: str, *, kind_only: bool = False, room: float = 1.0) -> CrossingModel:
    """Return the robot of a kind or file, which crosses fields with room to spare (`Capability.crossers`)."""
    if kind_only and isinstance(what, str) and is_robot_file(what):
        problem = "is a file, and a recipe, whose maps are the same everywhere, has none"
        instead = (
            f"use a kind of robot ({', '.join(sorted(ROBOTS))}), or the climb, drop and width in cm of a path of cells"
        )
        raise ParameterError(where, f"{shown(what)} {problem}; {instead}")
    robot = ROBOTS.named(what, where) if kind_only else robot_of(what, where)  # type: ignore[arg-type]  # it is checked
    return robot if room == 1 else RobotWithRoom(robot=robot, room=room)


def poses(
    field: StepField, robot: str | os.PathLike[str] | DrivableRobot, x: ArrayLike, y: ArrayLike, heading: ArrayLike
) -> Poses:
    """Return how a robot stands at places of a field, where it was put down level.

    Parameters
    ----------
    field : StepField
        The field.
    robot : str, path or robot
        A kind, the file of one, or a robot.
    x, y : array_like
        Places, metres from the middle of the field.
    heading : array_like
        Headings, radians. These and the places go together as in numpy.

    Returns
    -------
    Poses
        A pose for each.

    Raises
    ------
    ParameterError
        For a place outside the field, a number that is none, or a robot without collision shapes.
    """
    refuse_other("field", field, StepField)
    return resting.resting_poses(field, robot_of(robot).body, x, y, heading)


def stable_poses(
    field: StepField, robot: str | os.PathLike[str] | DrivableRobot, x: ArrayLike, y: ArrayLike, heading: ArrayLike
) -> StablePoses:
    """Return all poses in which a robot may stand at places of a field: which one it takes depends on how it got there.

    Parameters
    ----------
    field : StepField
        The field.
    robot : str, path or robot
        A kind, the file of one, or a robot.
    x, y : array_like
        Places, metres from the middle of the field.
    heading : array_like
        Headings, radians. These and the places go together as in numpy.

    Returns
    -------
    StablePoses
        The poses, the place of each, and how many there are at each place.

    Raises
    ------
    ParameterError
        For a place outside the field, a number that is none, or a robot without collision shapes.
    """
    refuse_other("field", field, StepField)
    return stable.stable_poses(field, robot_of(robot).body, x, y, heading)
