"""The configurations of ros_gz_bridge and of RViz: which topics there are, and which of them are shown.

A file of ros_gz_bridge's parameter_bridge says which topics of Gazebo Sim are topics of ROS, with their types. Topics
of a robot are those that Gazebo's plug-ins take by default for a model of the name `robot`, so that a robot of the user
is bridged too. Types are written `gz.msgs.*`, which the bridges of Humble and of all later distributions take. RViz
shows the map, the robot with its frames, scan and odometry, Nav2's path, and the elevation.
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


NAMESPACE = "step_field"
"""Namespace of the nodes that describe the map, so that a robot's own robot_description stays free."""


def _display(kind: str, name: str, body: str, *, enabled: bool = True) -> str:
    shown = str(enabled).lower()
    return f"""\
    - Class: {kind}
      Name: {name}
      Enabled: {shown}
      Value: {shown}
{body}"""


def _topic(value: str, *, latched: bool = False, reliable: bool = True, key: str = "Topic", depth: int = 5) -> str:
    return f"""\
      {key}:
        Depth: {depth}
        Durability Policy: {"Transient Local" if latched else "Volatile"}
        History Policy: Keep Last
        Reliability Policy: {"Reliable" if reliable else "Best Effort"}
        Value: {value}
"""


def _model(description: str) -> str:
    shown = "      Collision Enabled: false\n      Visual Enabled: true\n      Description Source: Topic\n"
    return shown + _topic(description, latched=True, key="Description Topic")


_DISPLAYS = (
    _display("rviz_default_plugins/RobotModel", "Step field", _model(f"/{NAMESPACE}/robot_description")),
    _display("rviz_default_plugins/RobotModel", "Robot", _model("/robot_description")),
    _display(
        "rviz_default_plugins/Map",
        "Occupancy grid",
        "      Alpha: 0.5\n      Color Scheme: map\n" + _topic("/map", latched=True, depth=1),
    ),
    _display("rviz_default_plugins/TF", "Frames", "      Marker Scale: 0.3\n      Show Names: false\n"),
    _display("rviz_default_plugins/LaserScan", "Scan", "      Size (m): 0.02\n" + _topic("/scan", reliable=False)),
    _display("rviz_default_plugins/Odometry", "Odometry", "      Keep: 50\n" + _topic("/odom")),
    _display("rviz_default_plugins/Path", "Path of Nav2", _topic("/plan")),
    _display(
        "rviz_default_plugins/Map",
        "Costmap of Nav2",
        "      Alpha: 0.5\n      Color Scheme: costmap\n" + _topic("/global_costmap/costmap", latched=True, depth=1),
        enabled=False,
    ),
    _display(
        "grid_map_rviz_plugin/GridMap",
        "Elevation",
        "      Height Layer: elevation\n      Color Layer: elevation\n      Show Grid Lines: false\n"
        + _topic("/elevation", latched=True, depth=1),
    ),
)

RVIZ_CONFIG = f"""\
Panels:
  - Class: rviz_common/Displays
    Name: Displays
  - Class: rviz_common/Views
    Name: Views
Visualization Manager:
  Class: ""
  Displays:
{"".join(_DISPLAYS)}\
  Enabled: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: map
    Frame Rate: 30
  Name: root
  Tools:
    - Class: rviz_default_plugins/MoveCamera
    - Class: rviz_default_plugins/Select
    - Class: rviz_default_plugins/Measure
    - Class: rviz_default_plugins/SetGoal
      Topic:
        Value: /goal_pose
  Value: true
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Distance: 5
      Name: Current View
      Pitch: 0.8
      Value: Orbit (rviz)
      Yaw: 4.2
    Saved: ~
"""
