"""The folder in which a trial happens: recipes, heights and a data set, right and wrong ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from rsegen import Random, Recipe, make_dataset

_RECIPES = {
    "recipe.yaml": "chunks: [2, 1]\nobstacles:\n- {kind: peak, levels: 4, softness: 33.33333}\n"
    "- {kind: random, levels: 3}\n",
    "large.yaml": "chunk_size: 60\nchunks: [2, 1]\nboundary: none\nobstacles:\n- {kind: random, levels: 3}\n",
    "huge.yaml": "chunk_size: 1000\nchunks: 1000000000\nmaps: 4000000000000\nfirst_map: 4000000000\nboundary: none\n",
    "wrong.yaml": "obstacles:\n- {kind: peek, levels: 4}\n",
    "broken.yaml": "obstacles: [\n",
    "empty.json": "",
    "taken.txt": "a file\n",
    "heights.csv": "0,1,2\n3,4,5\n",
    "letters.csv": "a,b\nc\n",
    "broken.png": "no picture",
}


def fill(folder: Path) -> None:
    """Write the files that texts.FILES names; the rest of the names are of nothing."""
    for name, text in _RECIPES.items():
        (folder / name).write_text(text, "utf-8")
    (folder / "sub").mkdir()
    Image.fromarray(np.array([[0, 255, 90], [255, 0, 30]], dtype=np.uint8)).save(folder / "grey.png")
    rubble = Recipe(seed=1, chunk_size=5, maps=3, obstacles=[Random(levels=3)])
    make_dataset(rubble, folder / "data")
