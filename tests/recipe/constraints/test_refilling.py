"""Blocks that a robot's path left unused go back to where the path does not need them away."""

from __future__ import annotations

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.recipe.constraints import meeting
from rsegen.recipe.constraints.inventory import refilled, used
from rsegen.recipe.constraints.meeting import crossing_caps
from tests.support.long import long_unless

STOCK = (27, 33, 21, 10)


def recipe(seed: int, climb: float) -> Recipe:
    return Recipe(
        seed=seed,
        boundary="none",
        inventory=STOCK,
        crossable_by=(climb, climb, 30),
        obstacles=(Random(levels=5),),
    )


@pytest.mark.slow
@pytest.mark.parametrize("climb", long_unless(lambda climb: climb > 5, [5.0, 10.0], reason="a lower step"))
def test_more_blocks_are_used_and_the_robot_still_crosses(climb: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over ten maps; of none more blocks than the stock has."""
    found = [rsegen.build(recipe(seed, climb), 0) for seed in range(10)]
    monkeypatch.setattr(meeting, "refilled", lambda field, *_: field)
    before = [rsegen.build(recipe(seed, climb), 0) for seed in range(10)]
    assert all(used(new) >= used(old) for new, old in zip(found, before, strict=True))
    assert sum(map(used, found)) > sum(map(used, before))
    limits = recipe(0, climb).crosser
    assert limits is not None
    for field in found:
        assert crossing_caps(field, limits) is None
        counts = np.bincount(field.levels.ravel(), minlength=5)[1:]
        assert (counts <= STOCK).all()


def test_no_more_blocks_are_put_back_than_were_asked_for() -> None:
    field = rsegen.build(Recipe(seed=1, boundary="none"), 0)
    left = np.array([9, 9, 9, 0])
    found = refilled(field, 5, np.full(field.shape, 2.5), left, lambda _: True)
    assert found.level_counts() == {0: 95, 2: 5}
    assert used(refilled(field, 5, np.full(field.shape, 2.5), left, lambda _: False)) == 0
