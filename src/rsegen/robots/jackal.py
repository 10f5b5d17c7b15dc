"""A skid-steer robot of the Jackal's class: four wheels, each pair turned together.

Lengths in metres, masses in kg. `source` in the Robot says which figures are Clearpath's and which our own.
"""

from __future__ import annotations

from rsegen.robots.base import Robot, register
from rsegen.robots.drives import Wheels
from rsegen.robots.links import GREY, Box, Joint, Lidar, Link, Part, Surface, wheel

_RADIUS, _WIDTH, _SEPARATION, _BASE = 0.098, 0.040, 0.3756, 0.262  # of the wheels; _BASE from axle to axle
_SPREAD = 2  # hinges twice as far apart as the wheels: Classic then takes twice the turn rate (`Wheels.spread`)
_HULL = Surface(mu=0.3, mu2=0.3)  # smooth: with more, the hull holds the robot on an edge
_CHASSIS = Box(size=(0.420, 0.310, 0.184))
_CORNERS = {
    f"{end}_{side}": (x, y)
    for side, y in (("left", _SEPARATION / 2), ("right", -_SEPARATION / 2))
    for end, x in (("front", _BASE / 2), ("rear", -_BASE / 2))
}


def _wheel(corner: str, x: float, y: float) -> Link:
    return wheel(f"{corner}_wheel", (x, y, _RADIUS), radius=_RADIUS, width=_WIDTH, mass=0.477, geared=0.02, mu=0.5)


def _axle(corner: str, y: float) -> Joint:
    return Joint(
        name=f"{corner}_axle", parent="base", child=f"{corner}_wheel", axis=(0, 0, 1), anchor=(0, 0, y * (_SPREAD - 1))
    )


_PART = Part(name="hull", solid=_CHASSIS, pose=(0, 0, 0.158, 0, 0, 0), colour=GREY, surface=_HULL)

JACKAL = register(
    Robot(
        kind="jackal",
        also=("clearpath", "skid_steer"),
        title="of the Jackal's class",
        source=(
            "chassis, wheels, masses, friction and top speeds: jackal_description, jackal_control (Clearpath);"
            " our own: overall size (from these), centre of mass in the middle, the motors' inertia,"
            " a lidar on its top"
        ),
        size=(_BASE + 2 * _RADIUS, _SEPARATION + _WIDTH, 0.250),
        clearance=0.066,
        climbs=0.05,
        links=(
            Link(name="base", mass=16.523, solid=_CHASSIS, centre=(0, 0, 0.130, 0, 0, 0), parts=(_PART,)),
            *(_wheel(corner, x, y) for corner, (x, y) in _CORNERS.items()),
        ),
        joints=tuple(_axle(corner, y) for corner, (_, y) in _CORNERS.items()),
        drive=Wheels(
            left=("front_left_axle", "rear_left_axle"),
            right=("front_right_axle", "rear_right_axle"),
            separation=_SEPARATION,
            radius=_RADIUS,
            speed=2.0,
            turn=4.0,
            slip=1.05,
            spread=_SPREAD,
        ),
        lidar=Lidar(pose=(0, 0, 0.270, 0, 0, 0), rays=720, nearest=0.1, farthest=20, rate=10),
    )
)
