"""The files of a robot in a ROS 2 package: description, model for Gazebo Sim, bridge, and Nav2's parameters.

    KIND.urdf    links and joints, for robot_state_publisher and RViz       bridge.yaml   its topics, for ros_gz_bridge
    model.sdf    the same robot for Gazebo Sim, with sensors and plug-ins   nav2.yaml     its footprint and speeds

Frames, after REP 105: `odom` - `base_link` is the true pose, in 3D, of Gazebo's OdometryPublisher, whose odometry is in
the frame of the world. Wheels or tracks measure an odometry of their own, in the frame `wheel_odom`, which is no
transform: on blocks they slip, and they know no height.

The SDF has the names of plug-ins that Fortress knows too since 6.16. In URDF a link stands where its joint puts it,
while in SDF each has a pose in the model, so a joint's origin is the pose of its child in its parent's frame. The root
`base_link` is the model's origin, on the ground below the robot; it has no mass, since KDL ignores that of a root. A
hinge's anchor is left out: it lies on the axis, and moves nothing. Friction, contact and plug-ins are not in the URDF,
which has no words for them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from rsegen.gazebo.sdf import FOOTER, HEADER, numbers
from rsegen.geometry.poses import angles, rotation
from rsegen.params.numbers import decimal
from rsegen.robots.drives import element, servo_plugins, system
from rsegen.robots.links import Joint, Link, Part, SdfPose, kind_and_sizes
from rsegen.ros2.configuration import MODEL, ROBOT, bridge_yaml, robot_topics
from rsegen.standing.outlines import Outline

if TYPE_CHECKING:  # which has these files, made here
    from rsegen.robots.base import Robot

ROOT = "base_link"
"""The frame of the robot's origin, after ROS's REP 105."""

_BACKEND = "sim"
_LIDAR, _IMU = "lidar", "imu"
_IMU_RATE, _ODOMETRY_RATE, _JOINT_RATE = 100, 50, 50
"""Messages per simulated second."""

_MOST_TURN = 1.0
"""Largest turn rate, rad/s, at which Nav2 turns a robot on the spot, also one that could turn faster."""

_SPARE = 0.1
"""Metres around the outline of a robot that Nav2 keeps free if it can."""


def ros_files(robot: Robot) -> Mapping[str, str]:
    """Return the text of each file by its name."""
    about = f"topics of the {robot.kind}, between ROS and Gazebo Sim"
    motors = [servo.joint for servo in robot.servos]
    frames = {_IMU: robot.links[0].centre}  # of sensors on its first link: the IMU is in the middle of the body
    if robot.lidar:
        frames[_LIDAR] = robot.lidar.pose
    return {
        f"{robot.kind}.urdf": "".join(_urdf(robot, frames)),
        "model.sdf": _model(robot, frames),
        "bridge.yaml": bridge_yaml(about, robot_topics(lidar=robot.lidar is not None, motors=motors)),
        "nav2.yaml": _nav2(robot),
    }


def _model(robot: Robot, frames: Mapping[str, SdfPose]) -> str:
    """Return the SDF file, with sensors and plug-ins that publish what `robot_topics` bridges."""
    imu = element("pose", numbers(frames[_IMU])) + element("always_on", "true") + element("update_rate", _IMU_RATE)
    sensors = f'        <sensor name="imu" type="imu">{imu}{_published(_IMU, "imu")}</sensor>\n'
    if robot.lidar:
        sensors += robot.lidar.sdf(_BACKEND, _published(_LIDAR, "scan"))
    # What the wheels measure, then the true pose: an odometry each, with topics and frames of its own.
    wheels = element("odom_topic", f"{MODEL}/wheel_odometry") + element("tf_topic", f"{MODEL}/wheel_tf")
    wheels += element("frame_id", "wheel_odom") + element("child_frame_id", ROOT)
    true = element("odom_frame", "odom") + element("robot_base_frame", ROOT)
    true += element("odom_topic", f"{MODEL}/odometry") + element("tf_topic", f"{MODEL}/tf")
    true += element("odom_publish_frequency", _ODOMETRY_RATE) + element("dimensions", 3)
    joints = element("topic", f"{MODEL}/joint_state") + element("update_rate", _JOINT_RATE)
    plugins = (
        robot.drive.plugins(_BACKEND, wheels),
        servo_plugins(robot.servos, _BACKEND),
        system("OdometryPublisher", _BACKEND, true),
        system("JointStatePublisher", _BACKEND, joints),
    )
    return HEADER + robot.assembled(ROBOT, sensors, plugins) + FOOTER


def _published(frame: str, topic: str) -> str:
    return element("topic", f"{MODEL}/{topic}") + element("gz_frame_id", frame)


def _nav2(robot: Robot) -> str:
    outline = Outline.of(robot.body)
    corners = [(x, y) for x in (outline.low_x, outline.high_x) for y in (outline.low_y, outline.high_y)]
    # Its corners in order around it, as Nav2 wants a polygon.
    footprint = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in (corners[0], corners[2], corners[3], corners[1]))
    farthest = max(hypot(*corner) for corner in corners)
    speed, turn = robot.driving_speed, min(robot.turn, _MOST_TURN)
    return f"""\
