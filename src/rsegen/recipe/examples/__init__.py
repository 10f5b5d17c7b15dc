"""Recipes to start from, each in its own file."""

from __future__ import annotations

from pathlib import Path

EXAMPLES = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.yaml"))}
"""Paths of the examples, by name."""
