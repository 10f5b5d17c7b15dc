"""Build the step field of a map: the obstacles in their order, the difficulty, the frames, the constraints.

    obstacles --placed--> patches --impose, in their order--> levels --scaled, framed, constrained--> StepField

Each obstacle proposes levels once, with a random generator of its own, and its `blend` combines them with those below.
Up to the difficulty, levels count from the ground, and are negative in pits; then `ground_level` is added to all.
The cost is one pass over the cells that each obstacle covers; constraints cost far more (recipe/constraints).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rsegen.errors import PluginError, TooLarge, inside, refuse_other, shown
from rsegen.field.stepfield import Levels, StepField, framed
from rsegen.obstacles import Grid, Obstacle, Patch
from rsegen.params.arrays import cast, namespace, overwrite
from rsegen.params.registry import is_own
from rsegen.params.sorts import Cell, Integer, Json
from rsegen.params.streams import SEEDS, generator
from rsegen.recipe.map_design import MapDesign

INDEX = Integer(0, SEEDS - 1, help="index of a map")


def build(recipe: MapDesign, index: int = 0) -> StepField:
    """Return the step field of one map of a recipe; it does not depend on which other maps are made.

    Parameters
    ----------
    recipe : Recipe
        The recipe, or the design of its maps.
    index : int, default 0
        Index of the map, 0 or more.

    Returns
    -------
    StepField
        The field.
    """
    refuse_other("recipe", recipe, MapDesign)
    index = INDEX.check("index", index)
    field = field_of(recipe, _at_difficulty(recipe, index))
    if not recipe.is_constrained:
        return field
    from rsegen.recipe.constraints.meeting import constrained

    return constrained(field, recipe, index)


def field_of(recipe: MapDesign, levels: Levels) -> StepField:
    """Return the field of a map with these levels of its blocks, (n_x, n_y), as the recipe says: frames, and metres."""
    levels, frame = framed(levels, recipe.chunk_size, recipe.boundary)
    return StepField(
        levels=levels,
        frame=frame,
        block_width=recipe.block_width_cm / 100,
        unit=recipe.unit_cm / 100,
        frame_height=recipe.frame_height_cm / 100,
    )


def blocks(recipe: MapDesign, index: int) -> Levels:
    """Return the levels of the blocks of map `index`, (n_x, n_y), frames left out, as `build(recipe, index).blocks`."""
    return build(recipe, index).blocks if recipe.is_constrained else _at_difficulty(recipe, INDEX.check("index", index))


def placed(recipe: MapDesign, obstacle: Obstacle, index: int) -> tuple[Cell, Cell, Patch]:
    """Return the cells of both ends of an obstacle in map `index`, and the levels that it proposes there."""
    rng, grid = generator(recipe.seed, index, obstacle.key or ""), recipe.grid
    first, last = obstacle.ends(grid, *obstacle.wanted_ends(grid), rng)
    patch = obstacle.patch(grid, first, last, rng)
    refuse_other_levels(obstacle, patch, grid)
    return first, last, patch


def refuse_other_levels(obstacle: Obstacle, patch: Any, grid: Grid) -> None:
    """Raise a PluginError if a plug-in's kind gives no fitting patch, or levels that are not of its `level_range`."""
    if is_own(obstacle):
        return
    if not isinstance(patch, Patch):
        expected = "expected a rsegen.obstacles.base.Patch"
        raise PluginError(f"obstacle kind {obstacle.kind}: patch() gave {shown(patch)}; {expected}")
    levels: Any = patch.levels
    if not isinstance(levels, np.ndarray) and hasattr(levels, "dtype"):  # a tensor, of many maps
        return
    kind = levels.dtype if isinstance(levels, np.ndarray) else type(levels).__name__
    if not isinstance(levels, np.ndarray) or levels.dtype.kind not in "iu":
        raise PluginError(f"obstacle kind {obstacle.kind}: levels of {kind}; expected integers")
    window = tuple(len(range(*part.indices(n))) for part, n in zip(patch.window, grid.shape, strict=True))
    shapes = levels.shape[-2:], np.shape(patch.footprint)[-2:]
    if any(shape not in (window, (window[0], 1), (1, window[1]), (1, 1)) for shape in shapes):
        problem = f"levels and footprint of the shapes {shapes[0]} and {shapes[1]}; its window has {window}"
        raise PluginError(f"obstacle kind {obstacle.kind}: {problem}")
    own = levels[np.broadcast_to(patch.footprint, levels.shape)]  # it may be the same in many maps
    low, high = obstacle.level_range
    if own.size and not low <= own.min() <= own.max() <= high:
        problem = f"levels {own.min()}..{own.max()} are not all in {low}..{high}"
        raise PluginError(f"obstacle kind {obstacle.kind}: {problem}; a profile is 0 to 1, and drawn() gives levels")


