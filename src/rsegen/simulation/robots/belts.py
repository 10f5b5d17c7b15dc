"""The collision shapes of a belt round two equal wheels."""

from __future__ import annotations

from rsegen.simulation.robots.links import ALONG_Y, DARK, FIRM, Part, Surface
from rsegen.simulation.robots.solids import Box, Cylinder

SLACK = 0.001
"""Metres by which the belt between its wheels lies inside them: on a floor only the wheels are in contact."""


def belt(rear: float, front: float, *, radius: float, width: float, mu: float, mu2: float) -> tuple[Part, ...]:
    """A belt round wheels of one radius at x = rear and x = front of its link; friction mu along it, mu2 across."""
    surface = _grip(mu, mu2)
    run = Box(size=(front - rear, width, 2 * (radius - SLACK)))
    end = Cylinder(radius=radius, length=width)
    return (
        Part(name="run", solid=run, pose=((rear + front) / 2, 0, 0, 0, 0, 0), colour=DARK, surface=surface),
        Part(name="rear", solid=end, pose=(rear, 0, 0, *ALONG_Y), colour=DARK, surface=surface),
        Part(name="front", solid=end, pose=(front, 0, 0, *ALONG_Y), colour=DARK, surface=surface),
    )


def road(x: float, *, radius: float, width: float, mu: float, mu2: float) -> Part:
    """A wheel inside the belt, at x; where it is lower than the ends the robot stands on it, and turns more easily."""
    name = f"road_{'front' if x > 0 else 'rear'}"
    wheel = Cylinder(radius=radius, length=width)
    return Part(name=name, solid=wheel, pose=(x, 0, 0, *ALONG_Y), colour=DARK, surface=_grip(mu, mu2))


def _grip(mu: float, mu2: float) -> Surface:
    return Surface(mu=mu, mu2=mu2, along=(1, 0, 0), soft=FIRM)
