"""Genesis: a map or a terrain as its height-field morph (1.4).

from rsegen.learning.genesis import terrain_morph

scene.add_entity(terrain_morph(course.field), material=gs.materials.Rigid(friction=course.recipe.friction))
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import genesis as gs
import numpy as np

from rsegen.errors import refuse_other
from rsegen.field.stepfield import StepField
from rsegen.learning.ground import position_of
from rsegen.learning.tile import SAMPLES, corner_heights


def terrain_morph(field: StepField, pos: Sequence[float] = (0, 0, 0), samples: int = 4) -> Any:
    """Return a height-field morph of a field, whose middle is at `pos` in metres.

    samples: of heights along each side of a block. A height field has slopes in place of vertical sides: the slope of a
    higher block begins at its edge, and ends on the lower one, a sample farther on.
    """
    refuse_other("field", field, StepField)
    samples, middle = SAMPLES.check("samples", samples), position_of(pos)
    return gs.morphs.Terrain(
        pos=tuple((middle - [*np.array(field.extent) / 2, 0.0]).tolist()),  # of its corner
        horizontal_scale=field.block_width / samples,
        vertical_scale=1.0,
        height_field=corner_heights(field.heights, samples),
    )
