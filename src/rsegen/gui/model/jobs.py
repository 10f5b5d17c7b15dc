"""The jobs that write in the background; each calls the function that its command calls."""

from __future__ import annotations

import math
import os.path
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Protocol

from rsegen.commands.drive import drive
from rsegen.commands.export import export_maps
from rsegen.commands.generate import generate
from rsegen.errors import OutputError
from rsegen.exporters.formats import Format, refuse_unready
from rsegen.exporters.sheet import SHEET_FORMATS, CutSettings, page_count, refuse_unbuildable
from rsegen.gui.model.simulation import (
    PlanSummary,
    drive_map,
    plan_summary,
    robot_names,
    run_experiment,
    simulator_titles,
)
from rsegen.params.command import declared
from rsegen.params.sorts import Choice, Flag, validate
from rsegen.recipe.recipe import Recipe
from rsegen.run.single_files import write_sheets
from rsegen.run.worlds import Sidecars


class Step(Protocol):
    """Called after each step of a job; `check` is called during long ones. Both may raise to cancel the job."""

    def __call__(self, done: object = None, /) -> None:
        """A step is done."""

    def check(self) -> None:
        """A step still lasts."""


def counted(step: Step, most: int) -> Callable[[float], None]:
    """What takes how many steps are done, and calls a step for each new one, up to `most`."""
    done = 0

    def count(steps: float) -> None:
        nonlocal done
        while done < min(int(steps), most):
            done += 1
            step()

    return count


@dataclass(frozen=True, kw_only=True, slots=True)
class Job(ABC):
    """Files to write into a folder, step by step."""

    folder: Path

    @property
    def result_folder(self) -> Path:
        """The folder to open afterwards."""
        return self.folder

    @property
    @abstractmethod
    def steps(self) -> int:
        """The number of steps of a whole run."""

    @property
    @abstractmethod
    def question(self) -> str:
        """The question to ask before existing files are replaced."""

    @abstractmethod
    def paths(self) -> Iterator[Path]:
        """The files or folders that it replaces."""

    @abstractmethod
    def cancelled(self, steps: int) -> str:
        """The message if it is cancelled after some steps."""

    @abstractmethod
    def refuse(self) -> None:
        """Raise a UserError if it cannot be done, whatever is in the folder."""

    @abstractmethod
    def run(self, step: Step, *, force: bool) -> str:
        """Write the files, and give a message about them; calls `step` after each step, which may raise to cancel."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MapsJob(Job):
    """Files to write for the maps of a recipe."""

    recipe: Recipe

    @property
    def steps(self) -> int:
        """The number of steps of a whole run: one per map."""
        return self.recipe.maps

    @property
    def question(self) -> str:
        """The question to ask before existing files are replaced."""
        return f"{self.folder} already contains maps named {self.recipe.name}. Replace them?"

    def paths(self) -> Iterator[Path]:
        """The files or folders that it writes."""
        return (self.folder / self.recipe.map_name(index) for index in self.recipe.indices)

    def cancelled(self, steps: int) -> str:
        """The message if it is cancelled after some steps: small maps are written in batches, so it counts them."""
        made = sum(map(os.path.lexists, self.paths()))
        return f"Cancelled: {max(made, steps)} of {self.steps} maps are in {self.folder}"


@dataclass(frozen=True, kw_only=True, slots=True)
class WorldsJob(MapsJob):
    """Write worlds, with build sheets or without."""

    sheets: bool = False

    def refuse(self) -> None:
        """Raise a UserError if build sheets are wanted of a map that is too large for them."""
        Sidecars(sheet=self.sheets).refuse(self.recipe)

    def run(self, step: Step, *, force: bool) -> str:
        """Do what `rsegen generate` does."""
        made = generate(self.recipe, self.folder, force=force, sheet=self.sheets, progress=step)
        return f"{_maps(len(made.maps))} in {self.folder.absolute()}, seed {made.recipe.seed}"


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportJob(MapsJob):
    """Write maps in formats of other programs, without worlds."""

    formats: tuple[Format, ...]

    @property
    def question(self) -> str:
        """What to ask before formats of maps are replaced; everything else in their folders stays."""
        names = ", ".join(each.name for each in self.formats)
        return f"{self.folder} already contains maps named {self.recipe.name}. Write or replace their {names}?"

    def refuse(self) -> None:
        """Raise a UserError if a format needs a package that is not installed."""
        refuse_unready(self.formats)

    def run(self, step: Step, *, force: bool) -> str:
        """Do what `rsegen export` does."""
        made = export_maps([self.recipe], self.folder, self.formats, force=force, progress=step)
        return f"{_maps(len(made))} as {', '.join(each.name for each in self.formats)} in {self.folder}"


@dataclass(frozen=True, kw_only=True, slots=True)
class SheetJob(MapsJob):
    """Write the build sheet of a recipe's first map, as PDF and as CSV."""

    saw: CutSettings

    @property
    def steps(self) -> int:
        """The number of steps of a whole run: one per page."""
        return page_count(self.recipe)

    @property
    def question(self) -> str:
        """The question to ask before an existing sheet is replaced."""
        return f"{self.folder} already contains a build sheet of {self._name}. Replace it?"

    def paths(self) -> Iterator[Path]:
        """The PDF and CSV file."""
        return (self.folder / f"{self._name}.{format_}" for format_ in SHEET_FORMATS)

    def cancelled(self, steps: int) -> str:
        """The message if it is cancelled: files are written when all pages are drawn."""
        return f"Cancelled: nothing was written after {steps} of {self.steps} pages"

    def refuse(self) -> None:
        """Raise a UserError if the map is too large for a build sheet, or the timber too short."""
        refuse_unbuildable(self.recipe, self.saw)

    def run(self, step: Step, *, force: bool) -> str:
        """Do what `rsegen sheet` does."""
        paths = list(self.paths())
        write_sheets(self.recipe, self.recipe.first_map, paths, self.saw, force=force, progress=step)
        return f"{' and '.join(path.name for path in paths)} in {self.folder}"

    @property
    def _name(self) -> str:
        return self.recipe.map_name(self.recipe.first_map)


