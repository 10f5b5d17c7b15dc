"""An experiment as a job of the window: what `rsegen experiment` does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rsegen.errors import OutputError
from rsegen.gui.model.jobs import Job, Step, counted
from rsegen.gui.model.simulation import PlanSummary, plan_summary, run_experiment, simulator_titles
from rsegen.params.sorts import Choice, Flag, validate

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
        """How many steps a whole run has: one per trial."""
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
