"""Parameters of all commands that start a simulator, or ask one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from rsegen.params.command import Shell
from rsegen.params.sorts import Float, Reference


def _servers() -> Iterable[str]:
    from rsegen.simulators.base import SIMULATORS

    return SIMULATORS


def known_simulators() -> Iterable[str]:
    """Return the names of all simulators, installed or not."""
    from rsegen.simulators.embedded import EMBEDDED

    return *EMBEDDED, *_servers()


SimulatorName = Annotated[
    str | None,
    Reference("sim or classic", help="Gazebo Sim (sim) or Gazebo Classic (classic)", known=_servers),
    Shell(metavar="NAME", default="the newest that is installed"),
]

_ANY = Reference(
    "mujoco, sim or classic",
    help="MuJoCo (mujoco), Gazebo Sim (sim) or Gazebo Classic (classic)",
    known=known_simulators,
)

OpenSimulator = Annotated[str | None, _ANY, Shell(metavar="NAME", default="the newest Gazebo that is installed")]
"""Simulator of commands that open worlds, which are files of Gazebo."""

DriveSimulator = Annotated[str | None, _ANY, Shell(metavar="NAME", default="mujoco")]
"""Simulator of commands that drive robots: MuJoCo gives the same result on every machine."""


def _of_many_maps() -> Iterable[str]:
    from rsegen.simulators.batch import simulators_of_many_maps

    return simulators_of_many_maps()


ManySimulator = Annotated[
    str | None,
    Reference(
        "mujoco or mujoco-warp",
        help="MuJoCo on all cores (mujoco), or MuJoCo Warp, all maps side by side on a GPU of CUDA, or slowly without "
        "one (mujoco-warp)",
        known=_of_many_maps,
    ),
    Shell(metavar="NAME", default="mujoco"),
]
"""Simulator of drives over many maps."""

RunningSimulator = Annotated[SimulatorName, Shell(default="whichever runs")]

Timeout = Annotated[
    float,
    Float(
        1.0, 1e6, unit="s", help="stop waiting if the simulator makes no progress for S seconds; more on a busy machine"
    ),
    Shell(metavar="S"),
]

WORLD = "WORLD-or-DIR-or-RECIPE"
"""The argument of commands that take a world, in their helps."""

OWN_FLAGS = ("simulator",)
"""Flags that mean something else in these commands than in a recipe."""


def ignore(*_: object) -> None:
    """Do nothing: the default of callbacks."""
