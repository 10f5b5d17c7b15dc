"""A wheel that turns and skids as it should in Gazebo Classic."""

from __future__ import annotations

from rsegen.simulation.robots.links import ALONG_Y, DARK, FIRM, Link, Part, Surface
from rsegen.simulation.robots.solids import Cylinder, Vector

TREAD = 0.004
"""Metres of a tyre's width that touch: in ODE a wider one stands on its outer edges, and turns too slowly."""

_AXLE: Vector = (0, 0, 1)


def wheel(  # noqa: PLR0913  # a wheel's six figures, by name
    name: str, centre: Vector, *, radius: float, width: float, mass: float, geared: float, mu: float = 1
) -> Link:
    """A wheel with its axle along y, which is its own z; friction acts along and across it however it has turned."""
    tyre, tread = Cylinder(radius=radius, length=width), Cylinder(radius=radius, length=TREAD)
    parts = (
        Part(name="tyre", solid=tyre, colour=DARK),
        Part(name="tread", solid=tread, colour=DARK, surface=Surface(mu=mu, mu2=mu, along=_AXLE, soft=FIRM)),
    )
    return Link(name=name, mass=mass, solid=tyre, pose=(*centre, *ALONG_Y), parts=parts, geared=geared)
