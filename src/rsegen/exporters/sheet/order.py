"""The build order: pallets and blocks are numbered row by row from the north-west to the south-east.

A person at the south side of a pallet fills the far row first and never reaches over placed blocks; every block leans
on the frame or on the previous one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rsegen.exporters.scene import Scene
from rsegen.exporters.sheet.cutting import nanometres
from rsegen.field.stepfield import Ints, Levels, Pallet, StepField
from rsegen.params.places import Cell


@dataclass(frozen=True, kw_only=True, slots=True)
class NumberedPallet:
    """A pallet with its number in build order, from 1, its name and its first block cell in the map."""

    number: int
    name: str
    corner: Cell
    pallet: Pallet

    @property
    def levels(self) -> Levels:
        """The levels of its blocks, shape (n_x, n_y)."""
        return self.pallet.field.blocks


def building_order(scene: Scene) -> tuple[NumberedPallet, ...]:
    """The pallets of a map in build order."""
    side = scene.recipe.chunk_size
    pallets = sorted(scene.field.pallets(side), key=lambda pallet: (-pallet.chunk[1], pallet.chunk[0]))
    return tuple(
        NumberedPallet(
            number=number,
            name=name(pallet.chunk),
            corner=(pallet.chunk[0] * side, pallet.chunk[1] * side),
            pallet=pallet,
        )
        for number, pallet in enumerate(pallets, 1)
    )


def name(chunk: Cell) -> str:
    """The name of a pallet as on a chess board: a letter along x, a number along y, A1 in the south-west."""
    letters, column = "", chunk[0] + 1
    while column:
        column, letter = divmod(column - 1, 26)
        letters = chr(ord("A") + letter) + letters
    return f"{letters}{chunk[1] + 1}"


def placing_order(levels: Levels) -> Ints:
    """The placing order of each block, from 1, shape (n_x, n_y); 0 for no block."""
    as_read = levels.T[::-1]
    order = np.where(as_read > 0, np.cumsum(as_read > 0).reshape(as_read.shape), 0)
    return order[::-1].T


def length_counts(field: StepField) -> Mapping[int, int]:
    """The number of blocks of each length [nm], the shortest first."""
    counts = Counter({length(level, field): count for level, count in field.level_counts().items() if level})
    return dict(counts)


def length(level: int, field: StepField) -> int:
    """The length of a block of a level in nanometres."""
    return nanometres(round(level * field.unit * 100, 7))
