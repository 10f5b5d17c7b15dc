"""Maps that every format is tried on, and what it makes of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rsegen import Matrix, Random, Recipe, Scene, compose
from rsegen.formats.base import Format

RANDOM = Random(levels=5)
TOUCHING = Matrix.of(np.array([[3, 0, 2], [0, 1, 0]]))

RECIPES: Mapping[str, Recipe] = {
    "no frames, blocks of 8.5 cm": Recipe(
        seed=3, chunks=(2, 1), chunk_size=4, boundary="none", unit_cm=8.5, block_width_cm=8.5, obstacles=(RANDOM,)
    ),
    "frames round every chunk": Recipe(seed=4, chunks=(1, 3), chunk_size=3, obstacles=(RANDOM,)),
    "one frame of another height": Recipe(
        seed=5, chunks=(3, 2), chunk_size=3, boundary="outer", frame_height_cm=12.34, unit_cm=7, obstacles=(RANDOM,)
    ),
    "frames of no height": Recipe(seed=6, chunk_size=4, frame_height_cm=0, obstacles=(RANDOM,)),
    "blocks that touch along an edge": Recipe(
        seed=7, chunks=(2, 3), chunk_size=1, boundary="none", obstacles=(TOUCHING,)
    ),
    "one block": Recipe(seed=8, chunk_size=1, boundary="none", obstacles=(Matrix.of(np.array([[1]])),)),
    "frames alone": Recipe(seed=9, chunks=(2, 1), chunk_size=2),
    "nothing": Recipe(seed=10, chunk_size=2, boundary="none"),
}

SCENES: Mapping[str, Scene] = {name: compose(recipe) for name, recipe in RECIPES.items()}


def made(kind: Format, scene: Scene) -> dict[str, bytes]:
    """The whole content of each file."""
    return {path: b"".join(content) for path, content in kind.files(scene).items()}