def _maps(count: int) -> str:
    return f"{count} map{'s'[: count > 1]}"


PICTURE = "drive.png"
"""The file with the trajectories on the plan of the map."""


_DRIVE = declared(drive)


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveSettings:
    """What is driven, and how."""

    robot: Annotated[str, Choice(tuple(robot_names()), help="which robot drives")] = "burger"
    robots: Annotated[int, _DRIVE["robots"].sort] = _DRIVE["robots"].default  # type: ignore[assignment]  # as declared
    route: Annotated[str, _DRIVE["route"].sort] = _DRIVE["route"].default  # type: ignore[assignment]  # as declared
    duration: Annotated[float, _DRIVE["duration"].sort] = _DRIVE["duration"].default  # type: ignore[assignment]  # as declared
    contacts: Annotated[bool, _DRIVE["contacts"].sort] = _DRIVE["contacts"].default  # type: ignore[assignment]  # as declared

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True, slots=True)
class DriveJob(MapsJob):
    """Drive over the first map of a recipe, into a folder of the drive's own."""

    settings: DriveSettings

    @property
    def steps(self) -> int:
        """The number of steps of a whole run: one per simulated second."""
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


TABLE, PLOT = "table.md", "plot.png"
"""The files of an experiment that the window shows."""

_NEWEST, _BOTH = "newest", "both"


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentSettings:
    """Where the trials of a plan are run, and whether all of them."""

    simulator: Annotated[
        str, Choice((_NEWEST, *simulator_titles(), _BOTH), help="the newest that is installed, one, or both, compared")
    ] = _NEWEST
    start_again: Annotated[
        bool, Flag(help="delete earlier results of the plan; otherwise only the trials that are missing are run")
    ] = False

    def __post_init__(self) -> None:
        validate(self)

    @property
    def simulators(self) -> tuple[str, ...]:
        """The names of the simulators; none for the newest that is installed."""
        if self.simulator == _NEWEST:
            return ()
        return tuple(simulator_titles()) if self.simulator == _BOTH else (self.simulator,)


@dataclass(frozen=True, kw_only=True, slots=True)
class ExperimentJob(Job):
    """Run the trials of a plan, into a folder of the plan's and simulator's own; `summary` is that of the plan."""

    plan: str
    settings: ExperimentSettings
    summary: PlanSummary

    @classmethod
    def of(cls, folder: Path, plan: str, settings: ExperimentSettings) -> ExperimentJob:
        """The job for an included plan or a YAML file; a UserError if there is none, or it is wrong."""
        return cls(folder=folder, plan=plan, settings=settings, summary=plan_summary(plan, settings.simulators))

    @property
    def steps(self) -> int:
        """The number of steps of a whole run: one per trial."""
        return self.summary.trials

    @property
    def question(self) -> str:
        """The question to ask before earlier results are replaced."""
        return f"{self.result_folder} already exists. Replace the results in it once the new ones are complete?"

    @property
    def result_folder(self) -> Path:
        """The folder of the results."""
        chosen = self.settings.simulator
        return self.folder / (self.summary.name if chosen == _NEWEST else f"{self.summary.name}-{chosen}")

    def paths(self) -> Iterator[Path]:
        """The folder of the results, if those of earlier trials are replaced."""
        if self.settings.start_again:
            yield self.result_folder

    def cancelled(self, steps: int) -> str:
        """The message if it is cancelled."""
        done = f"Cancelled: {steps} of {self.steps} trials are in {self.result_folder}"
        return f"{done}; run the same plan into the same folder to continue"

    def refuse(self) -> None:
        """Whatever is wrong is said by the experiment itself, before the first trial."""

    def run(self, step: Step, *, force: bool) -> str:
        """Do what `rsegen experiment` does."""
        progress = counted(step, self.steps)
        try:
            run_experiment(
                self.plan,
                self.result_folder,
                self.settings.simulators,
                force=force,
                progress=progress,
                watch=step.check,
            )
        except OutputError as error:
            raise OutputError(str(error).replace("--force", "tick Start again")) from None
        progress(self.steps)
        return f"{self.steps} trials in {self.result_folder.absolute()}"
