"""All that an exporter may know: a map, its geometry, its colours, its friction.

StepField --compose--> Scene
"""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.build import build
from rsegen.recipe import Recipe
from rsegen.stepfield import StepField

Colour = tuple[float, float, float]

FRAME_COLOUR: Colour = (0.75, 0.1, 0.08)
_LOW_TO_HIGH: tuple[Colour, ...] = (
    (0.22, 0.20, 0.42),
    (0.19, 0.39, 0.55),
    (0.16, 0.57, 0.55),
    (0.45, 0.74, 0.38),
    (0.93, 0.85, 0.30),
)
"""From dark to light, so that heights can be told apart in grey too."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Scene:
    """Map `index` of a recipe, as it stands in a world."""

    recipe: Recipe
    index: int
    field: StepField

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of all that it is made of."""
        return self.recipe.friction

    @property
    def name(self) -> str:
        """What the map is called, on disk and in the simulator."""
        return self.recipe.map_name(self.index)

    @property
    def alone(self) -> Recipe:
        """The recipe of this map and no other."""
        return self.recipe.alone(self.index)

    def colour(self, material: int) -> Colour:
        """The colour of a material: 0 is the frame, any other the level."""
        return level_colour(material, self.recipe.top_level) if material else FRAME_COLOUR


def compose(recipe: Recipe, index: int = 0) -> Scene:
    """The scene of map `index`."""
    return Scene(recipe=recipe, index=index, field=build(recipe, index))


def level_colour(level: int, top_level: int) -> Colour:
    """A level's colour, from the lowest to the highest that the recipe can have."""
    at = level / max(top_level, 1) * (len(_LOW_TO_HIGH) - 1)
    low = min(int(at), len(_LOW_TO_HIGH) - 2)
    share = at - low
    red, green, blue = (
        round(a + share * (b - a), 3) for a, b in zip(_LOW_TO_HIGH[low], _LOW_TO_HIGH[low + 1], strict=True)
    )
    return red, green, blue
