"""A drive over the map that is shown, as a job of the window: what `rsegen drive` does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rsegen.gui.model.jobs import MapsJob, Step, counted
from rsegen.gui.model.simulation import drive_map, robot_names, route_names
from rsegen.params.sorts import Choice, Flag, Float, Integer, validate

PICTURE = "drive.png"
"""The file with the trajectories on the plan of the map."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveSettings:
    """What is driven, and how."""

    robot: Annotated[str, Choice(tuple(robot_names()), help="which robot drives")] = "burger"
    robots: Annotated[int, Integer(1, 100, help="how many of them")] = 1
    route: Annotated[str, Choice(route_names(), help="straight on, at random, or along the way across")] = "straight"
    duration: Annotated[float, Float(0.1, 1e5, unit="s", help="seconds of simulation time")] = 20.0
    contacts: Annotated[bool, Flag(help="whether to sample what the robots touch")] = True

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveJob(MapsJob):
    """Drive over the first map of a recipe, into a folder of the drive's own."""

    settings: DriveSettings

    @property
    def steps(self) -> int:
        """How many steps a whole run has: one per simulated second."""
        return max(math.ceil(self.settings.duration), 2)

    @property
    def question(self) -> str:
        """The question to ask before an earlier drive is replaced."""
        return f"{self.result_folder} already exists. Replace the drive in it?"

    @property
    def result_folder(self) -> Path:
        """The folder of the drive."""
        return self.folder / f"{self.recipe.map_name(self.recipe.first_map)}-{self.settings.robot}"

    def paths(self) -> Iterator[Path]:
        """The folder of the drive."""
        yield self.result_folder

    def cancelled(self, steps: int) -> str:
        """The message if it is cancelled."""
        return f"Cancelled after {steps} of {self.steps} simulated seconds: nothing was written"

    def refuse(self) -> None:
        """Whatever is wrong is said by the drive itself, before it starts a server."""

    def run(self, step: Step, *, force: bool) -> str:
        """Do what `rsegen drive` does."""
        settings = self.settings
        lines = drive_map(
            self.recipe,
            robot=settings.robot,
            robots=settings.robots,
            route=settings.route,
            duration=settings.duration,
            contacts=settings.contacts,
            output=self.result_folder,
            force=force,
            progress=counted(step, self.steps - 1),
        )
        return "\n".join([*lines, f"in {self.result_folder.absolute()}"])
