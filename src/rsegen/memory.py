"""Whether a recipe fits into this machine's memory: asked before anything is tried."""

from __future__ import annotations

from rsegen.errors import TooLarge, shown
from rsegen.recipe import Recipe

BYTES_A_CELL = {"single": 1100, "multi": 200, "pallet": 1100}
"""Peak memory for each cell of a map, by mesh type: measured on random maps of 1000 x 1000, rounded up."""


BYTES_A_MAP = 5000
"""What is kept of each map that is done, to be told at the end: measured on thousands of maps, rounded down."""


def refuse_too_large(recipe: Recipe) -> None:
    """Raise TooLarge where one map, or what is told of all maps at the end, would need more memory than is free."""
    n_x, n_y = _shape(recipe)
    needed, free = n_x * n_y * BYTES_A_CELL[recipe.mesh_type], _free()
    if needed > free:
        raise TooLarge(
            f"chunks: a map of {n_x} x {n_y} cells needs about {_giga(needed)} of memory, "
            f"and {_giga(free)} are free; give fewer chunks or a smaller chunk_size"
        )
    needed = recipe.maps * BYTES_A_MAP
    if needed > free:
        raise TooLarge(
            f"maps: {shown(recipe.maps)} of them need about {_giga(needed)} of memory, "
            f"and {_giga(free)} are free; give fewer, and the next ones from first_map on"
        )


def _shape(recipe: Recipe) -> tuple[int, int]:
    """Cells along x and y, frames included: small chunks have more frame than blocks."""
    frames = {"none": (0, 0), "outer": (2, 2), "divided": tuple(2 * chunks for chunks in recipe.chunks)}
    frames_x, frames_y = frames[recipe.boundary]
    return recipe.grid.n_x + frames_x, recipe.grid.n_y + frames_y


def _free() -> int:
    import psutil

    return int(psutil.virtual_memory().available)


def _giga(size: int) -> str:
    return f"{size / 1e9:,.1f} GB" if size < 10**15 else "a million GB or more"
