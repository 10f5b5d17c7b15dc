"""The TurtleBot3 Burger: two wheels and a caster."""

from __future__ import annotations

from rsegen.robots.base import Robot, register
from rsegen.robots.drives import Wheels
from rsegen.robots.lidar import Lidar
from rsegen.robots.links import DARK, FIRM, Joint, Link, Part, Touch
from rsegen.robots.solids import Box, Cylinder, Sphere
from rsegen.robots.wheels import wheel

_RADIUS, _WIDTH, _SEPARATION = 0.033, 0.018, 0.160
_BACK = -0.032
_GLIDE = Touch(mu=0, mu2=0, soft=FIRM)
_HULL = Touch(mu=0.3, mu2=0.3)
_BASE = Link(
    name="base",
    mass=0.943,
    solid=Box(size=(0.14, 0.14, 0.143)),
    centre=(_BACK, 0, 0.075, 0, 0, 0),
    parts=(
        Part(name="hull", solid=Box(size=(0.138, 0.138, 0.143)), place=(_BACK, 0, 0.0815, 0, 0, 0), touch=_HULL),
        Part(name="tower", solid=Cylinder(radius=0.035, length=0.039), place=(_BACK, 0, 0.1725, 0, 0, 0), colour=DARK),
        Part(name="caster", solid=Sphere(radius=0.005), place=(-0.081, 0, 0.005, 0, 0, 0), touch=_GLIDE),
    ),
)


def _wheel(side: str, y: float) -> Link:
    return wheel(f"{side}_wheel", (0, y, _RADIUS), radius=_RADIUS, width=_WIDTH, mass=0.0285, geared=0.0018)


def _axle(side: str) -> Joint:
    return Joint(name=f"{side}_axle", parent="base", child=f"{side}_wheel", axis=(0, 0, 1))


BURGER = register(
    Robot(
        kind="burger",
        title="like a TurtleBot3 Burger",
        source=(
            "sizes, wheels, mass and top speeds: ROBOTIS e-manual and turtlebot3_description; ours: even densities,"
            " tyres that touch with their middle, a caster without friction, the motors' inertia"
        ),
        size=(0.138, 0.178, 0.192),
        clearance=0.010,
        climbs=0.010,
        links=(_BASE, _wheel("left", _SEPARATION / 2), _wheel("right", -_SEPARATION / 2)),
        joints=(_axle("left"), _axle("right")),
        drive=Wheels(
            left=("left_axle",), right=("right_axle",), separation=_SEPARATION, radius=_RADIUS, speed=0.22, turn=2.84
        ),
        lidar=Lidar(place=(_BACK, 0, 0.182, 0, 0, 0), rays=360, nearest=0.12, farthest=3.5, rate=5),
    )
)
