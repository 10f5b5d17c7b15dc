"""Robots in URDF: that of two_wheels as people write it for ROS, and trees of any links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rsegen.geometry.poses import rotation
from tests.robots.two_wheels import ROS_1

_MASS = '<mass value="{}"/>'
_INERTIA = '<inertia ixx="{}" ixy="{}" ixz="{}" iyy="{}" iyz="{}" izz="{}"/>'

_WHEEL = """\
  <link name="{side}_wheel">
    <inertial><mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/></inertial>
    <collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision>
  </link>
  <joint name="{side}_hub" type="continuous">
    <origin xyz="0 {y} 0" rpy="-1.5707963267948966 0 0"/>
    <parent link="base"/><child link="{side}_wheel"/><axis xyz="0 0 1"/>
  </joint>
  <gazebo reference="{side}_wheel"><mu1>1</mu1><mu2>1</mu2></gazebo>
"""

_BODY = """\
  <material name="blue"><color rgba="0 0 0.8 1"/></material>
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed">
    <origin xyz="0 0 0.02"/><parent link="base_footprint"/><child link="base"/>
  </joint>
  <link name="base">
    <inertial><mass value="3"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
    <visual><geometry><box size="0.3 0.2 0.08"/></geometry><material name="blue"/></visual>
    <collision><origin xyz="-0.05 0 0.04"/><geometry><box size="0.3 0.2 0.08"/></geometry></collision>
  </link>
  <link name="caster">
    <collision><geometry><sphere radius="0.02"/></geometry></collision>
  </link>
  <joint name="caster_joint" type="fixed">
    <origin xyz="-0.15 0 -0.03"/><parent link="base"/><child link="caster"/>
  </joint>
  <gazebo reference="caster"><mu1>0</mu1><mu2>0</mu2></gazebo>
  <gazebo reference="base"><sensor name="eye" type="camera"><pose>0.1 0 0 0 0 0</pose></sensor></gazebo>
"""


def two_wheels_urdf(plugin: str = ROS_1) -> str:
    """The text of two_wheels in URDF: the same robot, on a base_footprint, with a caster on a fixed joint."""
    wheels = "".join(_WHEEL.format(side=side, y=y) for side, y in (("left", 0.15), ("right", -0.15)))
    return f'<robot name="my-robot">\n{_BODY}{wheels}  <gazebo>{plugin}</gazebo>\n</robot>\n'


class Limb(NamedTuple):
    """A link, and the joint by which it hangs on the parent, an earlier link; kg, metres, radians.

    place, centre: x, y, z and roll, pitch, yaw of the joint in the parent, and of the inertial in the link
    """

    parent: int
    kind: str
    place: Sequence[float]
    axis: Sequence[float]
    mass: float
    centre: Sequence[float]
    size: Sequence[float]


def tree(limbs: Sequence[Limb], inside: str = "") -> str:
    """The text of a robot of limbs, called l0, l1, ..., each of them a box; the first is its root."""
    links = "".join(_link(number, limb) for number, limb in enumerate(limbs))
    joints = "".join(_joint(number, limb) for number, limb in enumerate(limbs) if number)
    return f'<robot name="tree">{inside}{links}{joints}</robot>'


def _inertia(limb: Limb) -> str:
    """The element <inertia> of a limb, that of a box."""
    x, y, z = (side**2 for side in limb.size)
    moments = (limb.mass / 12 * (y + z), 0, 0, limb.mass / 12 * (x + z), 0, limb.mass / 12 * (x + y))
    return _INERTIA.format(*map(repr, moments))


def _origin(place: Sequence[float]) -> str:
    words = [repr(float(value)) for value in place]
    return f'<origin xyz="{" ".join(words[:3])}" rpy="{" ".join(words[3:])}"/>'


def _link(number: int, limb: Limb) -> str:
    size = " ".join(map(repr, limb.size))
    shape = f'{_origin(limb.centre)}<geometry><box size="{size}"/></geometry>'
    body = f"<inertial>{_origin(limb.centre)}{_MASS.format(limb.mass)}{_inertia(limb)}</inertial>" if limb.mass else ""
    return f'<link name="l{number}">{body}<collision>{shape}</collision></link>'


def _joint(number: int, limb: Limb) -> str:
    axis = " ".join(repr(float(value)) for value in rotation(*limb.axis) @ np.array([1.0, 0.0, 0.0]))
    return (
        f'<joint name="j{number}" type="{limb.kind}">{_origin(limb.place)}<parent link="l{limb.parent}"/>'
        f'<child link="l{number}"/><axis xyz="{axis}"/><limit lower="-1" upper="2" effort="3" velocity="4"/></joint>'
    )
