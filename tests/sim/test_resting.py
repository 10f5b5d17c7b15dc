"""Heights are true inside the simulator: what is dropped on a block comes to rest on its top."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

import rsegen
from rsegen.simulators import Installation
from rsegen.simulators.simulated import simulated
from sim.bodies import SHAPES, SIZE, body, furnished
from sim.maps import examples, generated, map_name, shaped, variants

DROP = 0.01
"""Metres that every body falls."""

Spot = tuple[str, str, float, float, float]
"""Name and shape of a body, and the middle of the top of the cell that it falls on."""


@pytest.mark.parametrize("recipe", [*examples(), *variants(), *shaped()], ids=map_name)
def test_bodies_rest_on_the_top_of_their_cell(recipe: rsegen.Recipe, gazebo: Installation, tmp_path: Path) -> None:
    made = generated(recipe, tmp_path)
    field = made.scene.field
    targets = list(spots(field))
    world = furnished(made.world, [body(name, shape, (x, y, top + DROP)) for name, shape, x, y, top in targets])

    run = simulated(gazebo, world, steps=1500)

    assert not run.errors
    inside = (field.block_width - SIZE) / 2
    for name, _, x, y, top in targets:
        at = run.poses[name]
        assert at.z == pytest.approx(top + SIZE / 2, abs=0.001), name
        assert (at.x, at.y) == pytest.approx((x, y), abs=inside), name


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
