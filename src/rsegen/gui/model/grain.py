"""The end grain of wooden blocks in the 3D view: how bright each point of their tops is."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.exporters.textures import pine
from rsegen.geometry.texture import SHIFT, TILES
from rsegen.gui.model.shading import FINEST, Floats, Shading
from rsegen.params.streams import generator

_FINEST = 24
"""Texels along the side of a block of a small map."""

_COARSEST = 6
"""Of fewer texels the grain would be noise."""

_BRIGHTEST = 1.1
"""The brightest wood, as a share of what it has on average: the light map can only darken."""


def finest(scene: Scene) -> int:
    """Texels along a cell of a light map, at most."""
    return _FINEST if scene.recipe.look == "wood" else FINEST


def with_grain(found: Shading, scene: Scene) -> Shading:
    """The light of a scene, darker where the wood of tops is, if it has the look of wood and is fine enough."""
    if scene.recipe.look != "wood" or found.fine < _COARSEST:
        return found
    light, start = found.light.copy(), found.fine * found.rim
    tops = _tops(scene, found.fine)
    light[start : start + tops.shape[0], start : start + tops.shape[1]] *= tops
    return found._replace(light=light)


@lru_cache(maxsize=2)
def _brightness(seed: int) -> Floats:
    """How bright the texture of tops is, 1 on average; x along the first axis."""
    tones = pine.top(generator(seed, 0, "textures of blocks"))
    bright = pine.PALETTE @ (0.3, 0.59, 0.11)
    found = bright[np.clip(np.rint(tones * 63), 0, 63).astype(np.intp)] / bright[pine.MEAN]
    return np.asarray(np.minimum(found / _BRIGHTEST, 1).T, dtype=np.float32)


def _tops(scene: Scene, fine: int) -> Floats:
    """The grain of every cell, (fine n_x, fine n_y); 1 where no block stands."""
    field, texture = scene.field, _brightness(scene.recipe.seed)
    i, j = np.indices(field.shape)
    across, along = (i + SHIFT[0] * field.levels) % TILES, (j + SHIFT[1] * field.levels) % TILES
    within = ((np.arange(fine) + 0.5) / fine * pine.PIXELS).astype(np.intp)
    rows = (across[:, None, :, None] * pine.PIXELS) + within[None, :, None, None]
    columns = (along[:, None, :, None] * pine.PIXELS) + within[None, None, None, :]
    found = texture[rows, columns]
    bare = ((field.levels == 0) & ~field.frame)[:, None, :, None]
    return np.where(bare, np.float32(1), found).reshape(fine * field.shape[0], fine * field.shape[1])
