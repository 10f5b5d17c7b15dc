"""Everything that the window shows of a map, computed without Qt, so that a thread can do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rsegen.errors import TooLarge
from rsegen.exporters.scene import Scene, compose
from rsegen.field.coarse import coarse, coarseness
from rsegen.gui.model.colours import Rgb, legend
from rsegen.gui.model.ghost import Ghost, ghost_of
from rsegen.gui.model.map_numbers import Share, shares, size_text
from rsegen.gui.model.session import Entry
from rsegen.gui.model.solid import Lit, Solid, lit, solid
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.recipe import Recipe

SHOWN_SIDE = 400
"""Larger maps than about this many cells a side are shown coarser, by the highest of several cells."""

QUICK_CELLS = 10_000
"""Maps of up to this many cells are previewed at once; larger ones in a thread."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Preview:
    """A scene and what is shown of it: a surface, each column `factor` x `factor` cells, a legend, numbers.

    ghost: the obstacle in the form that is not yet in the list, if there is one, and its solid.
    """

    scene: Scene
    factor: int
    coarse: Scene
    lit: Lit
    legend: Sequence[tuple[Rgb, str]]
    shares: Sequence[Share]
    numbers: str
    ghost: Ghost | None = None
    ghost_solid: Solid | None = None


def is_quick(recipe: Recipe) -> bool:
    """Whether the preview of a recipe takes no noticeable time."""
    n_x, n_y = recipe.grid.shape
    return n_x * n_y <= QUICK_CELLS


def preview(recipe: Recipe, index: int, proposed: Entry | None = None, shown: Preview | None = None) -> Preview:
    """The preview of one map of a recipe and of one more obstacle; TooLarge if there is too little memory for it.

    shown: an earlier preview; if it is of the same map, only the ghost of the obstacle is made anew.
    """
    refuse_too_large(recipe)
    is_shown = shown is not None and (shown.scene.recipe, shown.scene.index) == (recipe, index)
    try:
        return _with_ghost(shown if shown and is_shown else preview_of(compose(recipe, index)), proposed)
    except MemoryError:
        raise TooLarge("this map needs more memory than is free; give fewer chunks or a smaller chunk_size") from None


def preview_of(scene: Scene) -> Preview:
    """The preview of a scene."""
    factor = coarseness(scene.field, SHOWN_SIDE)
    seen = _coarse(scene, factor)
    return Preview(
        scene=scene,
        factor=factor,
        coarse=seen,
        lit=lit(seen),
        legend=legend(scene),
        shares=shares(scene),
        numbers=size_text(scene),
    )


def _with_ghost(found: Preview, proposed: Entry | None) -> Preview:
    ghost = ghost_of(found.scene, proposed) if proposed else None
    return replace(found, ghost=ghost, ghost_solid=solid(_coarse(ghost.scene, found.factor)) if ghost else None)


def _coarse(scene: Scene, factor: int) -> Scene:
    return replace(scene, field=coarse(scene.field, factor))
