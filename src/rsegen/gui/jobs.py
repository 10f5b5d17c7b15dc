"""What the window writes behind itself, each by the command line's own function; knows no Qt."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rsegen.exporters.formats import Format, refuse_unready
from rsegen.exporters.sheet import FORMATS, CutSettings, page_count, refuse_unbuildable
from rsegen.io.exports import export_maps
from rsegen.io.sheets import write_sheets
from rsegen.io.sidecars import Sidecars
from rsegen.io.worlds import generate
from rsegen.recipe.recipe import Recipe


@dataclass(frozen=True, kw_only=True, slots=True)
class Job(ABC):
    """Files to be made of the maps of a recipe in a folder, step by step."""

    recipe: Recipe
    folder: Path

    @property
    def steps(self) -> int:
        """How often it tells that it has come further: after each map."""
        return self.recipe.maps

    @property
    def question(self) -> str:
        """What to ask before something is replaced."""
        return f"{self.folder} holds maps of the name {self.recipe.name} already. Replace them?"

    def paths(self) -> Iterator[Path]:
        """What it makes in the folder."""
        return (self.folder / self.recipe.map_name(index) for index in self.recipe.indices)

    def stopped(self, steps: int) -> str:
        """What is there if it is stopped after so many steps."""
        return f"Cancelled: {steps} of {self.steps} maps are in {self.folder}"

    @abstractmethod
    def refuse(self) -> None:
        """Raise a UserError where it cannot be done, whatever is in the folder."""

    @abstractmethod
    def carried_out(self, step: Callable[[object], None], *, force: bool) -> str:
        """Do it, and say what came of it; what `step` raises ends it. An RsegenError where it fails."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Worlds(Job):
    """Worlds, with build sheets or without."""

    sheets: bool = False

    def refuse(self) -> None:
        """Not every map can be built by hand."""
        Sidecars(sheet=self.sheets).refuse(self.recipe)

    def carried_out(self, step: Callable[[object], None], *, force: bool) -> str:
        """As `rsegen generate`."""
        made = generate(self.recipe, self.folder, force=force, sheet=self.sheets, progress=step)
        return f"{_maps(len(made.maps))} in {self.folder}, seed {made.recipe.seed}"


@dataclass(frozen=True, kw_only=True, slots=True)
class Exports(Job):
    """Maps for other programs, without worlds."""

    formats: tuple[Format, ...]

    @property
    def question(self) -> str:
        """What to ask before formats of maps are replaced; everything else in their folders stays."""
        names = ", ".join(each.name for each in self.formats)
        return f"{self.folder} holds maps of the name {self.recipe.name} already. Write or replace their {names}?"

    def refuse(self) -> None:
        """A format may need what is not installed."""
        refuse_unready(self.formats)

    def carried_out(self, step: Callable[[object], None], *, force: bool) -> str:
        """As `rsegen export`."""
        made = export_maps([self.recipe], self.folder, self.formats, force=force, progress=step)
        return f"{_maps(len(made))} as {', '.join(each.name for each in self.formats)} in {self.folder}"


@dataclass(frozen=True, kw_only=True, slots=True)
class Sheet(Job):
    """The build sheet of a recipe's first map, as PDF and as CSV."""

    saw: CutSettings

    @property
    def steps(self) -> int:
        """After each page."""
        return page_count(self.recipe)

    @property
    def question(self) -> str:
        """What to ask before it is replaced."""
        return f"{self.folder} holds a build sheet of {self._name} already. Replace it?"

    def paths(self) -> Iterator[Path]:
        """A file of each format."""
        return (self.folder / f"{self._name}.{format_}" for format_ in FORMATS)

    def stopped(self, steps: int) -> str:
        """Files are written when all pages are drawn."""
        return f"Cancelled: nothing was written after {steps} of {self.steps} pages"

    def refuse(self) -> None:
        """Not every map can be built by hand, nor with every saw."""
        refuse_unbuildable(self.recipe, self.saw)

    def carried_out(self, step: Callable[[object], None], *, force: bool) -> str:
        """As `rsegen sheet`."""
        paths = list(self.paths())
        write_sheets(self.recipe, self.recipe.first_map, paths, self.saw, force=force, progress=step)
        return f"{' and '.join(path.name for path in paths)} in {self.folder}"

    @property
    def _name(self) -> str:
        return self.recipe.map_name(self.recipe.first_map)


def _maps(count: int) -> str:
    return f"{count} map{'s'[: count > 1]}"
