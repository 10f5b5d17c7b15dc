"""The preview of a map, with its size, level counts and costs, computed without Qt, so that a thread can do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rsegen.errors import TooLarge
from rsegen.exporters.map_summary import map_summary, warnings
from rsegen.exporters.scene import Scene, compose
from rsegen.field.stepfield import StepField, coarse, coarseness
from rsegen.gui.model.colours import GROUND, Rgb, centimetres, legend, rgb
from rsegen.gui.model.obstacle_ends import Ghost, ghost_of
from rsegen.gui.model.reach import Reach
from rsegen.gui.model.session import Entry
from rsegen.gui.model.simulation import reach
from rsegen.gui.model.solid import Lit, Solid, lit, solid
from rsegen.io.resources import refuse_too_large
from rsegen.recipe.recipe import Recipe

COUNTED = 100_000
"""Files are counted for maps of up to this many cells."""


class Share(NamedTuple):
    """How many blocks have one level, with the colour and name of the level."""

    colour: Rgb
    name: str
    blocks: int


class Costs(NamedTuple):
    """What a map costs in a few words, warnings about it, and what a robot can do on it."""

    text: str
    warnings: tuple[str, ...]
    reach: Reach | None = None


def size_text(scene: Scene) -> str:
    """The size of a map in cells and metres, and its largest step in cm."""
    (n_x, n_y), (along_x, along_y) = scene.field.shape, scene.field.extent
    step = centimetres(largest_step(scene.field))
    return f"{n_x} x {n_y} cells, {along_x:g} x {along_y:g} m, largest step {step}"


def shares(scene: Scene) -> list[Share]:
    """The block count of each level, from the lowest."""
    return [
        Share(rgb(scene, level) if level else GROUND, centimetres(level * scene.field.unit), count)
        for level, count in scene.field.level_counts().items()
    ]


def costs(scene: Scene, robot: str = "") -> Costs:
    """Warnings about a map, and unless it is too large: its models, faces and bytes, and what a robot can do on it.

    A map without obstacles gets no warning that it is empty.
    """
    found_warnings = warnings(scene) if scene.recipe.obstacles else ()
    n_x, n_y = scene.field.shape
    if n_x * n_y > COUNTED:
        return Costs("", found_warnings)
    found = map_summary(scene)
    models = f"{found.models:,} model{'s'[: found.models != 1]}"
    text = f"{models}, {found.faces:,} faces, {_size(found.bytes)}"
    return Costs(text, found_warnings, reach(scene.field, robot, scene.recipe.seed) if robot else None)


def largest_step(field: StepField) -> float:
    """The largest height difference between neighbouring cells [m], with frames and the ground around the map."""
    around = np.pad(field.heights, 1)
    return round(max(float(np.abs(np.diff(around, axis=axis)).max()) for axis in (0, 1)), 9)


def _size(size: int) -> str:
    return f"{size / 1000:,.0f} kB" if size < 1e6 else f"{size / 1e6:,.1f} MB"


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
    """Return whether the preview of a recipe takes no noticeable time."""
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
