"""The files of a robot in a ROS 2 package: its description, its model for Gazebo Sim, its bridge and Nav2's parameters.

    KIND.urdf    links and joints, for robot_state_publisher and RViz       bridge.yaml   its topics, for ros_gz_bridge
    model.sdf    the same robot for Gazebo Sim, with sensors and plug-ins   nav2.yaml     its footprint and speeds

Frames, after REP 105: `odom` - `base_link` is the true pose, in 3D, of Gazebo's OdometryPublisher, whose odometry is in
the frame of the world; what wheels or tracks measure is an odometry of its own, in the frame `wheel_odom`, and no
transform: on blocks they slip, and they know no height.

The SDF has the names of plug-ins that Fortress knows too since 6.16.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from typing import TYPE_CHECKING

from rsegen.exporters.gazebo.sdf import FOOTER, HEADER, numbers
from rsegen.exporters.ros2.bridge import MODEL, ROBOT, bridge_yaml, robot_topics
from rsegen.robots.drives import element, servo_plugins, system
from rsegen.robots.links import SdfPose
from rsegen.robots.urdf_writer import ROOT, urdf
from rsegen.standing.spots import Outline

if TYPE_CHECKING:  # which has these files, made here
    from rsegen.robots.base import Robot

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
    return {
        f"{robot.kind}.urdf": urdf(robot, _frames(robot)),
        "model.sdf": _model(robot),
        "bridge.yaml": bridge_yaml(about, robot_topics(lidar=robot.lidar is not None, motors=motors)),
        "nav2.yaml": _nav2(robot),
    }


def _frames(robot: Robot) -> Mapping[str, SdfPose]:
    """Return the poses of its sensors on its first link: the IMU in the middle of the body."""
    frames = {_IMU: robot.links[0].centre}
    return frames | {_LIDAR: robot.lidar.pose} if robot.lidar else frames


def _model(robot: Robot) -> str:
    """Return the SDF file, with sensors and plug-ins that publish what `robot_topics` bridges."""
    odometry = (
        element("odom_topic", f"{MODEL}/wheel_odometry")
        + element("tf_topic", f"{MODEL}/wheel_tf")
        + element("frame_id", "wheel_odom")
        + element("child_frame_id", ROOT)
    )
    plugins = (
        robot.drive.plugins(_BACKEND, odometry),
        servo_plugins(robot.servos, _BACKEND),
        _true_odometry(),
        system(
            "JointStatePublisher",
            _BACKEND,
            element("topic", f"{MODEL}/joint_state") + element("update_rate", _JOINT_RATE),
        ),
    )
    return HEADER + robot.assembled(ROBOT, _sensors(robot), plugins) + FOOTER


def _true_odometry() -> str:
    frames = element("odom_frame", "odom") + element("robot_base_frame", ROOT)
    topics = element("odom_topic", f"{MODEL}/odometry") + element("tf_topic", f"{MODEL}/tf")
    rate = element("odom_publish_frequency", _ODOMETRY_RATE)
    return system("OdometryPublisher", _BACKEND, frames + topics + rate + element("dimensions", 3))


def _sensors(robot: Robot) -> str:
    pose = element("pose", numbers(_frames(robot)[_IMU]))
    inside = pose + element("always_on", "true") + element("update_rate", _IMU_RATE) + _published(_IMU, "imu")
    imu = f'        <sensor name="imu" type="imu">{inside}</sensor>\n'
    return imu + (robot.lidar.sdf(_BACKEND, _published(_LIDAR, "scan")) if robot.lidar else "")


def _published(frame: str, topic: str) -> str:
    return element("topic", f"{MODEL}/{topic}") + element("gz_frame_id", frame)


def _nav2(robot: Robot) -> str:
    outline = Outline.of(robot.body)
    corners = [(x, y) for x in (outline.low_x, outline.high_x) for y in (outline.low_y, outline.high_y)]
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
