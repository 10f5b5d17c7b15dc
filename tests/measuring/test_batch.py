"""Many maps at once have the metrics that each of them has by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Recipe
from rsegen.measuring import batch
from rsegen.measuring.batch import COLUMNS, batch_metrics
from rsegen.measuring.catalogue import flattened, nested
from rsegen.recipe.building import blocks
from tests.support.strategies import recipes


@given(recipes(), st.integers(0, 99), st.sampled_from([0, 10, 7.5]))
def test_many_maps_have_the_metrics_of_each(recipe: Recipe, first: int, frame: float) -> None:
    recipe = replace(recipe, frame_height_cm=frame)
    indices = range(first, first + 3)
    table = batch_metrics(np.array([blocks(recipe, index) for index in indices]), rsegen.build(recipe))
    assert tuple(table) == COLUMNS
    for number, index in enumerate(indices):
        alone = dict(flattened(nested(rsegen.metrics(rsegen.build(recipe, index)))))
        for name, column in table.items():
            assert column[number] == pytest.approx(alone[name], rel=1e-6, abs=1e-7), name


def test_large_maps_open_at_the_same_step_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    recipe = Recipe(seed=7, chunks=(1, 2), obstacles=[rsegen.Random(levels=5)])
    levels, like = np.array([blocks(recipe, index) for index in range(20)]), rsegen.build(recipe)
    at_once = batch_metrics(levels, like)
    monkeypatch.setattr(batch, "LARGE", 0)
    one_by_one = batch_metrics(levels, like)
    assert all(np.array_equal(at_once[name], one_by_one[name]) for name in COLUMNS)


def test_a_large_map_of_many_levels_has_its_deviation() -> None:
    """Half of its blocks are at the highest level; their squares times the blocks have more than 64 bits."""
    levels = np.zeros((2, 450, 450), dtype=np.int16)
    levels[:, :225] = 32766
    frame = np.zeros(levels.shape[1:], dtype=bool)
    like = rsegen.StepField(levels=levels[0], frame=frame, block_width=0.1, unit=0.01, frame_height=0.0)
    assert batch_metrics(levels, like)["spread.deviation"] == pytest.approx([163.83] * 2, rel=1e-6)


@pytest.mark.parametrize("boundary", ["none", "divided"])
def test_a_block_alone_has_no_steps(boundary: str) -> None:
    alone = rsegen.build(Recipe(seed=0, chunk_size=1, boundary=boundary))
    table = batch_metrics(np.ones((2, 1, 1), dtype=np.uint8), alone)
    assert np.isnan(table["steps.rms"]).all()
    assert np.isnan(table["ruggedness.tri"]).all()
    assert table["opening.west_east"].tolist() == pytest.approx([0.1, 0.1])
