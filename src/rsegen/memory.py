"""Whether a recipe fits into this machine's memory: asked before anything is tried."""

from __future__ import annotations

from rsegen.errors import TooLarge
from rsegen.recipe import Recipe

BYTES_A_CELL = {"single": 1100, "multi": 200, "pallet": 1100}
"""Peak memory for each cell of a map, by mesh type: measured on random maps of 1000 x 1000, rounded up."""


def refuse_too_large(recipe: Recipe) -> None:
    """Raise TooLarge where one map would need more memory than is free."""
    cells = recipe.grid.n_x * recipe.grid.n_y
    needed, free = cells * BYTES_A_CELL[recipe.mesh_type], _free()
    if needed > free:
        raise TooLarge(
            f"chunks: a map of {recipe.grid.n_x} x {recipe.grid.n_y} blocks needs about {_giga(needed)} of memory, "
            f"and {_giga(free)} are free; give fewer chunks or a smaller chunk_size"
        )


def _free() -> int:
    import psutil

    return int(psutil.virtual_memory().available)


def _giga(size: int) -> str:
    return f"{size / 1e9:,.1f} GB" if size < 1e15 else f"{size / 1e9:.0e} GB"
