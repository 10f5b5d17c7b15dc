"""The build sheet as CSV: comments on what to cut, then a row per cell in placing order."""

from __future__ import annotations

from collections.abc import Iterator

from rsegen import __version__
from rsegen.build_sheets.cut_settings import CutSettings
from rsegen.build_sheets.timber import (
    CuttingPlan,
    building_order,
    length,
    length_counts,
    losses,
    materials,
    placing_order,
    too_short,
    unknown_price,
)
from rsegen.heights.table import COLUMNS, RECIPE_KEYS
from rsegen.params.numbers import Lengths, decimal, lengths_in
from rsegen.scene.scene import Scene, fingerprint


def listing(scene: Scene, settings: CutSettings) -> Iterator[str]:
    """Yield the lines of the CSV file; `#` starts a comment, and no comment has a comma."""
    yield f"# build sheet of {scene.name} with seed {scene.recipe.seed}\n"
    yield f"# rsegen {__version__}\n"
    yield f"# fingerprint of the levels: {fingerprint(scene.field.blocks)}\n"
    for name in RECIPE_KEYS:
        value = getattr(scene.recipe, name)
        if name != "units" or value != "cm":
            yield f"# {name}: {decimal(value) if isinstance(value, float) else value}\n"
    written = lengths_in(scene.recipe.units)
    yield from _timber(scene, settings, written)
    yield "# x (to the east) and y (to the north) count the cells of the map from 0 on with frames left out\n"
    yield "# order of placing in each pallet: row by row from the north-west; a cell without a block has none\n"
    pallets = building_order(scene)
    for pallet in pallets if len(pallets) > 1 else ():
        yield f"# fingerprint of {pallet.name}: {fingerprint(pallet.levels)}\n"
    yield ",".join((*COLUMNS[:-1], f"height_{written.unit}")) + "\n"
    # From the north-west, row by row: in the order in which the blocks are placed.
    for pallet in pallets:
        levels, order = pallet.levels, placing_order(pallet.levels)
        for j in range(levels.shape[1])[::-1]:
            for i in range(levels.shape[0]):
                x, y = pallet.corner[0] + i, pallet.corner[1] + j
                height = written.short(length(int(levels[i, j]), scene.field))
                yield f"{pallet.name},{order[i, j] or ''},{x},{y},{height}\n"


def _timber(scene: Scene, settings: CutSettings, written: Lengths) -> Iterator[str]:
    needed = materials(scene.field, scene.recipe, settings)
    for block, count in length_counts(scene.field).items():
        yield f"# cut: {_counted(count, 'block')} of {written.tape(block)} {written.unit}\n"
    yield from _plan("blocks", "saw", needed.blocks, written)
    for board, count in needed.frames.items():
        yield f"# frames: {_counted(count, 'board')} of {written.tape(board)} {written.unit}\n"
    if needed.boards:
        yield from _plan("frames", "saw for frames", needed.boards, written)
    if short := " ".join(too_short(needed, written)):
        yield f"# stock for the frames: {short}\n"
    yield f"# base boards: {needed.bases} of {' x '.join(map(written.tape, needed.base))} {written.unit}\n"
    weights = f"{written.weight(needed.block_weight)} blocks + {written.weight(needed.frame_weight)} frames"
    yield f"# weight: {weights}\n".replace(",", "")
    if needed.price is not None:
        yield f"# cost without base boards: {needed.price:.2f}\n"
    elif settings.price is not None:
        yield f"# cost of the blocks: {needed.blocks.pieces * settings.price:.2f}\n"
        yield f"# cost of the frames: {unknown_price(needed)}\n"


def _plan(what: str, saw: str, plan: CuttingPlan, written: Lengths) -> Iterator[str]:
    stock = f"{_counted(plan.pieces, 'piece')} of {written.stock(plan.settings.stock)}"
    ends = f"{written.tape(plan.settings.trim)} {written.unit} of ends"
    yield f"# stock for the {what}: {stock} less {losses(plan.settings, written)} and {ends}\n"
    for pattern in plan.patterns:
        parts = " + ".join(f"{count} x {written.tape(part)} {written.unit}" for part, count in pattern.parts)
        yield f"# {saw}: {_counted(pattern.pieces, 'piece')} into {parts}\n"


def _counted(count: int, what: str) -> str:
    """Return a count in words, without a comma: 1 piece, 1200 pieces."""
    return f"{count} {what}{'s'[: count != 1]}"
