"""The obstacle kinds: every module in this package defines one and registers it when it is imported."""

from __future__ import annotations

from rsegen.field.obstacles.base import KINDS, Grid, Obstacle, Patch


def kind(name: str, where: str = "kind") -> type[Obstacle]:
    """Return the obstacle class of a kind; UnknownName, which lists the kinds, if there is none."""
    return KINDS.named(name, where)


__all__ = ["KINDS", "Grid", "Obstacle", "Patch", "kind"]
