"""Bodies that fall on a few cells of every level of a map, and where they must come to rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.simulators.poses import Pose
from tests.real.bodies import SHAPES, SIZE, body, furnished
from tests.real.maps import Map

DROP = 0.01
"""Metres that every body falls."""
FALL = 600
"""Steps of a millisecond after which they rest: they fall for 45 of them."""

Spot = tuple[str, str, float, float, float]
"""Name and shape of a body, and the middle of the top of the cell that it falls on."""


def falling(made: Map) -> Path:
    """The world of a map with bodies above it."""
    return furnished(made.world, bodies(made.scene.field))


def bodies(field: rsegen.StepField, east: float = 0.0, name: str = "") -> Iterator[str]:
    """Bodies above a field whose middle is east of the origin, metres; their names begin with a name."""
    return (body(name + spot, shape, (x + east, y, top + DROP)) for spot, shape, x, y, top in spots(field))


def judge(field: rsegen.StepField, poses: Mapping[str, Pose], east: float = 0.0, name: str = "") -> None:
    """Each body must be on the top of its cell."""
    inside = (field.block_width - SIZE) / 2
    for spot, _, x, y, top in spots(field):
        at = poses[name + spot]
        assert at.z == pytest.approx(top + SIZE / 2, abs=0.001), name + spot
        assert (at.x, at.y) == pytest.approx((x + east, y), abs=inside), name + spot


def spots(field: rsegen.StepField) -> Iterator[Spot]:
    """Up to three cells of every level, 0 too, and three of the frame, each with another shape; always the same."""
    rng = np.random.default_rng(0)
    x, y = ((line[:-1] + line[1:]) / 2 for line in field.edges())
    shapes = cycle(SHAPES)
    for level in np.unique(np.where(field.frame, -1, field.levels)):
        cells = np.argwhere(field.frame if level < 0 else (field.levels == level) & ~field.frame)
        for i, j in rng.permutation(cells)[: len(SHAPES)].tolist():
            shape = next(shapes)
            yield f"{shape}-{i}-{j}-level-{level}", shape, float(x[i]), float(y[j]), float(field.heights[i, j])