# Nav2's parameters of the {robot.kind}, in addition to config/nav2.yaml
controller_server:
  ros__parameters:
    FollowPath:
      desired_linear_vel: {speed:.2f}
      rotate_to_heading_angular_vel: {turn:.2f}
      lookahead_dist: {max(0.3, outline.length):.2f}
behavior_server:
  ros__parameters:
    max_rotational_vel: {turn:.2f}
    min_rotational_vel: {turn / 5:.2f}
{_costmap("local", footprint, farthest)}{_costmap("global", footprint, farthest)}"""


def _costmap(name: str, footprint: str, farthest: float) -> str:
    return f"""\
{name}_costmap:
  {name}_costmap:
    ros__parameters:
      footprint: "[{footprint}]"
      inflation_layer:
        inflation_radius: {farthest + _SPARE:.2f}
"""


# URDF.


def _urdf(robot: Robot, frames: Mapping[str, SdfPose]) -> Iterator[str]:
    """Yield the URDF of a robot; frames: links without a body on its first link, such as sensors, by their names."""
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
        parent, child = links[joint.parent].pose, links[joint.child].pose
        turned = rotation(*parent[3:]).T  # into the frame of the parent
        x, y, z = (turned @ np.subtract(child[:3], parent[:3])).tolist()
        kind, turning = _turning(joint)
        origin = (x, y, z, *angles(turned @ rotation(*child[3:])))
        yield _joint(kind, joint.name, joint.parent, joint.child, origin, turning)
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
    kind, sizes = kind_and_sizes(part.solid)
    solid = " ".join([kind, *(f'{size}="{text}"' for size, text in sizes.items())])
    shape = f"{_origin(part.pose)}<geometry><{solid}/></geometry>"
    name_of_colour, rgba = numbers(part.colour).replace(" ", "_"), numbers((*part.colour, 1))
    colour = f'<material name="{name_of_colour}"><color rgba="{rgba}"/></material>'
    hit = f'    <collision name="{name}">{shape}</collision>\n' if part.surface else ""
    return f'    <visual name="{name}">{shape}{colour}</visual>\n{hit}'


def _joint(kind: str, name: str, parent: str, child: str, origin: SdfPose, turning: str = "") -> str:
    return f"""\
  <joint name="{name}" type="{kind}">
    {_origin(origin)}
    <parent link="{parent}"/>
    <child link="{child}"/>
{turning}  </joint>
"""


def _turning(joint: Joint) -> tuple[str, str]:
    """Return the type of a joint, and its axis and limits; URDF wants all four limits of a hinge that has ends."""
    if joint.axis is None:
        return "fixed", ""
    axis = f'    <axis xyz="{numbers(joint.axis)}"/>\n'
    damping = f'    <dynamics damping="{decimal(joint.damping)}"/>\n' if joint.damping else ""
    if joint.lower is None:
        return "continuous", axis + damping
    ends = {"lower": joint.lower, "upper": joint.upper, "effort": joint.effort, "velocity": joint.rate}
    limits = " ".join(f'{name}="{decimal(value or 0)}"' for name, value in ends.items())
    return "revolute", f"{axis}    <limit {limits}/>\n{damping}"


def _origin(pose: SdfPose) -> str:
    return f'<origin xyz="{numbers(pose[:3])}" rpy="{numbers(pose[3:])}"/>'
