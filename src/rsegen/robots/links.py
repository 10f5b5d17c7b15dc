"""Links and joints of robots as values, and their SDF text, which both Gazebos read alike.

A link has the mass and moments of inertia of a solid of even density, and parts that are seen and hit: boxes, cylinders
and spheres, no meshes, and preferably spheres: in ODE one on a mesh costs a small part of what a box does. Wheels,
belts and a lidar are made of these, with what each Gazebo needs for them to roll, skid and scan as real ones
(docs/robots.md).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi
from typing import TypeAlias

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.gazebo.sdf import material, numbers
from rsegen.geometry.poses import pose_matrix, rotation
from rsegen.robots.drives import element
from rsegen.scene.colours import Colour

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Box:
    """A box along the axes, its sides in metres."""

    size: Vector

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        x, y, z = (side**2 for side in self.size)
        return mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12


@dataclass(frozen=True, kw_only=True, slots=True)
class Cylinder:
    """A cylinder along z, metres."""

    radius: float
    length: float

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        across = mass * (3 * self.radius**2 + self.length**2) / 12
        return across, across, mass * self.radius**2 / 2


@dataclass(frozen=True, kw_only=True, slots=True)
class Sphere:
    """A sphere, metres."""

    radius: float

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        moment = 0.4 * mass * self.radius**2
        return moment, moment, moment


Solid: TypeAlias = Box | Cylinder | Sphere


def kind_and_sizes(solid: Solid) -> tuple[str, dict[str, str]]:
    """Return the tag of a solid in SDF and URDF, and the text of each of its sizes by its name."""
    # The classes and their fields are named as the elements of SDF and URDF are.
    sizes = {size.name: numbers(np.ravel(getattr(solid, size.name))) for size in fields(solid)}
    return type(solid).__name__.lower(), sizes


SdfPose: TypeAlias = tuple[float, float, float, float, float, float]
"""x, y, z, metres, then roll, pitch, yaw, radians."""

ORIGIN: SdfPose = (0, 0, 0, 0, 0, 0)
FIRM = "<kp>1000000</kp><kd>1000</kd>"
"""Contact of ODE that neither sinks in visibly nor trembles under robots of 1 to 30 kg.

With kp 1e5 and kd 1, as the maker's TurtleBot3 has, a wheel sinks in by 1 mm, and edges of coplanar triangles are
bumps.
"""

GROUND_FRICTION = 1.0
"""Friction of the ground: simulators take the smaller of two, so more of a robot's own has no effect."""

ALONG_Y: Vector = (-pi / 2, 0, 0)
"""Roll, pitch and yaw that lay a cylinder's axis along y, its z to the left."""

DARK: Colour = (0.12, 0.12, 0.13)
GREY: Colour = (0.45, 0.46, 0.48)


@dataclass(frozen=True, kw_only=True, slots=True)
class Surface:
    """Friction and contact parameters of a surface in Gazebo Classic's ODE; Gazebo Sim reads the friction.

    mu along `along` (in the frame of its part; by default the engine's own choice), mu2 across it.
    """

    mu: float
    mu2: float
    along: Vector | None = None
    soft: str = ""

    @property
    def sdf(self) -> str:
        """The <surface>."""
        along = f"<fdir1>{numbers(self.along)}</fdir1>" if self.along else ""
        friction = f"<mu>{numbers([self.mu])}</mu><mu2>{numbers([self.mu2])}</mu2>{along}"
        contact = f"<contact><ode>{self.soft}</ode></contact>" if self.soft else ""
        return f"<surface>{contact}<friction><ode>{friction}</ode></friction></surface>"


@dataclass(frozen=True, kw_only=True, slots=True)
class Part:
    """A solid at its pose in a link; without a `surface` it is visual only, without collision."""

    name: str
    solid: Solid
    pose: SdfPose = ORIGIN
    colour: Colour = GREY
    surface: Surface | None = None

    @property
    def sdf(self) -> str:
        """The <collision> and <visual>."""
        kind, sizes = kind_and_sizes(self.solid)
        geometry = element("geometry", element(kind, "".join(element(*size) for size in sizes.items())))
        shape = f"<pose>{numbers(self.pose)}</pose>{geometry}"
        visual = f'        <visual name="{self.name}_seen">{shape}{material(self.colour)}</visual>\n'
        if self.surface is None:
            return visual
        return f'        <collision name="{self.name}">{shape}{self.surface.sdf}</collision>\n' + visual


