"""The build sheet as CSV: comments on what to cut, then a row per cell in placing order."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rsegen.exporters.numbers import decimal
from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet.cutting import CutSettings, centimetres, plan_cuts
from rsegen.exporters.sheet.frames import frames
from rsegen.exporters.sheet.order import NumberedPallet, building_order, length, length_counts, placing_order

COLUMNS = ("pallet", "order", "x", "y", "height_cm")
"""The columns of the rows; x and y count the block cells of the map; a cell without a block has no order."""

RECIPE_KEYS = ("chunk_size", "unit_cm", "block_width_cm", "boundary", "frame_height_cm")
"""The recipe parameters in the comments, from which the map can be imported again."""


def listing(scene: Scene, settings: CutSettings) -> Iterator[str]:
    """The lines of the CSV file; `#` starts a comment, and no comment has a comma."""
    yield f"# build sheet of {scene.name} with seed {scene.recipe.seed}\n"
    for name in RECIPE_KEYS:
        value = getattr(scene.recipe, name)
        yield f"# {name}: {decimal(value) if isinstance(value, float) else value}\n"
    yield from _timber(scene, settings)
    yield "# x (to the east) and y (to the north) count the cells of the map from 0 on with frames left out\n"
    yield "# order of placing in each pallet: row by row from the north-west; a cell without a block has none\n"
    yield ",".join(COLUMNS) + "\n"
    for pallet in building_order(scene):
        yield from _rows(pallet, scene)


def _timber(scene: Scene, settings: CutSettings) -> Iterator[str]:
    counts = length_counts(scene.field)
    for one, count in counts.items():
        yield f"# cut: {count} blocks of {centimetres(one)} cm\n"
    plan = plan_cuts(counts, settings)
    stock = f"{plan.pieces} pieces of {decimal(settings.stock_cm)} cm"
    yield f"# stock for the blocks: {stock} with a kerf of {decimal(settings.kerf_mm)} mm\n"
    for pattern in plan.patterns:
        parts = " + ".join(f"{count} x {centimetres(one)} cm" for one, count in pattern.parts)
        yield f"# saw: {pattern.pieces} pieces into {parts}\n"
    known = frames(scene.recipe)
    for one, count in known.all_boards.items() if known else ():
        yield f"# frames: {count} boards of {centimetres(one)} cm\n"


def _rows(numbered: NumberedPallet, scene: Scene) -> Iterator[str]:
    levels, order = numbered.levels, placing_order(numbered.levels)
    for j in range(levels.shape[1])[::-1]:
        for i in range(levels.shape[0]):
            x, y = np.add(numbered.corner, (i, j)).tolist()
            height = centimetres(length(int(levels[i, j]), scene.field))
            yield f"{numbered.name},{order[i, j] or ''},{x},{y},{height}\n"
