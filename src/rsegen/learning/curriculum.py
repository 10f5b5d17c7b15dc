"""The next row of each robot in a terrain whose rows get harder.

A harder row if a robot walked far, an easier one if it hardly moved: the rule of legged_gym (Rudin et al., Learning to
walk in minutes, CoRL 2021; `_update_terrain_curriculum`) and of Isaac Lab (`terrain_levels_vel`,
`TerrainImporter.update_env_origins`). What breaks it: a robot that walks in circles has walked no distance.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rsegen.errors import ParameterError
from rsegen.learning.arrays import (
    array_like,
    as_type,
    draws_of,
    is_real,
    is_traced,
    is_whole,
    library_of,
)
from rsegen.params.sorts import Float, Integer

_COUNT, _LENGTH = Integer(1), Float(1e-6, unit="m")


def next_rows(rows: Any, walked: Any, commanded: Any, *, count: int, length: float, rng: Any) -> Any:
    """Return the next row of each robot in a terrain whose rows get harder.

    Up one row beyond half of a tile; else down one, if less than half of the commanded distance was walked. A robot
    that goes up from the last row has solved it, and gets a random row.

    Parameters
    ----------
    rows : array of int, shape (robots,)
        Present row of each robot, in an array of numpy, torch or jax.
    walked : array, shape (robots,)
        Distance from where each robot started, metres.
    commanded : array, shape (robots,)
        Distance that it was commanded to walk, metres: its commanded speed times the time of an episode.
    count : int
        Number of rows.
    length : float
        Length of a tile, metres.
    rng : numpy.random.Generator, torch.Generator, key of jax, or None for torch's own
        Draws rows; in a function that jax compiles a key, as numbers of numpy would be drawn only once; in
        `torch.compile(fullgraph=True)` None, as its compiler takes no Generator.

    Returns
    -------
    array of int, shape (robots,)
        The next rows, in the library of `rows`.
    """
    library, own = library_of("rows", rows)
    if not is_whole(own) or own.ndim != 1:
        raise ParameterError("rows", f"{own.dtype} of shape {tuple(own.shape)}; expected integers, one per robot")
    count, length = _COUNT.check("count", count), _LENGTH.check("length", length)
    walked, commanded = (_of_robots(own, *named) for named in (("walked", walked), ("commanded", commanded)))
    up = walked > length / 2
    down = ~up & (walked < commanded / 2) & (own > 0)  # below 0 is a large number where rows are unsigned
    after = own + array_like(own, up, own.dtype) - array_like(own, down, own.dtype)
    return library.where(after >= count, _drawn_rows(rng, own, count), library.clip(after, 0, None))


def _of_robots(rows: Any, where: str, values: Any) -> Any:
    """Return a value per robot as an array in the library of their rows; a single number counts for all."""
    own = array_like(rows, values)
    if not (is_real(own) or is_whole(own)):
        raise ParameterError(where, f"of {own.dtype}; expected metres")
    if tuple(own.shape) not in {(), tuple(rows.shape)}:
        raise ParameterError(where, f"of shape {tuple(own.shape)} for {len(rows)} robots; expected one for each")
    return own


def _drawn_rows(rng: Any, rows: Any, count: int) -> Any:
    """Return a random row below `count` for each robot, as an array of the type of their rows."""
    if not isinstance(rng, np.random.Generator):
        library, _ = library_of("rows", rows)
        # rows * 0.0: an array of real numbers of their shape, on their device.
        return as_type(library.floor(next(draws_of(rng, library, "rng"))("uniform", rows * 0.0) * count), rows.dtype)
    if is_traced(rows):
        raise ParameterError("rng", "a Generator of numpy draws only once in what jax compiles; use a key of jax")
    return array_like(rows, np.floor(rng.random(len(rows)) * count), rows.dtype)