@dataclass(frozen=True, kw_only=True, slots=True)
class Link:
    """A rigid body at its place in the model; its mass, kg, is spread evenly over `solid`, whose pose is `centre`.

    geared: what a geared motor adds to its moment of inertia about z, kg m^2: the rotor's times the ratio squared
    """

    name: str
    mass: float
    solid: Solid
    parts: tuple[Part, ...]
    pose: SdfPose = ORIGIN
    centre: SdfPose = ORIGIN
    geared: float = 0

    @property
    def moments(self) -> Vector:
        """Moments of inertia about x, y and z at its centre of mass, kg m^2, with those of its geared motor."""
        # Half of what the motor adds about z is added across: no body has izz > ixx + iyy, and engines refuse it.
        ixx, iyy, izz = self.solid.moments(self.mass)
        return ixx + self.geared / 2, iyy + self.geared / 2, izz + self.geared

    def sdf(self, sensors: str = "") -> str:
        """Return the link with its sensors."""
        ixx, iyy, izz = self.moments
        moments = f"<ixx>{ixx:.9g}</ixx><iyy>{iyy:.9g}</iyy><izz>{izz:.9g}</izz>"
        return f"""\
      <link name="{self.name}">
        <pose>{numbers(self.pose)}</pose>
        <inertial>
          <pose>{numbers(self.centre)}</pose>
          <mass>{numbers([self.mass])}</mass>
          <inertia>{moments}<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>
        </inertial>
{"".join(part.sdf for part in self.parts)}{sensors}      </link>
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Joint:
    """A hinge about `axis` of its child's frame, or a fixed joint if there is no axis.

    lower, upper: radians, none for a wheel; effort, rate: the most of its motor, Nm and rad/s; anchor: its origin in
    the child, metres.
    """

    name: str
    parent: str
    child: str
    axis: Vector | None = None
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    rate: float | None = None
    damping: float = 0
    anchor: Vector = (0, 0, 0)

    @property
    def sdf(self) -> str:
        """The <joint>."""
        kind, axis = "fixed", ""
        if self.axis:
            ends = (("lower", self.lower), ("upper", self.upper), ("effort", self.effort), ("velocity", self.rate))
            limits = "".join(f"<{tag}>{numbers([end])}</{tag}>" for tag, end in ends if end is not None)
            limit = f"<limit>{limits}</limit>" if limits else ""
            damping = f"<dynamics><damping>{numbers([self.damping])}</damping></dynamics>" if self.damping else ""
            kind, axis = "revolute", f"        <axis><xyz>{numbers(self.axis)}</xyz>{limit}{damping}</axis>\n"
        return f"""\
      <joint name="{self.name}" type="{kind}">
        <pose>{numbers(self.anchor)} 0 0 0</pose>
        <parent>{self.parent}</parent>
        <child>{self.child}</child>
{axis}      </joint>
"""


def posed(pose: SdfPose) -> Array:
    """Return a pose as a matrix (4, 4)."""
    return pose_matrix(pose[:3], rotation(*pose[3:]))


TREAD = 0.004
"""Width of a tyre that has contact, metres: in ODE a wider one stands on its outer edges, and turns too slowly."""

_AXLE: Vector = (0, 0, 1)


def wheel(  # noqa: PLR0913  # a wheel's six figures, by name
    name: str, centre: Vector, *, radius: float, width: float, mass: float, geared: float, mu: float = 1
) -> Link:
    """Return a wheel with its axle, its own z, along y; friction acts along and across it however it has turned."""
    tyre, tread = Cylinder(radius=radius, length=width), Cylinder(radius=radius, length=TREAD)
    parts = (
        Part(name="tyre", solid=tyre, colour=DARK),
        Part(name="tread", solid=tread, colour=DARK, surface=Surface(mu=mu, mu2=mu, along=_AXLE, soft=FIRM)),
    )
    return Link(name=name, mass=mass, solid=tyre, pose=(*centre, *ALONG_Y), parts=parts, geared=geared)


SLACK = 0.001
"""Depth, metres, of the belt inside its wheels' circles: on a floor only the wheels are in contact."""


def belt(rear: float, front: float, *, radius: float, width: float, surface: Surface) -> tuple[Part, ...]:
    """Return a belt round equal wheels at x = rear and x = front of its link."""
    run = Box(size=(front - rear, width, 2 * (radius - SLACK)))
    end = Cylinder(radius=radius, length=width)
    return (
        Part(name="run", solid=run, pose=((rear + front) / 2, 0, 0, 0, 0, 0), colour=DARK, surface=surface),
        Part(name="rear", solid=end, pose=(rear, 0, 0, *ALONG_Y), colour=DARK, surface=surface),
        Part(name="front", solid=end, pose=(front, 0, 0, *ALONG_Y), colour=DARK, surface=surface),
    )


def road(x: float, *, radius: float, width: float, surface: Surface) -> Part:
    """Return a wheel inside the belt, at x; if lower than the ends, the robot stands on it and turns easily."""
    name = f"road_{'front' if x > 0 else 'rear'}"
    wheel = Cylinder(radius=radius, length=width)
    return Part(name=name, solid=wheel, pose=(x, 0, 0, *ALONG_Y), colour=DARK, surface=surface)


@dataclass(frozen=True, kw_only=True, slots=True)
class Lidar:
    """A plane of rays round its z axis; nearest and farthest, metres; rate in Hz; place in the robot's first link."""

    pose: SdfPose
    rays: int
    nearest: float
    farthest: float
    rate: float

    def sdf(self, simulator: str, publishing: str = "") -> str:
        """Return its <sensor>: `ray` in Classic; `gpu_lidar`, the only one that Gazebo Sim computes, there.

        publishing: elements with its topic and frame
        """
        kind, tag = ("ray", "ray") if simulator == "classic" else ("gpu_lidar", "lidar")
        # A full circle, whose last ray is not the first one again.
        circle = element("min_angle", 0) + element("max_angle", 2 * pi - 2 * pi / self.rays)
        scan = element("scan", element("horizontal", element("samples", self.rays) + circle))
        limits = element("range", element("min", self.nearest) + element("max", self.farthest))
        pose = element("pose", " ".join(map(str, self.pose)))
        inside = pose + element("always_on", "true") + element("update_rate", self.rate) + element(tag, scan + limits)
        inside += publishing
        return f'        <sensor name="lidar" type="{kind}">{inside}</sensor>\n'
