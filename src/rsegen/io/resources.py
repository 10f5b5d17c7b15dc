"""Whether there is room for a recipe, in memory and on the disk: asked before anything is tried."""

from __future__ import annotations

import math
import shutil
from math import prod
from pathlib import Path

from rsegen.errors import TooLarge, shown
from rsegen.geometry import PIECE
from rsegen.recipe.recipe import Recipe

BYTES_PER_CELL = 16
"""Of memory for every cell of a map: measured between 1000 x 1000 and 4000 x 4000 blocks, rounded up."""

BYTES_PER_CELL_OF_DIFFICULTY = 150
"""While a map is eased: measured on random maps and peaks of 1000 x 1000 blocks, rounded up."""

BYTES_PER_CELL_OF_A_PIECE = {"merged": 1000, "blocks": 1000, "watertight": 3500}
"""While it is made into a mesh: measured on random pieces of 5 and of 100 levels, rounded up."""

BYTES_PER_CELL_OF_METRICS = 300
"""Of memory while a map is measured: between 180 and 290 on random maps of 1000 x 1000 blocks, by the robot."""

BYTES_PER_MAP = 1500
"""What is kept of each map that is done, to be told at the end: measured on thousands of maps, rounded down."""

BYTES_PER_WORKER = 50_000_000
"""What a worker takes before it has begun: measured with numpy 2.4, rounded up."""

DISK_BYTES_PER_MAP = 3 * 4096
"""What a map takes on the disk at the very least: three files, of a block each."""


def refuse_too_large(recipe: Recipe, more: int = 0) -> None:
    """Raise TooLarge where one map would need more memory than is free, with so many bytes more for each cell."""
    n_x, n_y = _shape(recipe)
    needed, free = _memory(recipe) + more * n_x * n_y, _free_memory()
    if needed > free:
        raise TooLarge(
            f"chunks: a map of {n_x} x {n_y} cells needs about {_giga(needed)} of memory, "
            f"and {_giga(free)} are free; give fewer chunks or a smaller chunk_size"
        )


def maps_in_memory(recipe: Recipe, more: int = 0) -> int:
    """How many of its maps fit into memory together, with so many bytes more for each cell."""
    each = _memory(recipe) + more * prod(_shape(recipe)) + BYTES_PER_WORKER
    return max(1, _free_memory() // each)


def refuse_too_many(maps: int, folder: Path) -> None:
    """Raise TooLarge where the maps would not fit on the folder's disk, nor what is kept of them into memory."""
    room = (("memory", BYTES_PER_MAP, _free_memory()), ("disk", DISK_BYTES_PER_MAP, _free_disk(folder)))
    for what, each, free in room:
        if maps * each > free:
            raise TooLarge(
                f"maps: {shown(maps)} of them need {_giga(maps * each)} of {what} or more, "
                f"and {_giga(free)} are free; give fewer, and the next ones from first_map on"
            )


def refuse_full(size: int, folder: Path) -> None:
    """Raise TooLarge where so many bytes would not fit on the folder's disk."""
    free = _free_disk(folder)
    if size > free:
        raise TooLarge(
            f"maps: they need {_giga(size)} of disk, and {_giga(free)} are free; give fewer, or another disk"
        )


def _memory(recipe: Recipe) -> int:
    """What one map takes at its peak, in bytes. A watertight mesh is made of a whole model at once."""
    cells = prod(_shape(recipe))
    model = (recipe.chunk_size + 2) ** 2 if recipe.mesh_type == "pallet" else cells
    piece = min(cells, model if recipe.mesh == "watertight" else PIECE**2)
    eased = BYTES_PER_CELL_OF_DIFFICULTY * (recipe.difficulty < 1)
    return cells * (BYTES_PER_CELL + eased) + piece * BYTES_PER_CELL_OF_A_PIECE[recipe.mesh]


def _shape(recipe: Recipe) -> tuple[int, int]:
    """Cells along x and y, frames included: small chunks have more frame than blocks."""
    chunks_x, chunks_y = recipe.chunks
    frames_x, frames_y = {"none": (0, 0), "outer": (2, 2), "divided": (2 * chunks_x, 2 * chunks_y)}[recipe.boundary]
    return recipe.grid.n_x + frames_x, recipe.grid.n_y + frames_y


def _free_memory() -> int:
    import psutil

    return int(psutil.virtual_memory().available)


def _free_disk(folder: Path) -> float:
    """Of the disk that the folder is on, or will be; no limit where there is no size, as in /proc."""
    there = next(above for above in (folder.absolute(), *folder.absolute().parents) if above.exists())
    usage = shutil.disk_usage(there)
    return usage.free if usage.total else math.inf


def _giga(size: float) -> str:
    return f"{size / 1e9:,.1f} GB" if size < 10**15 else "a million GB or more"
