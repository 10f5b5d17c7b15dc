"""The field that every construction is tried on: lanes to drive along, and a corner to drop things on.

y
|  rubble     random levels: bodies are dropped on tops, near ledges and against walls
|  scattered  a plain with 25 % other cells, but for a track 0.4 m wide
|  lane       a lane 0.6 m wide through random levels
|  plain      one level
+---- x       in each of the three a square for every heading
"""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, radians, sin
from typing import NamedTuple

import numpy as np

from rsegen import StepField
from rsegen.field.stepfield import Levels
from tests.real.bodies import SHAPES, SIZE
from tests.real.burger import SPEED, Start

HEADINGS = (0, 20, 45, 70, 90)
GROUNDS = ("plain", "lane", "scattered")
SECONDS = 10
TILE = 26
"""Cells along each side of a square."""
RUBBLE = 12
"""Cells across the corner where bodies are dropped."""
WIDTH = 0.1
UNIT = 0.01
FLOOR = 2
"""Level of all that is driven on."""
LEVELS = 5
TRACKS = {"plain": 10.0, "lane": 0.6, "scattered": 0.4}
"""Metres across which a square is FLOOR for certain."""
OTHERS = {"plain": 0.0, "lane": 1.0, "scattered": 0.25}
"""Share of the cells beside the track whose level is drawn at random."""
DROP = 0.01
"""Metres that a body falls."""
BODIES = 9
"""Of each sort."""


class Drop(NamedTuple):
    """A body's name and shape, and where its lowest point comes to rest."""

    name: str
    shape: str
    x: float
    y: float
    top: float


def course(seed: int) -> StepField:
    """The whole field."""
    rng = np.random.default_rng(seed)
    strips = [np.concatenate([_square(ground, heading, rng) for heading in HEADINGS]) for ground in GROUNDS]
    rubble = rng.integers(0, LEVELS, (len(HEADINGS) * TILE, RUBBLE))
    return _field(np.concatenate([*strips, rubble], axis=1).astype(np.int16))


def nothing() -> StepField:
    """A field as large, of which nothing stands above the ground."""
    return _field(np.zeros((len(HEADINGS) * TILE, len(GROUNDS) * TILE + RUBBLE), dtype=np.int16))


def starts(field: StepField) -> dict[tuple[str, int], Start]:
    """Half of the way back from the middle of each square."""
    back = SPEED * SECONDS / 2
    found = {}
    for i, heading in enumerate(HEADINGS):
        for j, ground in enumerate(GROUNDS):
            x, y = ((k + 0.5) * TILE * WIDTH - side / 2 for k, side in zip((i, j), field.extent, strict=True))
            turn = radians(heading)
            top = float(field.heights[i * TILE + TILE // 2, j * TILE + TILE // 2])
            found[ground, heading] = Start(x - back * cos(turn), y - back * sin(turn), top, turn)
    return found


def drops(field: StepField) -> list[Drop]:
    """Bodies on the middle of tops, 1 cm from a ledge, and against a wall, no two in neighbouring cells."""
    rng = np.random.default_rng(0)
    first = len(GROUNDS) * TILE
    cells = [(i, j) for i in range(1, field.shape[0] - 1, 3) for j in range(first + 1, field.shape[1] - 1, 3)]
    found: dict[str, list[Drop]] = {"top": [], "ledge": [], "wall": []}
    for i, j in rng.permutation(cells).tolist():
        for sort, aside in _sorts(field, i, j):
            if len(found[sort]) < BODIES:
                shape = list(SHAPES)[len(found[sort]) % len(SHAPES)]
                x, y = (float(line[k] + line[k + 1]) / 2 for line, k in zip(field.edges(), (i, j), strict=True))
                name = f"{sort}-{shape}-{i}-{j}"
                found[sort].append(Drop(name, shape, x + aside, y, float(field.heights[i, j])))
                break
    return [drop for sort in found.values() for drop in sort]


def _sorts(field: StepField, i: int, j: int) -> Iterator[tuple[str, float]]:
    """Purpose of a cell, by what follows it along x, and distance from its middle at which a body falls."""
    here, there = field.levels[i, j], field.levels[i + 1, j]
    if there < here:
        yield "ledge", WIDTH / 2 - 0.01
    if there > here + 1:
        yield "wall", WIDTH / 2 - SIZE / 2 - 0.0005
    if here:
        yield "top", 0.0


def _square(ground: str, heading: int, rng: np.random.Generator) -> Levels:
    levels = np.where(rng.random((TILE, TILE)) < OTHERS[ground], rng.integers(0, LEVELS, (TILE, TILE)), FLOOR)
    middle = (np.arange(TILE) - (TILE - 1) / 2) * WIDTH
    turn = radians(heading)
    aside = middle[None, :] * cos(turn) - middle[:, None] * sin(turn)
    levels[np.abs(aside) <= TRACKS[ground] / 2] = FLOOR
    return levels.astype(np.int16)


def _field(levels: Levels) -> StepField:
    no_frame = np.zeros(levels.shape, dtype=bool)
    return StepField(levels=levels, frame=no_frame, block_width=WIDTH, unit=UNIT, frame_height=WIDTH)
