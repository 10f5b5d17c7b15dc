"""Links and joints as values, and their SDF text, which both Gazebos read alike."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TypeAlias

from rsegen.exporters.gazebo.sdf import material, numbers
from rsegen.exporters.scene import Colour
from rsegen.simulation.robots.solids import Solid, Vector

PoseTuple: TypeAlias = tuple[float, float, float, float, float, float]
"""x, y, z, metres, then roll, pitch, yaw, radians."""

ORIGIN: PoseTuple = (0, 0, 0, 0, 0, 0)
FIRM = "<kp>1000000</kp><kd>1000</kd>"
"""Contact of ODE that neither sinks in visibly nor trembles under robots of 1 to 30 kg."""

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
        """Its <surface>."""
        along = f"<fdir1>{numbers(self.along)}</fdir1>" if self.along else ""
        friction = f"<mu>{numbers([self.mu])}</mu><mu2>{numbers([self.mu2])}</mu2>{along}"
        contact = f"<contact><ode>{self.soft}</ode></contact>" if self.soft else ""
        return f"<surface>{contact}<friction><ode>{friction}</ode></friction></surface>"


@dataclass(frozen=True, kw_only=True, slots=True)
class Part:
    """A solid at its pose in a link; without a `surface` it is visual only, without collision."""

    name: str
    solid: Solid
    pose: PoseTuple = ORIGIN
    colour: Colour = GREY
    surface: Surface | None = None

    @property
    def sdf(self) -> str:
        """Its <collision> and <visual>."""
        what = f"<pose>{numbers(self.pose)}</pose>{self.solid.geometry}"
        visual = f'        <visual name="{self.name}_seen">{what}{material(self.colour)}</visual>\n'
        if self.surface is None:
            return visual
        return f'        <collision name="{self.name}">{what}{self.surface.sdf}</collision>\n' + visual


@dataclass(frozen=True, kw_only=True, slots=True)
class Link:
    """A rigid body at its place in the model; its mass, kg, is that of the even `solid` at `centre`.

    geared: what a geared motor adds to its moment of inertia about z, kg m^2: the rotor's times the ratio squared
    """

    name: str
    mass: float
    solid: Solid
    parts: tuple[Part, ...]
    pose: PoseTuple = ORIGIN
    centre: PoseTuple = ORIGIN
    geared: float = 0

    @property
    def moments(self) -> Vector:
        """Moments of inertia about x, y and z at its centre of mass; with half of `geared` across, as a body must."""
        ixx, iyy, izz = self.solid.moments(self.mass)
        return ixx + self.geared / 2, iyy + self.geared / 2, izz + self.geared

    def sdf(self, sensors: str = "") -> str:
        """The link with its sensors."""
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
    """A hinge about `axis` of its child's frame, or a fixed joint where there is none.

    lower, upper: radians, none for a wheel; effort, rate: the most of its motor, Nm and
    rad/s; anchor: its origin in the child, metres.
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
        """Its <joint>."""
        kind = "revolute" if self.axis else "fixed"
        return f"""\
      <joint name="{self.name}" type="{kind}">
        <pose>{numbers(self.anchor)} 0 0 0</pose>
        <parent>{self.parent}</parent>
        <child>{self.child}</child>
{self._turning()}      </joint>
"""

    def _turning(self) -> str:
        if self.axis is None:
            return ""
        ends = (("lower", self.lower), ("upper", self.upper), ("effort", self.effort), ("velocity", self.rate))
        limits = "".join(f"<{tag}>{numbers([end])}</{tag}>" for tag, end in ends if end is not None)
        limit = f"<limit>{limits}</limit>" if limits else ""
        damping = f"<dynamics><damping>{numbers([self.damping])}</damping></dynamics>" if self.damping else ""
        return f"        <axis><xyz>{numbers(self.axis)}</xyz>{limit}{damping}</axis>\n"
