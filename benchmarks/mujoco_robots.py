"""Robots at rest and fields as a model of MuJoCo: blocks are boxes, and no joint of a robot moves.

Shapes, masses and friction are those of the robots' links, so a robot is the same as in Gazebo.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from rsegen.field.stepfield import Array, StepField
from rsegen.geometry.poses import rotation, turn_about
from rsegen.robots.base import Robot
from rsegen.robots.links import Box, Cylinder, Joint, Link, Part, SdfPose

STEP = 0.001
"""Seconds of a physics step, as in Gazebo Classic."""


def model(parts: Iterable[str]) -> str:
    """Return an MJCF model of a ground plane and these parts: the blocks of a field, and robots."""
    # The robot's friction counts, as that of Gazebo's blocks is larger; contacts are stiff, as ODE's are.
    return f"""<mujoco>
<compiler angle="radian" eulerseq="XYZ"/>
<option timestep="{STEP}" integrator="implicitfast" cone="elliptic" impratio="10"/>
<size memory="200M"/>
<default><geom solref="0.004 1" solimp="0.99 0.999 0.0001"/></default>
<worldbody><geom type="plane" size="99 99 1" contype="1" conaffinity="2"/>{"".join(parts)}</worldbody>
</mujoco>"""


def blocks(field: StepField, near: tuple[float, float, float] | None = None) -> str:
    """Return the blocks of a field; near: x, y and a distance, only those whose centres are within it along x and y."""
    edges_x, edges_y = field.edges()
    width = field.block_width
    x, y, reach = near or (0.0, 0.0, float("inf"))
    return "".join(
        f'<geom type="box" size="{width / 2} {width / 2} {height / 2}" contype="1" conaffinity="2"'
        f' pos="{edges_x[i] + width / 2} {edges_y[j] + width / 2} {height / 2}"/>'
        for (i, j), height in np.ndenumerate(field.heights)
        if height > 0 and abs(edges_x[i] + width / 2 - x) < reach and abs(edges_y[j] + width / 2 - y) < reach
    )


def free_robot(robot: Robot, at: SdfPose, name: str = "robot") -> str:
    """Return a robot with its origin at a pose."""
    holders = {joint.child: joint for joint in robot.joints}
    angles = {servo.joint: servo.rest for servo in robot.servos}
    links = (_link(link, holders.get(link.name), angles) for link in robot.links)
    place = f'pos="{" ".join(map(str, at[:3]))}" euler="{" ".join(map(str, at[3:]))}"'
    return f'<body {place}><freejoint name="{name}"/>{"".join(links)}</body>'


def pose_of(mujoco: Any, state: Any, name: str = "robot") -> Array:
    """Return x, y, z, roll, pitch and yaw of a robot's origin."""
    place, matrix = state.joint(name).qpos, np.zeros(9)
    mujoco.mju_quat2Mat(matrix, place[3:7])
    return np.concatenate([place[:3], _angles(matrix.reshape(3, 3))])


def version() -> str:
    """Return MuJoCo's name and version."""
    import mujoco

    return f"MuJoCo {mujoco.__version__}"


def _link(link: Link, holder: Joint | None, angles: Mapping[str, float]) -> str:
    """Return a link fixed to the robot, turned by the angle of the servo that holds it."""
    turned = rotation(*link.pose[3:])
    if holder and holder.axis and angles.get(holder.name):
        turned = turned @ turn_about(holder.axis, angles[holder.name])
    inertia = " ".join(map(str, link.moments))
    centre = f'pos="{_spaced(link.centre[:3])}" quat="{_quaternion(rotation(*link.centre[3:]))}"'
    return (
        f'<body pos="{_spaced(link.pose[:3])}" quat="{_quaternion(turned)}">'
        f'<inertial {centre} mass="{link.mass}" diaginertia="{inertia}"/>'
        + "".join(map(_geometry, link.parts))
        + "</body>"
    )


def _geometry(part: Part) -> str:
    """Return the collision shape of a part, which touches the ground, blocks and other robots."""
    if part.surface is None:
        return ""
    solid = part.solid
    if isinstance(solid, Box):
        shape = f'type="box" size="{_spaced(side / 2 for side in solid.size)}"'
    elif isinstance(solid, Cylinder):
        shape = f'type="cylinder" size="{solid.radius} {solid.length / 2}"'
    else:
        shape = f'type="sphere" size="{solid.radius}"'
    place = f'pos="{_spaced(part.pose[:3])}" quat="{_quaternion(rotation(*part.pose[3:]))}"'
    friction = f'friction="{max(part.surface.mu, 1e-3)} 0.005 0.0001" priority="1"'
    return f'<geom {shape} {place} {friction} contype="2" conaffinity="3"/>'


def _angles(axes: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of axes as columns, radians."""
    pitch = -np.arcsin(np.clip(axes[2, 0], -1, 1))
    return float(np.arctan2(axes[2, 1], axes[2, 2])), float(pitch), float(np.arctan2(axes[1, 0], axes[0, 0]))


def _spaced(values: Any) -> str:
    return " ".join(f"{float(value):.9g}" for value in values)


def _quaternion(axes: Array) -> str:
    import mujoco

    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.asarray(axes, float).ravel())
    return _spaced(found)
