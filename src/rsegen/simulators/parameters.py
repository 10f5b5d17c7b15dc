"""Parameters of all commands that start a simulator, or ask one."""

from __future__ import annotations

from typing import Annotated

from rsegen.params.command import Shell
from rsegen.params.sorts import Float, Reference

SimulatorName = Annotated[
    str | None,
    Reference("sim or classic", help="Gazebo Sim (sim) or Gazebo Classic (classic)"),
    Shell(metavar="NAME", default="the newest that is installed"),
]

RunningSimulator = Annotated[SimulatorName, Shell(default="whichever runs")]

Timeout = Annotated[
    float,
    Float(1.0, 1e6, unit="s", help="give a simulator up that shows no progress for so long; more on a busy machine"),
    Shell(metavar="S"),
]
