"""The obstacle kinds: every module in this package defines one and registers it when it is imported."""

from __future__ import annotations

from rsegen.obstacles.base import KINDS, Grid, Obstacle, Patch

__all__ = ["KINDS", "Grid", "Obstacle", "Patch"]
