"""The robot of two_wheels as makers ship robots for ROS 2: packages, Xacro, ros2_control, a controller, meshes.

Its wheels mirror each other, so their axes point to different sides, and its caster's mesh is in a package.
"""

from __future__ import annotations

from pathlib import Path

PACKAGE = '<?xml version="1.0"?>\n<package format="3"><name>{}</name><version>1.0.0</version></package>\n'

_ROBOT = """\
<?xml version="1.0"?>
<robot name="rover" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="laser" default="false"/>
  <xacro:arg name="mass" default="3"/>
  <xacro:include filename="$(find rover_description)/urdf/wheel.xacro"/>
  <xacro:include filename="$(find somebodys_lasers)/urdf/laser.xacro"/>
  <xacro:if value="$(arg laser)"><xacro:laser parent="base"/></xacro:if>
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed">
    <origin xyz="0 0 0.02"/><parent link="base_footprint"/><child link="base"/>
  </joint>
  <link name="base">
    <inertial><mass value="$(arg mass)"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
    <collision><origin xyz="-0.05 0 0.04"/><geometry><box size="0.3 0.2 0.08"/></geometry></collision>
  </link>
  <link name="caster">
    <collision><geometry>
      <mesh filename="package://rover_description/meshes/caster.obj" scale="0.001 0.001 0.001"/>
    </geometry></collision>
  </link>
  <joint name="caster_joint" type="fixed">
    <origin xyz="-0.15 0 -0.03"/><parent link="base"/><child link="caster"/>
  </joint>
  <gazebo reference="caster"><mu1>0</mu1><mu2>0</mu2></gazebo>
  <xacro:rover_wheel side="left" reflect="1"/>
  <xacro:rover_wheel side="right" reflect="-1"/>
  <ros2_control name="GazeboSystem" type="system">
    <hardware><plugin>gazebo_ros2_control/GazeboSystem</plugin></hardware>
    <joint name="left_hub"><command_interface name="velocity"><param name="max">8</param></command_interface></joint>
    <joint name="right_hub"><command_interface name="velocity"><param name="max">8</param></command_interface></joint>
  </ros2_control>
  <gazebo>
    <plugin name="control" filename="libgazebo_ros2_control.so">{parameters}</plugin>
  </gazebo>
</robot>
"""

_WHEEL = """\
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="rover_wheel" params="side reflect">
    <link name="${side}_wheel">
      <inertial><mass value="0.2"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="8e-4"/></inertial>
      <collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision>
    </link>
    <joint name="${side}_hub" type="continuous">
      <origin xyz="0 ${reflect*0.15} 0" rpy="${-reflect*pi/2} 0 0"/>
      <parent link="base"/><child link="${side}_wheel"/><axis xyz="0 0 1"/>
    </joint>
    <gazebo reference="${side}_wheel"><mu1>1</mu1><mu2>1</mu2></gazebo>
  </xacro:macro>
</robot>
"""

CONTROLLER = """\
controller_manager:
  ros__parameters:
    rover_controller: {type: diff_drive_controller/DiffDriveController}
rover_controller:
  ros__parameters:
    left_wheel_names: [left_hub]
    right_wheel_names: [right_hub]
    wheel_separation: 0.3
    wheel_radius: 0.05
    linear.x.has_velocity_limits: true
    linear.x.max_velocity: 0.35
    angular.z.max_velocity: 1.25
"""

OTHER = "some_controller:\n  ros__parameters: {left_wheel_names: [other_left], right_wheel_names: [other_right]}\n"
"""A controller of another robot."""


def makers_robot(workspace: Path, controller: str | None = CONTROLLER) -> Path:
    """Write the packages of the robot, two of them in a clone of another name, and return the path of its file."""
    description, control = workspace / "src/rover-humble/rover-main", workspace / "src/rover-humble/rover_control"
    for folder, name in ((description, "rover_description"), (control, "rover_control")):
        (folder / "config").mkdir(parents=True)
        (folder / "package.xml").write_text(PACKAGE.format(name))
    for inner in ("urdf", "meshes"):
        (description / inner).mkdir()
    parameters = "<parameters>$(find rover_control)/config/rover.yaml</parameters>" if controller is not None else ""
    file = description / "urdf/rover.urdf.xacro"
    file.write_text(_ROBOT.format(parameters=parameters))
    (description / "urdf/wheel.xacro").write_text(_WHEEL)
    (description / "meshes/caster.obj").write_text(_octahedron(20))
    (control / "config/a.yaml").write_text(OTHER)
    if controller is not None:
        (control / "config/rover.yaml").write_text(controller)
    return file


def _octahedron(radius: int) -> str:
    """An OBJ file in millimetres: a point below, so that it touches the ground as a ball does."""
    corners = [(radius, 0, 0), (0, radius, 0), (-radius, 0, 0), (0, -radius, 0), (0, 0, radius), (0, 0, -radius)]
    sides = [(a + 1, (a + 1) % 4 + 1) for a in range(4)]
    faces = [(a, b, 5) for a, b in sides] + [(b, a, 6) for a, b in sides]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    # Gazebo shows no face without a normal.
    lines += [f"vn {x} {y} {z}" for x, y, z in ((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    return "\n".join([*lines, *("f " + " ".join(f"{n}//{n}" for n in face) for face in faces)]) + "\n"