def placed_obstacles(recipe: MapDesign, index: int, *, only_by_chance: bool = False) -> Iterator[dict[str, Json]]:
    """Yield where each obstacle that is switched on lies in map `index`, as JSON, random ends as they were drawn.

    In block cells, frames left out: `first` and `last` are its ends, `patch` the number of `blocks` that it covers and,
    unless that is 0, the corners of their rectangle, `from` and `to`. only_by_chance: leave out obstacles of fixed ends
    """
    for row, obstacle in recipe.enabled_obstacles:
        if only_by_chance and fixed_ends(recipe.grid, obstacle) is not None:
            continue
        with inside(f"obstacles[{row}]"):
            first, last, patch = placed(recipe, obstacle, index)
        covered, corners = np.nonzero(patch.footprint), {}
        if blocks := len(covered[0]):
            starts = [part.indices(n)[0] for part, n in zip(patch.window, recipe.grid.shape, strict=True)]
            for name, far in (("from", np.min), ("to", np.max)):
                corners[name] = [start + int(far(at)) for start, at in zip(starts, covered, strict=True)]
        ends = {"first": [int(at) for at in first], "last": [int(at) for at in last]}
        yield {"row": row, "kind": obstacle.kind, **ends, "patch": {**corners, "blocks": blocks}}


def fixed_ends(grid: Grid, obstacle: Obstacle) -> tuple[Cell, Cell] | None:
    """Return the ends of an obstacle that has the same ones in all maps; None if they are drawn, or draws precede."""
    rng = np.random.Generator(np.random.PCG64(0))
    first, last = obstacle.wanted_ends(grid)
    if "random" in (*first, *last):
        return None
    before = rng.bit_generator.state
    ends = obstacle.ends(grid, first, last, rng)
    return ends if rng.bit_generator.state == before else None


def _at_difficulty(recipe: MapDesign, index: int) -> Levels:
    """Return the levels of all obstacles, scaled to the difficulty of the map, on its ground."""
    levels, level_range = flat_ground(recipe.grid), recipe.level_range
    for _, obstacle, patch in _patches(recipe, index):
        impose(levels, patch, obstacle.blend, level_range)
    if recipe.difficulty != 1:
        from rsegen.recipe.difficulty import scaled_to_difficulty

        levels = scaled_to_difficulty(levels, recipe, index)
    return levels + np.int16(recipe.ground_level)


def owners(recipe: MapDesign, index: int) -> NDArray[np.int32]:
    """Return the row of the obstacle that made each block of map `index`, (n_x, n_y); -1 for ground that none covers.

    That is the last one that replaced the level there, by an equal one perhaps, or changed it by another blend. A
    difficulty or constraint may change the level afterwards: the block stays with its obstacle.
    """
    levels, level_range = flat_ground(recipe.grid), recipe.level_range
    rows = np.full(levels.shape, -1, dtype=np.int32)
    for row, obstacle, patch in _patches(recipe, INDEX.check("index", index)):
        before = levels[patch.window].copy()
        impose(levels, patch, obstacle.blend, level_range)
        made = patch.footprint if obstacle.blend == "replace" else levels[patch.window] != before
        rows[patch.window][made] = row
    return rows


def covered_obstacles(recipe: MapDesign, index: int) -> list[tuple[int, tuple[int, ...]]]:
    """Return the row of each obstacle of map `index` of which later ones leave no block, and the rows of these.

    Only the blend "replace" covers: the others take the levels below into account.
    """
    if all(obstacle.blend != "replace" for _, obstacle in recipe.enabled_obstacles[1:]):
        return []
    # From the last obstacle to the first, so that each finds its blocks under those that were imposed after it.
    covered, top = [], np.full(recipe.grid.shape, -1, dtype=np.int32)
    for row, obstacle, patch in _patches(recipe, INDEX.check("index", index), from_last=True):
        above = top[patch.window]  # the last obstacle that replaced each block, of those after this one
        own = above[patch.footprint]
        if own.size and own.min() >= 0:
            covered.append((row, tuple(np.unique(own).tolist())))
        elif obstacle.blend == "replace":
            above[patch.footprint & (above < 0)] = row
    return covered[::-1]


def _patches(recipe: MapDesign, index: int, *, from_last: bool = False) -> Iterator[tuple[int, Obstacle, Patch]]:
    """Yield every obstacle that is switched on with its row, and the levels that it proposes."""
    for row, obstacle in recipe.enabled_obstacles[:: -1 if from_last else 1]:
        with inside(f"obstacles[{row}]"):
            *_, patch = placed(recipe, obstacle, index)
        yield row, obstacle, patch


def flat_ground(grid: Grid, maps: int | None = None) -> Levels:
    """Return level 0, counted from the ground, for every block: (n_x, n_y), or (maps, n_x, n_y).

    TooLarge if that does not fit into memory.
    """
    try:
        return np.zeros(grid.shape if maps is None else (maps, *grid.shape), dtype=np.int16)
    except (MemoryError, OverflowError, ValueError):
        where = "chunks: a map" if maps is None else f"indices: {maps:,} maps"
        raise TooLarge(f"{where} of {grid.n_x} x {grid.n_y} blocks would exceed this machine's memory") from None


def impose(levels: Any, patch: Patch, blend: str, level_range: tuple[int, int]) -> None:
    """Combine a patch with the levels of a map, or of many along the first axis, in place; arrays or tensors.

    level_range: the lowest and the highest level of any obstacle of the map, where sums are cut off.
    """
    below = levels[(..., *patch.window)]
    overwrite(below, _BLENDS[blend](below, patch.levels, level_range), patch.footprint)


_BLENDS: dict[str, Callable[[Any, Any, tuple[int, int]], Any]] = {
    "replace": lambda below, own, between: own,
    "max": lambda below, own, between: namespace(below).maximum(below, own),
    "min": lambda below, own, between: namespace(below).minimum(below, own),
    "add": lambda below, own, between: cast(namespace(below).clip(cast(below, "int32") + own, *between), "int16"),
}
