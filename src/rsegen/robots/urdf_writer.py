"""A robot as URDF, for programs that know robots by their links and joints: robot_state_publisher, RViz, MoveIt.

    Robot of links at poses in the model --urdf--> base_link - fixed - base - hinges - wheels, tracks, ...

In URDF a link stands where its joint puts it, while in SDF each has a pose in the model, so a joint's origin is the
pose of its child in its parent's frame. The root `base_link` is the model's origin, on the ground below the robot; it
has no mass, since KDL ignores that of a root. A hinge's anchor is left out: it lies on the axis, and moves nothing.

Friction, contact and plug-ins are not in it: URDF has no words for them, and Gazebo gets the robot as SDF.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from rsegen.exporters.gazebo.sdf import numbers
from rsegen.exporters.numbers import decimal
from rsegen.robots.links import Box, Cylinder, Joint, Link, Part, SdfPose, Solid, angles, rotation

if TYPE_CHECKING:  # whose files are made with this
    from rsegen.robots.base import Robot

ROOT = "base_link"
"""The frame of the robot's origin, after ROS's REP 105."""


def urdf(robot: Robot, frames: Mapping[str, SdfPose] | None = None) -> str:
    """Return the URDF of a robot; frames: links without a body on its first link, such as sensors, by their names."""
    return "".join(_robot(robot, frames or {}))


def _robot(robot: Robot, frames: Mapping[str, SdfPose]) -> Iterator[str]:
    links = {link.name: link for link in robot.links}
    base = robot.links[0]
    yield f"""\
<?xml version="1.0"?>
<!-- made by rsegen: {robot.kind}, {robot.title}; metres, kilograms, x forward, z up -->
<robot name="{robot.kind}">
  <link name="{ROOT}"/>
"""
    yield _joint("fixed", f"{base.name}_fixed", ROOT, base.name, base.pose)
    for link in robot.links:
        yield from _link(link)
    for joint in robot.joints:
        origin = _relative(links[joint.parent].pose, links[joint.child].pose)
        yield _joint(_kind(joint), joint.name, joint.parent, joint.child, origin, _turning(joint))
    for name, pose in frames.items():
        yield f'  <link name="{name}"/>\n' + _joint("fixed", f"{name}_fixed", base.name, name, pose)
    yield "</robot>\n"


def _link(link: Link) -> Iterator[str]:
    ixx, iyy, izz = link.moments
    yield f"""\
  <link name="{link.name}">
    <inertial>
      {_origin(link.centre)}
      <mass value="{decimal(link.mass)}"/>
      <inertia ixx="{ixx:.9g}" ixy="0" ixz="0" iyy="{iyy:.9g}" iyz="0" izz="{izz:.9g}"/>
    </inertial>
"""
    for part in link.parts:
        yield _part(part, f"{link.name}_{part.name}")
    yield "  </link>\n"


def _part(part: Part, name: str) -> str:
    shape = f"{_origin(part.pose)}<geometry>{_geometry(part.solid)}</geometry>"
    name_of_colour, rgba = numbers(part.colour).replace(" ", "_"), numbers((*part.colour, 1))
    colour = f'<material name="{name_of_colour}"><color rgba="{rgba}"/></material>'
    hit = f'    <collision name="{name}">{shape}</collision>\n' if part.surface else ""
    return f'    <visual name="{name}">{shape}{colour}</visual>\n{hit}'


def _geometry(solid: Solid) -> str:
    if isinstance(solid, Box):
        return f'<box size="{numbers(solid.size)}"/>'
    if isinstance(solid, Cylinder):
        return f'<cylinder radius="{decimal(solid.radius)}" length="{decimal(solid.length)}"/>'
    return f'<sphere radius="{decimal(solid.radius)}"/>'


def _joint(kind: str, name: str, parent: str, child: str, origin: SdfPose, turning: str = "") -> str:
    return f"""\
  <joint name="{name}" type="{kind}">
    {_origin(origin)}
    <parent link="{parent}"/>
    <child link="{child}"/>
{turning}  </joint>
"""


def _kind(joint: Joint) -> str:
    if joint.axis is None:
        return "fixed"
    return "continuous" if joint.lower is None else "revolute"


def _turning(joint: Joint) -> str:
    """Return the axis and limits of a hinge; URDF wants all four limits of a hinge that has ends."""
    if joint.axis is None:
        return ""
    axis = f'    <axis xyz="{numbers(joint.axis)}"/>\n'
    damping = f'    <dynamics damping="{decimal(joint.damping)}"/>\n' if joint.damping else ""
    if joint.lower is None:
        return axis + damping
    ends = {"lower": joint.lower, "upper": joint.upper, "effort": joint.effort, "velocity": joint.rate}
    limits = " ".join(f'{name}="{decimal(value or 0)}"' for name, value in ends.items())
    return f"{axis}    <limit {limits}/>\n{damping}"


def _origin(pose: SdfPose) -> str:
    return f'<origin xyz="{numbers(pose[:3])}" rpy="{numbers(pose[3:])}"/>'


def _relative(parent: SdfPose, child: SdfPose) -> SdfPose:
    """Return the pose of a child in the frame of its parent."""
    turned = rotation(*parent[3:])
    x, y, z = turned.T @ (np.array(child[:3]) - np.array(parent[:3]))
    return float(x), float(y), float(z), *angles(turned.T @ rotation(*child[3:]))
