"""What RViz shows: the URDF of the map and the occupancy grid, in the frame map."""

from __future__ import annotations

NAMESPACE = "step_field"
"""Of the nodes that describe the map, so that a robot's own robot_description stays free."""

RVIZ_CONFIG = f"""\
Panels:
  - Class: rviz_common/Displays
    Name: Displays
  - Class: rviz_common/Views
    Name: Views
Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz_default_plugins/RobotModel
      Name: Step field
      Enabled: true
      Value: true
      Collision Enabled: false
      Visual Enabled: true
      Description Source: Topic
      Description Topic:
        Depth: 5
        Durability Policy: Transient Local
        History Policy: Keep Last
        Reliability Policy: Reliable
        Value: /{NAMESPACE}/robot_description
    - Class: rviz_default_plugins/Map
      Name: Occupancy grid
      Enabled: true
      Value: true
      Alpha: 0.5
      Color Scheme: map
      Topic:
        Depth: 1
        Durability Policy: Transient Local
        History Policy: Keep Last
        Reliability Policy: Reliable
        Value: /map
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
