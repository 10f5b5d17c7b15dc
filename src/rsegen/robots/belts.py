"""A belt round two equal wheels, as it touches."""

from __future__ import annotations

from rsegen.robots.links import ALONG_Y, DARK, FIRM, Part, Touch
from rsegen.robots.solids import Box, Cylinder, Vector

SLACK = 0.001
"""Metres by which the belt between its wheels lies inside them: on a floor the wheels alone touch it."""

_ALONG: Vector = (1, 0, 0)


def belt(rear: float, front: float, *, radius: float, width: float, mu: float, mu2: float) -> tuple[Part, ...]:
    """A belt round wheels of one radius at x = rear and x = front of its link; friction mu along it, mu2 across."""
    run = Box(size=(front - rear, width, 2 * (radius - SLACK)))
    end = Cylinder(radius=radius, length=width)
    flat, round_ = (Touch(mu=mu, mu2=mu2, along=along, soft=FIRM) for along in (_ALONG, _ALONG))
    return (
        Part(name="run", solid=run, place=((rear + front) / 2, 0, 0, 0, 0, 0), colour=DARK, touch=flat),
        Part(name="rear", solid=end, place=(rear, 0, 0, *ALONG_Y), colour=DARK, touch=round_),
        Part(name="front", solid=end, place=(front, 0, 0, *ALONG_Y), colour=DARK, touch=round_),
    )
