"""The memory and disk space that a run needs, checked against what is free before anything is written.

One rule for memory: a map needs its cells times the bytes of the step that needs the most, whatever is made of it, and
the memory of the piece of its mesh that is made at a time. For disk there is a lower bound: what a flat map needs.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from math import prod
from pathlib import Path
from typing import Literal, Protocol

from rsegen.errors import TooLarge, shown
from rsegen.geometry import PIECE
from rsegen.recipe.recipe import Recipe
from rsegen.writing import control_groups

Step = Literal["build", "measure", "surface", "mesh"]
"""A step of making a map, by its memory: a field; its metrics; its surface or boxes; a watertight mesh of all of it."""


class InMemory(Protocol):
    """Output made of a map, such as a format: the step that needs about as much memory, and its largest array.

    array_bytes: bytes per cell of the largest array that has several values per cell; 0 without such an array
    """

    @property
    def step(self) -> Step: ...  # noqa: D102  # the class says it
    @property
    def array_bytes(self) -> int: ...  # noqa: D102


BYTES_PER_CELL: Mapping[Step, int] = {"build": 50, "measure": 300, "surface": 2000, "mesh": 4000}
"""Memory per cell, by the step that makes something of a map.

Measured as the peak of a process less that for a map of 20 x 20, on random maps of 5 levels and, after the slash, of
100, which is the most: bytes per cell of 1000 x 1000 and, in brackets, of 2000 x 2000 or (*) 500 x 500 cells.

build    field 7 (5), preview 51 (35), heights of a file 65 (65), heightmap 28 (28), occupancy 19 (18), arrays 49 (45)
measure  metrics 182/182 (188; 290 with wide robots), series 183, page 195, scaled to its difficulty 76/76 (76; peaks
         100), world with collision blocks 401/479
surface  pieces of a world 114/235 (36/72), of blocks 181/223, with collision boxes 332/2173 (300; */2232),
         mjcf 400/669 (395/677), urdf 422/2201 (378), ros2 (387; */2258)
mesh     world watertight 2706 (*/3819), stl 2687 (*/3860), glb 2681 (*/3824), ply (*/3825), usd 2739 (*/3818),
         posture 2410/2712 (at 5 values per side of a block)
"""

_COLLISION: Mapping[str, Step] = {"mesh": "build", "blocks": "measure", "boxes": "surface"}
"""The step that needs about as much memory as the collision shapes of a world, which are a list of the whole map."""

_ARRAY_COPIES = 4
"""Copies in memory of an array with several values per cell.

Measured between 1.1 (heightmap) and 5 (posture) at 10 and 20 values per side: the mean, rounded up."""

BYTES_PER_MAP = 1500
"""Memory for the result of each map until the run ends: measured on thousands of maps, rounded down."""

BYTES_PER_WORKER = 50_000_000
"""Memory of a worker that has not begun: measured with numpy 2.4, rounded up."""

DISK_BYTES_PER_MAP = 3 * 4096
"""Disk space of a map at the very least: three files of one block each."""

MOST_WORK = 2 * 10**10
"""Obstacles times cells of one map: some minutes, if each obstacle covers the map."""

_UNITS = ("bytes", "kB", "MB", "GB", "TB")  # powers of 1000, as disks are sold


def check_needs(
    recipes: Sequence[Recipe], maps: int, folder: Path, step: Step = "build", things: Collection[InMemory] = ()
) -> int:
    """Return how many maps of a run fit into memory at once; TooLarge if it needs more memory or disk than is free.

    step: the one of all that are made of a map which needs the most memory, besides these things
    """
    # The largest map decides, as maps are made one by one; their results stay until the end, and all files on the disk.
    free = _free_memory()
    largest = max((_checked_memory(recipe, step, things, free) for recipe in recipes), default=0)
    results, files = maps * BYTES_PER_MAP, maps * DISK_BYTES_PER_MAP
    for resource, size, most in (("memory", results, free), ("disk", files, _free_disk(folder))):
        if size > most:
            raise TooLarge(
                f"maps: {shown(maps)} maps need {format_bytes(size)} of {resource} or more, "
                f"{format_bytes(most)} are free; make fewer, and the next ones from first_map on"
            )
    return max(1, free // (largest + BYTES_PER_WORKER))


def refuse_too_large(recipe: Recipe, step: Step = "build", things: Collection[InMemory] = ()) -> None:
    """Raise TooLarge if one map, up to this step and with these things, needs more memory than is free."""
    _checked_memory(recipe, step, things, _free_memory())


def refuse_many_heights(where: str, n_x: int, n_y: int) -> None:
    """Raise TooLarge if the heights of a file, as a map, need more memory than is free."""
    needed, free = _bytes(n_x * n_y, BYTES_PER_CELL["build"]), _free_memory()
    if needed > free:
        raise TooLarge(
            f"{where}: {n_x} x {n_y} cells need about {format_bytes(needed)} of memory, {format_bytes(free)} are free"
        )


def maps_in_memory(recipe: Recipe) -> int:
    """Return how many maps of a recipe fit into memory at the same time."""
    return max(1, _free_memory() // (_memory(recipe, "build", ()) + BYTES_PER_WORKER))


def refuse_full(size: int, folder: Path) -> None:
    """Raise TooLarge if `size` bytes do not fit on the folder's disk."""
    free = _free_disk(folder)
    if size > free:
        raise TooLarge(
            f"maps: they need {format_bytes(size)} of disk, {format_bytes(free)} are free; make fewer, or change disks"
        )


