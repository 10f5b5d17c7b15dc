"""What the window writes in the background; each job calls the function that its command calls."""

from __future__ import annotations

import os.path
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rsegen.exporters.formats import Format, refuse_unready
from rsegen.exporters.sheet import FORMATS, CutSettings, page_count, refuse_unbuildable
from rsegen.recipe.recipe import Recipe
from rsegen.run.exports import export_maps
from rsegen.run.sheets import write_sheets
from rsegen.run.sidecars import Sidecars
from rsegen.run.worlds import generate


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
        """How many steps a whole run has."""

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
        """How many steps a whole run has: one per map."""
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
        """How many steps a whole run has: one per page."""
        return page_count(self.recipe)

    @property
    def question(self) -> str:
        """The question to ask before an existing sheet is replaced."""
        return f"{self.folder} already contains a build sheet of {self._name}. Replace it?"

    def paths(self) -> Iterator[Path]:
        """The PDF and CSV file."""
        return (self.folder / f"{self._name}.{format_}" for format_ in FORMATS)

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
