"""What a map needs besides its blocks, what it weighs and what it costs."""

from __future__ import annotations

from dataclasses import dataclass

from rsegen.exporters.sheet.cutting import CutSettings, CuttingPlan, nanometres, plan_cuts
from rsegen.exporters.sheet.frames import Frames, frames
from rsegen.exporters.sheet.order import length_counts
from rsegen.field.stepfield import StepField
from rsegen.recipe.recipe import Recipe

_METRE = 10**9


@dataclass(frozen=True, kw_only=True, slots=True)
class Materials:
    """The cutting plans of blocks and frames, base boards (number, sides in nm), weights [kg] and the total price.

    boards: None if there are no frames, or if one of them is longer than the stock; price: None if none was given
    """

    blocks: CuttingPlan
    frames: Frames | None
    boards: CuttingPlan | None
    bases: int
    base: tuple[int, int]
    block_weight: float
    frame_weight: float
    price: float | None


def materials(field: StepField, recipe: Recipe, settings: CutSettings) -> Materials:
    """The materials of a map."""
    blocks, known = plan_cuts(length_counts(field), settings), frames(recipe, settings.play)
    fits = known is not None and max(known.boards) <= settings.usable
    boards = plan_cuts(known.all_boards, settings) if known and fits else None
    side, high = recipe.block_width_cm / 100, recipe.frame_height_cm / 100
    bases, base = _bases(recipe, settings)
    return Materials(
        blocks=blocks,
        frames=known,
        boards=boards,
        bases=bases,
        base=base,
        block_weight=blocks.timber / _METRE * side**2 * settings.density,
        frame_weight=(known.timber if known else 0) / _METRE * side * high * settings.density,
        price=_price(blocks, boards, known, settings),
    )


def _bases(recipe: Recipe, settings: CutSettings) -> tuple[int, tuple[int, int]]:
    """A base board below each chunk, frames included, or one below the map if it has a frame round it."""
    m_x, m_y = recipe.chunks
    n_x, n_y = recipe.grid.shape if recipe.boundary == "outer" else (recipe.chunk_size,) * 2
    rim = 2 * nanometres(recipe.block_width_cm) + settings.play if recipe.boundary != "none" else 0
    width = nanometres(recipe.block_width_cm)
    return 1 if recipe.boundary == "outer" else m_x * m_y, (n_x * width + rim, n_y * width + rim)


def _price(
    blocks: CuttingPlan, boards: CuttingPlan | None, known: Frames | None, settings: CutSettings
) -> float | None:
    """The price of all timber whose price is given; None if that of some is missing."""
    if settings.price is None or (known and (boards is None or settings.frame_price is None)):
        return None
    return blocks.pieces * settings.price + (boards.pieces * (settings.frame_price or 0) if boards else 0)