def format_bytes(size: float) -> str:
    """Return a number of bytes in the unit in which it is easiest to read: 1.3 MB."""
    if size >= 10**15:
        return "millions of GB"
    power = min(max(0, math.floor(math.log10(max(size, 1)) / 3)), len(_UNITS) - 1)
    return f"{size / 1000**power:,.{int(power > 0)}f} {_UNITS[power]}"


def _checked_memory(recipe: Recipe, step: Step, things: Collection[InMemory], free: int) -> int:
    """Return the bytes of memory that one map needs; TooLarge if fewer are free, or if it would take hours."""
    needed = _memory(recipe, step, things)
    if needed > free:
        n_x, n_y = recipe.cells
        raise TooLarge(
            f"chunks: a map of {n_x} x {n_y} cells needs about {format_bytes(needed)} of memory, "
            f"{format_bytes(free)} are free; use fewer chunks or a smaller chunk_size"
        )
    cells = prod(recipe.cells)
    if len(recipe.obstacles) * cells > MOST_WORK:
        raise TooLarge(
            f"obstacles: {len(recipe.obstacles):,} of them on a map of {cells:,} cells would take too long; "
            f"use {MOST_WORK // cells:,} or fewer"
        )
    return needed


def _memory(recipe: Recipe, step: Step, things: Collection[InMemory]) -> int:
    """Return the bytes of memory that one map needs at its peak. A watertight mesh is made of a whole model at once."""
    cells = prod(recipe.cells)
    most = max(
        BYTES_PER_CELL[step],
        BYTES_PER_CELL["measure"] * (recipe.difficulty != 1),
        BYTES_PER_CELL[_COLLISION[recipe.collision]],
        *(BYTES_PER_CELL[thing.step] + _ARRAY_COPIES * thing.array_bytes for thing in things),
    )
    if recipe.mesh != "watertight":
        return _bytes(cells, most)
    model = (recipe.chunk_size + 2) ** 2 if recipe.mesh_type == "pallet" else cells
    return cells * most + min(cells, model) * BYTES_PER_CELL["mesh"]


def _bytes(cells: int, per_cell: int) -> int:
    """Return the bytes of a map of some cells, and of the surface of a piece of it."""
    return cells * per_cell + min(cells, PIECE**2) * BYTES_PER_CELL["surface"]


def _free_memory() -> int:
    """Return the bytes of memory that this program can have: all free ones, or fewer in a container or a job."""
    return int(min(_free_on_machine(), control_groups.free_memory()))


def _free_on_machine() -> int:
    """Bytes of memory that programs can have; Linux says it in a file, which is quicker than to import psutil."""
    with suppress(OSError), open("/proc/meminfo", encoding="ascii") as file:
        for line in file:
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    import psutil

    return int(psutil.virtual_memory().available)


def _free_disk(folder: Path) -> float:
    """Return the free bytes of the folder's disk, infinitely many if the disk has no size, as in /proc."""
    nearest = next(above for above in (folder.absolute(), *folder.absolute().parents) if above.exists())
    usage = shutil.disk_usage(nearest)
    return usage.free if usage.total else math.inf
