"""The obstacle in the form before it is added: its blocks, to be shown pale on plan and view."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rsegen.errors import ParameterError
from rsegen.exporters.scene import Scene
from rsegen.field.stepfield import Mask
from rsegen.gui.model.session import Entry
from rsegen.recipe.building import impose, placed
from rsegen.recipe.codec import decode_placement


@dataclass(frozen=True, kw_only=True, slots=True)
class Ghost:
    """scene: the map with the blocks of this obstacle alone; cells: (n_x, n_y), the field cells that it covers."""

    scene: Scene
    cells: Mask


def ghost_of(scene: Scene, entry: Entry) -> Ghost | None:
    """One more obstacle in a map, where it would lie if it were added; None if it is invalid.

    What constraints and difficulty would make of it is left out.
    """
    try:
        recipe = replace(scene.recipe, obstacles=(*scene.recipe.obstacles, decode_placement(entry)))
        *_, patch = placed(recipe, recipe.obstacles[-1], scene.index)
    except ParameterError:
        return None
    field = scene.field
    blocks = field.blocks
    impose(blocks, patch, recipe.obstacles[-1].blend, recipe.top_level)
    inside = np.ix_(field.inside(0), field.inside(1))
    covered = np.zeros(blocks.shape, dtype=bool)
    covered[patch.window] = patch.footprint
    cells, levels = np.zeros(field.shape, dtype=bool), np.zeros(field.shape, dtype=np.int16)
    cells[inside], levels[inside] = covered, np.where(covered, blocks, 0)
    alone = replace(field, levels=levels, frame=np.zeros_like(field.frame))
    return Ghost(scene=replace(scene, recipe=recipe, field=alone), cells=cells)
