"""Data sets: very many maps of one recipe in few files, made in shards, resumed, checked, read as one array.

Recipe --make_dataset--> DIR --Dataset--> levels (maps, n_x, n_y), metrics, any map by its place
"""

from __future__ import annotations

from rsegen.io.dataset.making import make_dataset
from rsegen.io.dataset.reading import Dataset
from rsegen.io.dataset.tiles import Tiles

__all__ = ["Dataset", "Tiles", "make_dataset"]
