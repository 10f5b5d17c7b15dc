"""The paper's way: a loop over blocks in pure Python that writes 8 vertices and 6 faces each, a line at a time."""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

from benchmarks.grids import BLOCK, Levels

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_SIDES = ((4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))


def boxes_obj(levels: Levels, path: Path) -> int:
    """A box for each block."""
    count = 0
    with path.open("w", encoding="utf-8") as file:
        for i, row in enumerate(levels.tolist()):
            for j, level in enumerate(row):
                _block(file, (i, j, level), 8 * count)
                count += 1
    return 6 * count


def _block(file: TextIO, block: tuple[int, int, int], first: int) -> None:
    i, j, level = block
    for x, y, z in _CORNERS:
        file.write(f"v {(i + x) * BLOCK:.3f} {(j + y) * BLOCK:.3f} {z * level * BLOCK:.3f}\n")
    for a, b, c, d in _SIDES:
        file.write(f"f {first + a} {first + b} {first + c} {first + d}\n")
