"""A crawler in the class of the Servosila Engineer: two tracks, two front flippers, an arm of five joints.

Lengths in metres, masses in kg, angles in radians; all figures are our own, chosen for a robot of 23 kg that climbs a
stair of 10 and 20 cm. Gains hold arm and flippers against gravity; an effort is the most that a motor gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import NamedTuple

from rsegen.robots.base import Robot, register
from rsegen.robots.drives import Servo, Tracks
from rsegen.robots.links import FIRM, GREY, Box, Cylinder, Joint, Lidar, Link, Part, Solid, Surface, Vector, belt, road

_RADIUS, _HALF, _WIDTH, _SEPARATION = 0.085, 0.27, 0.07, 0.36  # a track: its ends, half of what is between, its width
_REACH, _FLIPPER_RADIUS, _FLIPPER_WIDTH = 0.30, 0.05, 0.04  # a flipper, from axle to axle
_MU, _MU2 = 1.0, 0.5  # along a belt, and across it, where it has to skid in a turn
_ROAD, _PROUD = 0.15, 0.002  # the wheels that the tracks stand on, and by how much lower they are than the others
_HULL, _GRIP = Surface(mu=0.3, mu2=0.3, soft=FIRM), Surface(mu=_MU, mu2=_MU2, along=(1, 0, 0), soft=FIRM)
_RAISED = 0.25  # radians: low enough not to hang on what it has climbed
_SIDES = {"left": 1, "right": -1}
_Y: Vector = (0, 1, 0)


_WAIST = Cylinder(radius=0.05, length=0.06)


class _Limb(NamedTuple):
    """A joint of the arm and the link that it turns: where it is in the model, metres, and the middle of its solid."""

    joint: str
    axis: Vector
    lower: float
    upper: float
    at: Vector
    solid: Solid
    middle: Vector
    mass: float
    stiffness: float
    damping: float
    effort: float


_ARM = (
    _Limb("waist", (0, 0, 1), -pi, pi, (-0.06, 0, 0.16), _WAIST, (0, 0, 0.035), 0.8, 300, 8, 20),
    _Limb(
        "shoulder", (0, -1, 0), 0, 2.6, (-0.06, 0, 0.25), Box(size=(0.30, 0.05, 0.04)), (0.15, 0, 0), 0.9, 800, 15, 40
    ),
    _Limb("elbow", _Y, 0, 2.9, (0.24, 0, 0.275), Box(size=(0.28, 0.04, 0.04)), (-0.14, 0, 0.02), 0.7, 300, 5, 20),
    _Limb("wrist", _Y, -1.5, 1.5, (-0.04, 0, 0.295), Box(size=(0.08, 0.04, 0.04)), (-0.04, 0, 0), 0.3, 60, 0.5, 8),
    _Limb("hand", (1, 0, 0), -pi, pi, (-0.12, 0, 0.295), Box(size=(0.10, 0.08, 0.05)), (-0.05, 0, 0), 0.3, 5, 0.03, 4),
)
"""Folded over the hull, where every joint is at 0."""

_HULL_BOX = Box(size=(0.66, 0.26, 0.11))
_BASE = Link(
    name="base",
    mass=11.0,
    solid=_HULL_BOX,
    centre=(0.14, 0, 0.07, 0, 0, 0),
    parts=(Part(name="hull", solid=_HULL_BOX, pose=(0, 0, 0.105, 0, 0, 0), surface=_HULL),),
)


def _track(side: str) -> Link:
    belts = belt(-_HALF, _HALF, radius=_RADIUS - _PROUD, width=_WIDTH, surface=_GRIP)
    roads = tuple(road(x, radius=_RADIUS, width=_WIDTH, surface=_GRIP) for x in (-_ROAD, _ROAD))
    solid = Box(size=(2 * (_HALF + _RADIUS), _WIDTH, 2 * _RADIUS))
    at = (0, _SIDES[side] * _SEPARATION / 2, _RADIUS, 0, 0, 0)
    return Link(name=f"{side}_track", mass=3.5, solid=solid, parts=belts + roads, pose=at)


def _flipper(side: str) -> Link:
    belts = belt(0, _REACH, radius=_FLIPPER_RADIUS, width=_FLIPPER_WIDTH, surface=_GRIP)
    solid = Box(size=(_REACH + 2 * _FLIPPER_RADIUS, _FLIPPER_WIDTH, 2 * _FLIPPER_RADIUS))
    y = _SIDES[side] * (_SEPARATION / 2 + _WIDTH / 2 + _FLIPPER_WIDTH / 2 + 0.01)
    centre = (_REACH / 2, 0, 0, 0, 0, 0)
    return Link(
        name=f"{side}_flipper", mass=0.8, solid=solid, parts=belts, pose=(_HALF, y, _RADIUS, 0, 0, 0), centre=centre
    )


def _limb(limb: _Limb) -> Link:
    at, middle = (*limb.at, 0, 0, 0), (*limb.middle, 0, 0, 0)
    part = Part(name=limb.joint, solid=limb.solid, pose=middle, colour=GREY, surface=_HULL)
    return Link(name=limb.joint, mass=limb.mass, solid=limb.solid, parts=(part,), pose=at, centre=middle)


def _hinge(name: str, parent: str, child: str, axis: Vector, ends: tuple[float, float], effort: float) -> Joint:
    lower, upper = ends
    return Joint(name=name, parent=parent, child=child, axis=axis, lower=lower, upper=upper, effort=effort, rate=1.0)


def _joints() -> Iterator[Joint]:
    yield from (Joint(name=f"{side}_track_mount", parent="base", child=f"{side}_track") for side in _SIDES)
    for side in _SIDES:
        yield _hinge(f"{side}_flipper_pivot", "base", f"{side}_flipper", (0, -1, 0), (-1.2, 2.8), 60)
    for parent, limb in zip(("base", *(limb.joint for limb in _ARM)), _ARM, strict=False):
        yield _hinge(f"{limb.joint}_joint", parent, limb.joint, limb.axis, (limb.lower, limb.upper), limb.effort)


CRAWLER = register(
    Robot(
        kind="crawler",
        also=("servosila", "engineer", "tracked"),
        title="in the class of the Servosila Engineer",
        source="all figures are our own: the geometry of the Servosila Engineer is not confirmed",
        size=(0.975, 0.53, 0.320),
        clearance=0.050,
        climbs=0.20,
        links=(
            _BASE,
            *(_track(side) for side in _SIDES),
            *(_flipper(side) for side in _SIDES),
            *(_limb(limb) for limb in _ARM),
        ),
        joints=tuple(_joints()),
        drive=Tracks(
            body="base",
            left=("left_track", "left_flipper"),
            right=("right_track", "right_flipper"),
            separation=_SEPARATION,
            radius=_RADIUS,
            speed=1.0,
            turn=1.5,
            mu=_MU,
            mu2=_MU2,
            efficiency=0.82,
            in_place=1.46,
        ),
        servos=(
            *(
                Servo(joint=f"{side}_flipper_pivot", stiffness=300, damping=6, effort=60, rest=_RAISED)
                for side in _SIDES
            ),
            *(
                Servo(joint=f"{limb.joint}_joint", stiffness=limb.stiffness, damping=limb.damping, effort=limb.effort)
                for limb in _ARM
            ),
        ),
        lidar=Lidar(pose=(-0.06, 0, 0.340, 0, 0, 0), rays=720, nearest=0.1, farthest=20, rate=10),  # over its arm
    )
)
