"""An obstacle at its place in a map: one row of a recipe's list."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import Annotated

from rsegen.errors import ParameterError, shown
from rsegen.field.obstacles import Obstacle
from rsegen.params.sorts import CellRef, Choice, Json, Place, Text, changed, validate


@dataclass(frozen=True, kw_only=True, slots=True)
class Placement:
    """An obstacle at its place: one row of the recipe's list.

    `key` names its randomness: while it stays, so does what was drawn for it. Where none is given the recipe derives
    one from the row itself, so that rows added, moved or removed leave the others as they were.
    """

    obstacle: Obstacle
    first: Annotated[Place | None, CellRef(help="one end or corner, x and y in block cells of the map")] = None
    last: Annotated[Place | None, CellRef(help="the other end or corner")] = None
    blend: Annotated[
        str, Choice(("replace", "max", "add", "min"), help="how it is combined with earlier obstacles")
    ] = "replace"
    key: Annotated[
        str | None,
        Text(
            r"[A-Za-z0-9_.\-]{1,64}",
            "1..64 letters, digits, _ . -",
            help="name of its random stream: the same key gives the same draw",
        ),
    ] = None

    def __post_init__(self) -> None:
        if not isinstance(self.obstacle, Obstacle):
            raise ParameterError("obstacle", f"{shown(self.obstacle)} is not an obstacle, such as rsegen.Peak(...)")
        validate(self)
        if self.first and self.last:
            self.obstacle.check(self.first, self.last)

    def entry(self) -> dict[str, Json]:
        """The row as a recipe file has it: what differs from the defaults, the kind first."""
        return {"kind": self.obstacle.kind} | changed(self.obstacle) | changed(self)


def with_keys(placements: tuple[Placement, ...]) -> tuple[Placement, ...]:
    """Every placement with a key of its own: the given ones, and for the rest one from their content."""
    taken = set()
    for number, placement in enumerate(placements):
        if placement.key in taken:
            raise ParameterError(f"obstacles[{number}].key", f"{shown(placement.key)} is another obstacle's key too")
        taken |= {placement.key} - {None}
    free: dict[str, Iterator[str]] = {}
    return tuple(placement if placement.key else _with_key(placement, taken, free) for placement in placements)


def _with_key(placement: Placement, taken: set[str | None], free: dict[str, Iterator[str]]) -> Placement:
    """Named after its content; `free` goes on numbering the rows of one content, `taken` are the given keys."""
    content = json.dumps(placement.entry(), sort_keys=True).encode()
    stem = f"{placement.obstacle.kind}-{hashlib.blake2b(content, digest_size=4).hexdigest()}"
    duplicates = free.setdefault(stem, (f"{stem}-{number}" if number else stem for number in count()))
    return replace(placement, key=next(key for key in duplicates if key not in taken))
