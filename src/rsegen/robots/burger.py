"""The TurtleBot3 Burger: two wheels and a caster.

Lengths in metres, masses in kg. `source` in the Robot says which figures are ROBOTIS's and which our own.
"""

from __future__ import annotations

from rsegen.robots.base import Robot, register
from rsegen.robots.drives import Wheels
from rsegen.robots.links import DARK, FIRM, Box, Cylinder, Joint, Lidar, Link, Part, Sphere, Surface, wheel

_RADIUS, _WIDTH, _SEPARATION = 0.033, 0.018, 0.160  # of the wheels
_BACK = -0.032  # the middle of the hull, behind the axle
_GLIDE = Surface(mu=0, mu2=0, soft=FIRM)  # the caster's: a real one rolls, a rigid ball with friction would drag
_HULL = Surface(mu=0.3, mu2=0.3)  # smooth plastic: with more, the hull holds the robot on an edge
_SIDE, _FLOOR, _HEIGHT, _BALL = 0.138, 0.010, 0.143, 0.0245  # the hull, its clearance, and the radius of its corners
_LOW, _HIGH = _FLOOR + _BALL, _FLOOR + _HEIGHT - _BALL  # the balls touch the hull's underside and top from inside
_CORNERS = {"front_left": (1, 1), "front_right": (1, -1), "rear_left": (-1, 1), "rear_right": (-1, -1)}


def _ball(name: str, along: int, across: int, z: float) -> Part:
    """Return a rounded corner of the hull, or the middle of its underside."""
    off = _SIDE / 2 - _BALL
    pose = (_BACK + along * off, across * off, z, 0, 0, 0)
    return Part(name=f"hull_{name}", solid=Sphere(radius=_BALL), pose=pose, surface=_HULL)


_HULL_BALLS = (
    *(_ball(name, *corner, _LOW) for name, corner in _CORNERS.items()),
    _ball("middle", 0, 0, _LOW),
    *(_ball(f"top_{name}", *corner, _HIGH) for name, corner in _CORNERS.items()),
)
"""The collision shapes of the hull: in ODE a box on a mesh costs several times what these do together."""

_BASE = Link(
    name="base",
    mass=0.943,
    solid=Box(size=(0.14, 0.14, 0.143)),
    centre=(_BACK, 0, 0.075, 0, 0, 0),
    parts=(
        Part(name="hull", solid=Box(size=(_SIDE, _SIDE, _HEIGHT)), pose=(_BACK, 0, _FLOOR + _HEIGHT / 2, 0, 0, 0)),
        *_HULL_BALLS,
        Part(name="tower", solid=Cylinder(radius=0.035, length=0.039), pose=(_BACK, 0, 0.1725, 0, 0, 0), colour=DARK),
        Part(name="caster", solid=Sphere(radius=0.005), pose=(-0.081, 0, 0.005, 0, 0, 0), surface=_GLIDE),
    ),
)


def _wheel(side: str, y: float) -> Link:
    return wheel(f"{side}_wheel", (0, y, _RADIUS), radius=_RADIUS, width=_WIDTH, mass=0.0285, geared=0.0018)


def _axle(side: str) -> Joint:
    return Joint(name=f"{side}_axle", parent="base", child=f"{side}_wheel", axis=(0, 0, 1))


BURGER = register(
    Robot(
        kind="burger",
        also=("turtlebot", "turtlebot3", "tb3"),
        title="like a TurtleBot3 Burger",
        source=(
            "sizes, wheels, mass and top speeds: ROBOTIS e-manual and turtlebot3_description; our own: uniform"
            " densities, collision balls at the hull's corners, narrow collision shapes of the tyres, a caster"
            " without friction, the motors' inertia and acceleration"
        ),
        size=(0.138, 0.178, 0.192),
        clearance=0.010,
        climbs=0.010,
        links=(_BASE, _wheel("left", _SEPARATION / 2), _wheel("right", -_SEPARATION / 2)),
        joints=(_axle("left"), _axle("right")),
        drive=Wheels(
            left=("left_axle",),
            right=("right_axle",),
            separation=_SEPARATION,
            radius=_RADIUS,
            speed=0.22,
            turn=2.84,
            acceleration=1.0,
        ),
        lidar=Lidar(pose=(_BACK, 0, 0.182, 0, 0, 0), rays=360, nearest=0.12, farthest=3.5, rate=5),
    )
)
