"""A recipe: everything that determines a set of maps.

    Run              how many maps, from which index on, under which name
    MapDesign        what a map is: nothing else decides its levels
    Representation   how it is represented in a simulator

All three are one flat list of parameters in files, flags, Python and the window; inside, each part of rsegen takes the
one that it needs.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TypeVar

from rsegen.params.sorts import Json, changed, parameters, plain, validate
from rsegen.recipe.map_design import MapDesign
from rsegen.recipe.placement import Placement
from rsegen.recipe.representation import Representation
from rsegen.recipe.run import Run

__all__ = ["MapDesign", "Placement", "Recipe", "Representation", "Run"]

_Part = TypeVar("_Part", Run, MapDesign, Representation)


@dataclass(frozen=True, kw_only=True)
class Recipe(Representation, MapDesign, Run):
    """What to generate; every field is a global parameter of the method, in the words of the recipe file."""

    def __post_init__(self) -> None:
        validate(self)
        self.check_run()
        self.check_representation()
        self.check_design()

    @cached_property
    def run(self) -> Run:
        """How many maps to make, and what they are called."""
        return self._part(Run)

    @cached_property
    def design(self) -> MapDesign:
        """What a map is: two recipes of one design have maps of the same levels."""
        return self._part(MapDesign)

    @cached_property
    def representation(self) -> Representation:
        """How a map is represented in a simulator."""
        return self._part(Representation)

    def alone(self, index: int) -> Recipe:
        """The recipe of map `index` and no other."""
        return replace(self, first_map=index, maps=1)

    def values(self) -> dict[str, Json]:
        """Every global parameter that is not left open, as a file has it."""
        values = {name: getattr(self, name) for name in parameters(Recipe)}
        return {name: plain(value) for name, value in values.items() if value is not None}

    def entry(self) -> dict[str, Json]:
        """The recipe as a file has it: the parameters that differ from their defaults, the seed, the obstacles."""
        return changed(self) | {"obstacles": [placement.entry() for placement in self.obstacles]}

    def _part(self, cls: type[_Part]) -> _Part:
        return cls(**{each.name: getattr(self, each.name) for each in fields(cls)})
