"""Everything that is shown of a map, made without the window, so that it can be made behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rsegen.exporters.scene import Scene, compose
from rsegen.field.coarse import coarse, coarseness
from rsegen.gui.colours import Rgb, legend
from rsegen.gui.numbers import Share, in_numbers, shares
from rsegen.gui.solid import Solid, solid
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.recipe import Recipe

SHOWN = 400
"""Maps of more than about so many cells a side are shown coarser, by the highest of several cells."""

AT_ONCE = 10_000
"""Maps of up to so many cells are made sooner than anyone sees; larger ones are made behind the window."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Look:
    """A scene and what is shown of it: in three dimensions by `factor` x `factor` cells, in colours, in numbers."""

    scene: Scene
    factor: int
    coarse: Scene
    solid: Solid
    legend: Sequence[tuple[Rgb, str]]
    shares: Sequence[Share]
    numbers: str


def is_quick(recipe: Recipe) -> bool:
    """Whether it can be looked at without a wait."""
    n_x, n_y = recipe.grid.shape
    return n_x * n_y <= AT_ONCE


def look_at(recipe: Recipe, index: int) -> Look:
    """What is shown of one map of a recipe; TooLarge where there is no room for it."""
    refuse_too_large(recipe)
    return look_of(compose(recipe, index))


def look_of(scene: Scene) -> Look:
    """What is shown of a scene."""
    factor = coarseness(scene.field, SHOWN)
    seen = replace(scene, field=coarse(scene.field, factor))
    return Look(
        scene=scene,
        factor=factor,
        coarse=seen,
        solid=solid(seen),
        legend=legend(scene),
        shares=shares(scene),
        numbers=in_numbers(scene),
    )
