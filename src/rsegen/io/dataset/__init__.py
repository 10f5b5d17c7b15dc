"""Data sets: very many maps of some recipes in few files, read as one array, and checked.

DIR --Dataset--> levels (maps, n_x, n_y), metrics, any map by its place
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rsegen.io.dataset.reading import Dataset
    from rsegen.io.dataset.tiles import Tiles

__all__ = ["Dataset", "Tiles"]

_HOMES = {"Dataset": "reading", "Tiles": "tiles"}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: to read one map of a data set takes none of them."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
