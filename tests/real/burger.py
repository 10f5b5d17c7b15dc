"""A robot like the TurtleBot3 Burger, and how far off its course it gets.

Sizes, masses and contacts are those of its maker's Gazebo model (turtlebot3_gazebo, model.sdf), and so are the wheels'
inertias; the body's inertia, which is some 300 times too large there, is that of turtlebot3_description. Its soft
wheels sink 1 mm into what they stand on, so every seam between coplanar triangles can be a bump to them.

Two things are ours, so that nothing but the ground can turn it: its caster slides without friction, and its tyres'
friction acts along and across each wheel instead of along the axes of the world.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import NamedTuple

from rsegen.robots.drives import system
from rsegen.simulators.poses import Pose

SPEED = 0.22
"""Metres a second: the most that the real one does."""

RADIUS = 0.033
"""Of a wheel, metres."""

EVERYTHING = 0xFFFF
"""Gazebo's own mask of a collision that has none."""

_CLEARANCE = 0.010
_SOFT = "<kp>100000</kp><kd>1</kd><max_vel>0.01</max_vel><min_depth>0.001</min_depth>"
_SLIDING = "<friction><ode><mu>0</mu><mu2>0</mu2></ode></friction>"
_GRIPPING = "<friction><ode><mu>100000</mu><mu2>100000</mu2><fdir1>0 0 1</fdir1></ode></friction>"


class Wheels(NamedTuple):
    """Shape of a wheel, its contact parameters for ODE, friction, moments of inertia, and gain of the motor.

    moments: about x, y and the axle z, kg m^2; gain: Nm for each rad/s that the wheel is too slow.
    """

    shape: str = f"<cylinder><radius>{RADIUS}</radius><length>0.018</length></cylinder>"
    contact: str = _SOFT
    friction: str = _GRIPPING
    moments: tuple[float, float, float] = (0.00182, 0.00329, 0.00182)
    gain: float = 1


BURGER_WHEELS = Wheels()


class Start(NamedTuple):
    """Place of the middle of the axle at first, the height that it stands on, metres, and the heading, radians."""

    x: float
    y: float
    ground: float
    heading: float


class Way(NamedTuple):
    """Distances that something has come along its first heading and to the left of it, metres."""

    ahead: float
    aside: float


def way(start: Start, end: Pose) -> Way:
    """The way from the start to where it is now."""
    dx, dy, heading = end.x - start.x, end.y - start.y, start.heading
    return Way(dx * cos(heading) + dy * sin(heading), dy * cos(heading) - dx * sin(heading))


def burger(
    name: str, start: Start, wheels: Wheels = BURGER_WHEELS, mask: int = EVERYTHING, backend: str = "classic"
) -> str:
    """The robot as SDF; from the first step on both wheels are to turn for SPEED, straight ahead.

    Its caster has its wheels' contact. It touches only what has a bit of `mask` in its own mask.
    """
    return f"""\
    <model name="{name}">
      <pose>{start.x} {start.y} {start.ground + _CLEARANCE} 0 0 {start.heading}</pose>
      <link name="body">
        {_inertial("-0.032 0 0.070", 0.826, (0.00221, 0.00212, 0.00201))}
        <collision name="box">
          <pose>-0.032 0 0.070 0 0 0</pose>
          <geometry><box><size>0.140 0.140 0.140</size></box></geometry>
          {_surface("", "", mask)}
        </collision>
      </link>
      <link name="lidar">
        {_inertial("-0.020 0 0.161", 0.114, (0.001, 0.001, 0.001))}
      </link>
      <joint name="mast" type="fixed"><parent>body</parent><child>lidar</child></joint>
      <link name="caster">
        <pose>-0.081 0 -0.004 0 0 0</pose>
        {_inertial("0 0 0", 0.005, (0.001, 0.001, 0.001))}
        <collision name="ball">
          <geometry><sphere><radius>0.005</radius></sphere></geometry>
          {_surface(wheels.contact, _SLIDING, mask)}
        </collision>
      </link>
      <joint name="socket" type="ball"><parent>body</parent><child>caster</child></joint>
{_wheel("left", 0.080, wheels, mask)}{_wheel("right", -0.080, wheels, mask)}\
{_motors(backend, wheels.gain)}    </model>
"""


def _wheel(side: str, y: float, wheels: Wheels, mask: int) -> str:
    return f"""\
      <link name="{side}_wheel">
        <pose>0 {y} 0.023 {-pi / 2} 0 0</pose>
        {_inertial("0 0 0", 0.0285, wheels.moments)}
        <collision name="tyre">
          <geometry>{wheels.shape}</geometry>
          {_surface(wheels.contact, wheels.friction, mask)}
        </collision>
      </link>
      <joint name="{side}_axle" type="revolute">
        <parent>body</parent>
        <child>{side}_wheel</child>
        <axis><xyz>0 0 1</xyz></axis>
      </joint>
"""


def _surface(contact: str, friction: str, mask: int) -> str:
    touching = f"<contact><collide_bitmask>{mask}</collide_bitmask><ode>{contact}</ode></contact>"
    return f"<surface>{touching}{friction}</surface>"


def _motors(backend: str, gain: float) -> str:
    """Both wheels are to turn for SPEED; Gazebo Sim's motors are as strong as need be."""
    joints, turn = ("left_axle", "right_axle"), SPEED / RADIUS
    if backend == "classic":
        each = (f"<joint>{joint}</joint><target>{turn}</target><pid_gains>{gain} 0 0</pid_gains>" for joint in joints)
        motors = "".join(f'<controller type="velocity">{motor}</controller>' for motor in each)
        return f'      <plugin name="drive" filename="libJointControlPlugin.so">{motors}</plugin>\n'
    each = (f"<joint_name>{joint}</joint_name><initial_velocity>{turn}</initial_velocity>" for joint in joints)
    return "".join(system("JointController", backend, motor) for motor in each)


def _inertial(centre: str, mass: float, moments: tuple[float, float, float]) -> str:
    """Centre of mass, kg, and moments of inertia about x, y and z, kg m^2."""
    ixx, iyy, izz = moments
    inertia = f"<inertia><ixx>{ixx}</ixx><iyy>{iyy}</iyy><izz>{izz}</izz></inertia>"
    return f"<inertial><pose>{centre} 0 0 0</pose><mass>{mass}</mass>{inertia}</inertial>"
