"""The obstacle kinds: every file of this folder is one, and is found by being there."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from importlib import import_module

from rsegen.errors import UnknownName
from rsegen.obstacles.base import Grid, Obstacle, Patch, registered

for _module in pkgutil.iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

KINDS: Mapping[str, type[Obstacle]] = registered()
"""Every obstacle class by the name of its kind."""


def kind(name: str, where: str = "kind") -> type[Obstacle]:
    """The obstacle class of a kind, or an UnknownName that lists the kinds."""
    if not isinstance(name, str) or name not in KINDS:
        raise UnknownName.among(where, "obstacle kind", name, KINDS)
    return KINDS[name]


__all__ = ["KINDS", "Grid", "Obstacle", "Patch", "kind"]
