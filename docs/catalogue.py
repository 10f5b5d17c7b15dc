"""Pictures of each kind of obstacle in the manual: ends and softness at which its picture shows what its name says."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from rsegen import KINDS, Obstacle, Recipe
from rsegen.page.model.texts import command_line

_STAIRS = ("0 0 1 1 2 2 3 3 4 4",) * 5 + ("4 4 3 3 2 2 1 1 0 0",) * 5

_ROWS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "diagonal_barrier": {"softness": 20, "first": (0, 0), "last": (9, 9)},
        "discrete_obstacles": {"count": 5},
        "horizontal_barrier": {"softness": 20, "first": (0, 5), "last": (9, 5)},
        "matrix": {"rows": _STAIRS},
        "pallet": {"pattern": ("flat", "hill", "diagonal")},
        "peak": {"softness": 80, "first": (1, 1), "last": (8, 8)},
        "pit": {"gap_width": 2, "beam_width": 2, "first": (1, 1), "last": (8, 8)},
        "platform": {"softness": 20, "first": (3, 3), "last": (6, 6)},
        "rails": {"levels": 3},
        "stones": {"uneven": 1},
    }
)
"""Parameters that differ from levels=5 and the defaults, by kind; a kind without any is shown by itself."""

_CHUNKS = MappingProxyType({"pallet": (3, 1)})
"""Of kinds whose map has more than one chunk."""


def recipe_of(kind: str) -> Recipe:
    """The recipe of a kind's picture: it alone on a map of 10 x 10 blocks, or on several for what differs by chunk."""
    obstacle = obstacle_of(kind)
    return Recipe(name=kind, seed=5, chunks=_CHUNKS.get(kind, (1, 1)), **_ground(obstacle), obstacles=(obstacle,))


def command(kind: str) -> str:
    """The command that makes the map of a kind's picture."""
    whole = command_line(recipe_of(kind), "worlds")
    return re.sub(r" key=[\w-]+", "", whole)


def obstacle_of(kind: str, cells: int = 10, **changed: Any) -> Obstacle:
    """Return the obstacle of a kind's picture, on a map of `cells` x `cells` blocks; with other parameters."""
    row = {"levels": 5, **_ROWS.get(kind, {}), **changed}
    first, last = (_scaled(row.pop(name, None), cells) for name in ("first", "last"))
    return KINDS[kind](**row, first=first, last=last)


def softnesses(kind: str) -> Iterator[tuple[str, Recipe]]:
    """Maps of a kind at softness 0, 50 and 100, on a map of 20 x 20 blocks; with a title for each."""
    for softness in (0, 50, 100):
        obstacle = obstacle_of(kind, 20, softness=softness, **({} if kind == "matrix" else {"levels": 9}))
        if kind == "matrix":
            obstacle = replace(obstacle, first=(0, 0), last=(19, 19))
        name = f"{kind}-{softness}"
        shape = {"chunk_size": 20, "unit_cm": 5, "boundary": "none", **_ground(obstacle)}
        recipe = Recipe(name=name, seed=5, **shape, obstacles=(obstacle,))
        yield f"softness {softness}", recipe


def boundaries() -> Iterator[tuple[str, Recipe]]:
    """Four chunks with each of the boundaries; with a title for each."""
    for boundary in ("none", "divided", "outer"):
        row = obstacle_of("normal_random")
        yield boundary, Recipe(name=f"boundary-{boundary}", seed=5, chunks=(2, 2), boundary=boundary, obstacles=(row,))


def constrained() -> Iterator[tuple[str, Recipe]]:
    """One map of random blocks without a constraint, and with each; with a title for each."""
    limits = {"max_step": 2, "crossable_by": "crawler", "inventory": (27, 33, 21, 10)}
    yield "as designed", Recipe(name="random", seed=7, obstacles=(KINDS["random"](levels=5),))
    for limit, value in limits.items():
        shown = ", ".join(map(str, value)) if isinstance(value, tuple) else value
        changed: Mapping[str, Any] = {limit: value}
        yield f"{limit}: {shown}", Recipe(name="random", seed=7, obstacles=(KINDS["random"](levels=5),), **changed)


def _ground(obstacle: Obstacle) -> Mapping[str, Any]:
    """Return the ground that an obstacle reaches down into, without frames, which would be lower than it."""
    depth = -obstacle.level_range[0]
    return {"ground_level": depth, "boundary": "none"} if depth else {}


def _scaled(cell: tuple[int, int] | None, cells: int) -> tuple[int, int] | None:
    """A cell of a map of 10 x 10 blocks where it is on a larger one; none if there is none."""
    if cell is None:
        return None
    x, y = (round(at * (cells - 1) / 9) for at in cell)
    return x, y
