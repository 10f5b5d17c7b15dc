"""The next row of a terrain for a robot: a harder one if it walked far, an easier one if it hardly moved.

The rule is that of legged_gym (Rudin et al., Learning to walk in minutes, CoRL 2021; `_update_terrain_curriculum`) and
of Isaac Lab (`terrain_levels_vel`, `TerrainImporter.update_env_origins`). What breaks it: a robot that walks in circles
has walked no distance.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.learning.arrays import array_like, library_of


def next_rows(rows: Any, walked: Any, commanded: Any, *, count: int, length: float, rng: np.random.Generator) -> Any:
    """Return the next row of each robot, (robots,), in the library of `rows`.

    walked: distance from where each robot started, metres; commanded: distance that it was told to walk, its commanded
    speed times the time of an episode. count: number of rows; length: of a tile, metres; rng: draws rows.

    Up one row beyond half of a tile; else down one, if less than half of the commanded distance was walked. A robot
    that goes up from the last row has solved it, and gets a random row.
    """
    library, own = library_of("rows", rows)
    if "int" not in str(own.dtype) or own.ndim != 1:
        raise ParameterError("rows", f"{own.dtype} of shape {tuple(own.shape)}; give integers, one per robot")
    walked, commanded = (array_like(own, values) for values in (walked, commanded))
    up = walked > length / 2
    down = ~up & (walked < commanded / 2)
    after = own + array_like(own, up, own.dtype) - array_like(own, down, own.dtype)
    random = array_like(own, np.floor(rng.random(len(own)) * count), own.dtype)
    return library.where(after >= count, random, library.clip(after, 0, None))
