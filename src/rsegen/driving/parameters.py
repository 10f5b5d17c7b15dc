"""Parameters of all commands that drive robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

from rsegen.field.crossing import SIDE, SPEED, TURN
from rsegen.params.command import Shell
from rsegen.params.sorts import Choice, Float, Integer, ListOf, Reference
from rsegen.params.streams import SEEDS

Wheels = Annotated[
    str | None,
    Reference("LEFT,RIGHT or FRONT+REAR,FRONT+REAR", help="joints of the wheels of a model in a file"),
    Shell(metavar="LEFT,RIGHT", default="from its drive plug-in, ROS's controllers, or their shapes"),
]

Tracks = Annotated[
    str | None,
    Reference(
        "LEFT,RIGHT or TRACK+FLIPPER,TRACK+FLIPPER",
        help="links of the tracks of a model in a file, and of their flippers",
    ),
    Shell(metavar="LEFT,RIGHT", default="from its drive plug-in"),
]

Size = Annotated[
    Sequence[float] | None,
    ListOf(SIDE, 3, help="length, width and height of the robot in the file"),
    Shell(metavar="L,W,H", default="from its collision shapes"),
]

Speed = Annotated[
    float | None,
    replace(SPEED, help="maximum speed of the robot in the file"),
    Shell(metavar="V", default="from its plug-in, controller or joints, else 0.2"),
]

Turn = Annotated[
    float | None,
    replace(TURN, help="maximum turn rate of the robot in the file"),
    Shell(metavar="W", default="from its plug-in or controller, else 0.5"),
]

ROUTES = ("straight", "random", "way")
"""The names of routes."""

RouteName = Annotated[
    str,
    Choice(
        ROUTES,
        help="straight across, at random over the map, or across along a planned way",
    ),
]

Best = Annotated[
    str | None,
    Choice(
        ("safe", "length", "tilt", "margin"),
        help="for route way: a short and safe way, the shortest, the one with the least tilt, or the one "
        "that stays farthest from tipping over",
    ),
    Shell(default="safe"),
]

Drives = Annotated[
    int,
    Integer(
        1,
        10_000,
        usual=(5, 100),
        help="maximum number of drives, each with its own errors of start, friction, heights and steering",
    ),
    Shell(metavar="N"),
]

Duration = Annotated[float, Float(0.1, 1e5, unit="s", usual=(5, 120), help="simulation time"), Shell(metavar="S")]

DriveSeed = Annotated[
    int | None, Integer(0, SEEDS - 1, help="seed of start poses and routes"), Shell(default="drawn and printed")
]
