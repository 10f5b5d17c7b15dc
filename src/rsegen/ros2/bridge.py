"""The files of ros_gz_bridge's parameter_bridge: which topics of Gazebo Sim are topics of ROS, with their types.

Topics of a robot are those that Gazebo's plug-ins take by default for a model of the name `robot`, so that a robot of
the user is bridged too. Types are written `gz.msgs.*`, which the bridges of Humble and of all later distributions take.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

ROBOT = "robot"
"""Name of a robot's model in Gazebo Sim, which its topics contain."""

MODEL = f"/model/{ROBOT}"


class Topic(NamedTuple):
    """A topic of ROS, its type, the topic of Gazebo Sim and its type there without `gz.msgs.`; by default to ROS."""

    ros: str
    ros_type: str
    gz: str
    gz_type: str
    direction: str = "GZ_TO_ROS"


CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock", "/clock", "Clock")

_DRIVE = (
    Topic("/cmd_vel", "geometry_msgs/msg/Twist", f"{MODEL}/cmd_vel", "Twist", "ROS_TO_GZ"),
    Topic("/odom", "nav_msgs/msg/Odometry", f"{MODEL}/odometry", "Odometry"),
    Topic("/wheel_odometry", "nav_msgs/msg/Odometry", f"{MODEL}/wheel_odometry", "Odometry"),
    Topic("/tf", "tf2_msgs/msg/TFMessage", f"{MODEL}/tf", "Pose_V"),
    Topic("/joint_states", "sensor_msgs/msg/JointState", f"{MODEL}/joint_state", "Model"),
    Topic("/imu", "sensor_msgs/msg/Imu", f"{MODEL}/imu", "IMU"),
)
_SCAN = Topic("/scan", "sensor_msgs/msg/LaserScan", f"{MODEL}/scan", "LaserScan")


def robot_topics(*, lidar: bool = True, motors: Iterable[str] = ()) -> tuple[Topic, ...]:
    """Return the topics of a robot; motors: joints that are turned to an angle, radians."""
    angles = (
        Topic(f"/{joint}/angle", "std_msgs/msg/Float64", f"{MODEL}/joint/{joint}/0/cmd_pos", "Double", "ROS_TO_GZ")
        for joint in motors
    )
    return (*_DRIVE, *([_SCAN] if lidar else []), *angles)


def bridge_yaml(about: str, topics: Iterable[Topic]) -> str:
    """Return the text of a file that begins with what it is about."""
    return f"# {about}\n" + "".join(
        f"""\
- ros_topic_name: {topic.ros}
  ros_type_name: {topic.ros_type}
  gz_topic_name: {topic.gz}
  gz_type_name: gz.msgs.{topic.gz_type}
  direction: {topic.direction}
"""
        for topic in topics
    )
