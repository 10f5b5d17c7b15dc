"""The memory and disk space that a run needs, and how much of both is free: checked before anything is written."""

from __future__ import annotations

import math
import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path

from rsegen.errors import TooLarge, shown
from rsegen.geometry import PIECE
from rsegen.recipe.recipe import Recipe
from rsegen.recipe.tiles import tile_shape

BYTES_PER_CELL = 16
"""Of memory for every cell of a map: measured between 1000 x 1000 and 4000 x 4000 blocks, rounded up."""

BYTES_PER_CELL_OF_DIFFICULTY = 150
"""While a map is scaled to its difficulty: measured on random maps and peaks of 1000 x 1000 blocks, rounded up."""

BYTES_PER_CELL_OF_A_PIECE = {"merged": 1000, "blocks": 1000, "watertight": 3500}
"""While it is made into a mesh: measured on random pieces of 5 and of 100 levels, rounded up."""

BYTES_PER_CELL_OF_METRICS = 300
"""Of memory while a map is measured: between 180 and 290 on random maps of 1000 x 1000 blocks, by the robot."""

BYTES_PER_CELL_OF_HEIGHTS = 60
"""Of memory while heights of a file are made into a matrix: measured on arrays of 1000 and 2000 cells per side."""

BYTES_PER_MAP = 1500
"""Of memory for the result of each map until the run ends: measured on thousands of maps, rounded down."""

BYTES_PER_WORKER = 50_000_000
"""Of memory for a worker that has not begun: measured with numpy 2.4, rounded up."""

DISK_BYTES_PER_MAP = 3 * 4096
"""Of disk for a map at the very least: three files of one block each."""

MOST_WORK = 2 * 10**10
"""Obstacles times cells of one map: some minutes, if each obstacle covers the map."""

_UNITS = ("bytes", "kB", "MB", "GB", "TB")


@dataclass(frozen=True, kw_only=True, slots=True)
class Needs:
    """Bytes that a run needs at the least, and how many of its maps fit into the free memory at the same time.

    map_memory: while one map is made   results_memory: for what is known of all maps at the end   disk: for all files
    """

    map_memory: int
    results_memory: int
    disk: int
    maps_at_once: int


def check_needs(recipes: Sequence[Recipe], maps: int, folder: Path, bytes_per_cell: int = 0) -> Needs:
    """What a run needs that makes this number of maps of some recipes in a folder; TooLarge if less is free.

    bytes_per_cell: of memory for every cell of a map, beyond what its world needs
    """
    free = _free_memory()
    each = max((_checked_memory(recipe, bytes_per_cell, free) for recipe in recipes), default=0)
    needs = Needs(
        map_memory=each,
        results_memory=maps * BYTES_PER_MAP,
        disk=maps * DISK_BYTES_PER_MAP,
        maps_at_once=max(1, free // (each + BYTES_PER_WORKER)),
    )
    for what, size, most in (("memory", needs.results_memory, free), ("disk", needs.disk, _free_disk(folder))):
        if size > most:
            raise TooLarge(
                f"maps: {shown(maps)} maps need {format_bytes(size)} of {what} or more, {format_bytes(most)} are free; "
                "give fewer, and the next ones from first_map on"
            )
    return needs


def refuse_too_large(recipe: Recipe, bytes_per_cell: int = 0) -> None:
    """Raise TooLarge if one map needs more memory than is free, with `bytes_per_cell` more bytes for every cell."""
    _checked_memory(recipe, bytes_per_cell, _free_memory())


def refuse_many_heights(where: str, n_x: int, n_y: int) -> None:
    """Raise TooLarge if the heights of a file need more memory than is free."""
    needed, free = n_x * n_y * BYTES_PER_CELL_OF_HEIGHTS, _free_memory()
    if needed > free:
        raise TooLarge(
            f"{where}: {n_x} x {n_y} cells need about {format_bytes(needed)} of memory, {format_bytes(free)} are free"
        )


def maps_in_memory(recipe: Recipe, bytes_per_cell: int = 0) -> int:
    """How many of its maps fit into memory at the same time, with `bytes_per_cell` more bytes for every cell."""
    return max(1, _free_memory() // (_memory(recipe, bytes_per_cell) + BYTES_PER_WORKER))


def refuse_full(size: int, folder: Path) -> None:
    """Raise TooLarge if `size` bytes do not fit on the folder's disk."""
    free = _free_disk(folder)
    if size > free:
        raise TooLarge(
            f"maps: they need {format_bytes(size)} of disk, {format_bytes(free)} are free; give fewer, or another disk"
        )


def format_bytes(size: float) -> str:
    """A number of bytes in the unit in which it is easiest to read: 1.3 MB."""
    if size >= 10**15:
        return "a million GB or more"
    power = min(max(0, math.floor(math.log10(max(size, 1)) / 3)), len(_UNITS) - 1)
    return f"{size / 1000**power:,.{int(power > 0)}f} {_UNITS[power]}"


def _checked_memory(recipe: Recipe, bytes_per_cell: int, free: int) -> int:
    """The bytes of memory that one map needs; TooLarge if fewer are free, or if it would take hours."""
    needed = _memory(recipe, bytes_per_cell)
    if needed > free:
        n_x, n_y = tile_shape(recipe)
        raise TooLarge(
            f"chunks: a map of {n_x} x {n_y} cells needs about {format_bytes(needed)} of memory, "
            f"{format_bytes(free)} are free; give fewer chunks or a smaller chunk_size"
        )
    cells = prod(tile_shape(recipe))
    if len(recipe.obstacles) * cells > MOST_WORK:
        raise TooLarge(
            f"obstacles: {len(recipe.obstacles):,} of them on a map of {cells:,} cells would take too long; "
            f"give {MOST_WORK // cells:,} or fewer"
        )
    return needed


def _memory(recipe: Recipe, bytes_per_cell: int) -> int:
    """The bytes of memory that one map needs at its peak. A watertight mesh is made of a whole model at once."""
    cells = prod(tile_shape(recipe))
    model = (recipe.chunk_size + 2) ** 2 if recipe.mesh_type == "pallet" else cells
    piece = min(cells, model if recipe.mesh == "watertight" else PIECE**2)
    scaling = BYTES_PER_CELL_OF_DIFFICULTY * (recipe.difficulty != 1)
    return cells * (BYTES_PER_CELL + scaling + bytes_per_cell) + piece * BYTES_PER_CELL_OF_A_PIECE[recipe.mesh]


def _free_memory() -> int:
    """Bytes of memory that programs can have; Linux says it in a file, which is quicker than to import psutil."""
    with suppress(OSError), open("/proc/meminfo", encoding="ascii") as file:
        for line in file:
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    import psutil

    return int(psutil.virtual_memory().available)


def _free_disk(folder: Path) -> float:
    """Of the disk that the folder is on, or will be; no limit if the disk has no size, as in /proc."""
    nearest = next(above for above in (folder.absolute(), *folder.absolute().parents) if above.exists())
    usage = shutil.disk_usage(nearest)
    return usage.free if usage.total else math.inf
