"""Solids of even density: their SDF geometry and their moments of inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from rsegen.exporters.gazebo.sdf import numbers

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Box:
    """A box along the axes, its sides in metres."""

    size: Vector

    @property
    def geometry(self) -> str:
        """Its <geometry>."""
        return f"<geometry><box><size>{numbers(self.size)}</size></box></geometry>"

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        x, y, z = (side**2 for side in self.size)
        return mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12


@dataclass(frozen=True, kw_only=True, slots=True)
class Cylinder:
    """A cylinder along z, metres."""

    radius: float
    length: float

    @property
    def geometry(self) -> str:
        """Its <geometry>."""
        inner = f"<radius>{numbers([self.radius])}</radius><length>{numbers([self.length])}</length>"
        return f"<geometry><cylinder>{inner}</cylinder></geometry>"

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        across = mass * (3 * self.radius**2 + self.length**2) / 12
        return across, across, mass * self.radius**2 / 2


@dataclass(frozen=True, kw_only=True, slots=True)
class Sphere:
    """A sphere, metres."""

    radius: float

    @property
    def geometry(self) -> str:
        """Its <geometry>."""
        return f"<geometry><sphere><radius>{numbers([self.radius])}</radius></sphere></geometry>"

    def moments(self, mass: float) -> Vector:
        """Moments of inertia about x, y and z through its centre, kg m^2, for a mass in kg."""
        moment = 0.4 * mass * self.radius**2
        return moment, moment, moment


Solid: TypeAlias = Box | Cylinder | Sphere
