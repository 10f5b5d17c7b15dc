"""A small robot of two wheels and a ball as SDF, with the plug-in of a drive as people write it."""

from __future__ import annotations

import re

RADIUS, SEPARATION = 0.05, 0.3

_BODY = """\
    <link name="base">
      <pose>0 0 0.02 0 0 0</pose>
      <inertial><mass>3</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz></inertia></inertial>
      <collision name="hull">
        <pose>-0.05 0 0.04 0 0 0</pose><geometry><box><size>0.3 0.2 0.08</size></box></geometry>
      </collision>
      <collision name="ball">
        <pose>-0.15 0 -0.03 0 0 0</pose><geometry><sphere><radius>0.02</radius></sphere></geometry>
        <surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>
      </collision>
      <sensor name="eye" type="camera"><plugin name="eye" filename="libgazebo_ros_camera.so"/></sensor>
    </link>
"""

_WHEEL = """\
    <link name="{side}_wheel">
      <pose>0 {y} 0.02 -1.5707963267948966 0 0</pose>
      <inertial><mass>0.2</mass><inertia><ixx>0.0005</ixx><iyy>0.0005</iyy><izz>0.0008</izz></inertia></inertial>
      <collision name="tyre">
        <geometry><cylinder><radius>0.05</radius><length>0.02</length></cylinder></geometry>
        <surface><friction><ode><mu>1</mu><mu2>1</mu2></ode></friction></surface>
      </collision>
    </link>
    <joint name="{side}_hub" type="revolute">
      <parent>base</parent><child>{side}_wheel</child><axis><xyz>0 0 {axis}</xyz></axis>
    </joint>
"""

ROS_1 = """\
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so">
      <leftJoint>left_hub</leftJoint><rightJoint>right_hub</rightJoint>
      <wheelSeparation>0.3</wheelSeparation><wheelDiameter>0.1</wheelDiameter><torque>5</torque>
    </plugin>
    <plugin name="joints" filename="libgazebo_ros_joint_state_publisher.so"/>
"""

ROS_2 = """\
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so">
      <left_joint>left_hub</left_joint><right_joint>right_hub</right_joint>
      <wheel_separation>0.3</wheel_separation><wheel_diameter>0.1</wheel_diameter>
      <max_wheel_torque>20</max_wheel_torque><command_topic>cmd_vel</command_topic>
    </plugin>
"""

CLASSIC = """\
    <plugin name="drive" filename="libDiffDrivePlugin.so">
      <left_joint>left_hub</left_joint><right_joint>right_hub</right_joint>
    </plugin>
"""

GZ = """\
    <plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
      <left_joint>left_hub</left_joint><right_joint>right_hub</right_joint>
      <wheel_separation>0.3</wheel_separation><wheel_radius>0.05</wheel_radius>
      <max_linear_velocity>0.3</max_linear_velocity><max_angular_velocity>1.5</max_angular_velocity>
      <topic>cmd_vel</topic>
    </plugin>
"""

IGNITION = GZ.replace("gz-sim-", "libignition-gazebo-").replace("gz::sim", "ignition::gazebo")

PLUGINS = {"ros1": ROS_1, "ros2": ROS_2, "classic": CLASSIC, "gz": GZ, "ignition": IGNITION, "none": ""}


def two_wheels(plugin: str = "", version: str = "1.6", axis: int = 1) -> str:
    """The text of its file; axis: 1 if the wheels' axes point to the left, -1 to the right."""
    wheels = "".join(_WHEEL.format(side=side, y=y, axis=axis) for side, y in (("left", 0.15), ("right", -0.15)))
    return f'<sdf version="{version}"><model name="my-robot">\n{_BODY}{wheels}{plugin}  </model></sdf>\n'


MAST = """\
    <link name="mast">
      <pose>0 0 0.15 0 0 0</pose>
      <inertial><mass>0.01</mass><inertia><ixx>1e-5</ixx><iyy>1e-5</iyy><izz>1e-5</izz></inertia></inertial>
    </link>
    <joint name="foot" type="fixed"><parent>inner::base</parent><child>mast</child></joint>
"""


def in_a_nested_model(text: str) -> str:
    """Return a robot inside another model with a mast on it, as people add parts to the robot of a maker."""
    text = re.sub("<model name=[^>]*>", '<model name="outer"><model name="inner">', text, count=1)
    return f"{MAST}</model>".join(text.replace("</model>", "</model></model>").rsplit("</model>", 1))
