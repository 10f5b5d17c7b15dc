"""Recipes to start from, each in its own file."""

from __future__ import annotations

from pathlib import Path

from rsegen.errors import FileError, did_you_mean

EXAMPLES = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.yaml"))}
"""Paths of the examples, by name."""


def or_example(path: str | Path) -> Path:
    """The path, or the example that is called so where nothing stands at the path."""
    path = Path(path)
    if path.exists():
        return path
    if str(path) not in EXAMPLES and "#" not in str(path) and (guess := did_you_mean(str(path), EXAMPLES)):
        raise FileError(f"{path}: neither a file nor the name of an example{guess}")
    return EXAMPLES.get(str(path), path)
