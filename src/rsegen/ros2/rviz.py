"""The configuration of RViz: the map, the robot with its frames, scan and odometry, Nav2's path, and the elevation."""

from __future__ import annotations

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
