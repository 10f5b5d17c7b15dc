"""Recipes to start from, each in a file of its own."""

from __future__ import annotations

from pathlib import Path

EXAMPLES = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.yaml"))}
"""Where each one is, by its name."""


def or_example(path: str | Path) -> Path:
    """The path, or the example that is called so where nothing stands at the path."""
    path = Path(path)
    return EXAMPLES[str(path)] if str(path) in EXAMPLES and not path.exists() else path
