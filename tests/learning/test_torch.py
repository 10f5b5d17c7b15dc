"""PyTorch: the levels that tensors give are those of numpy, bit for bit; on the processor here, as CI has no GPU."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import KINDS, Peak, Random, Recipe
from rsegen.errors import ParameterError
from rsegen.field.stepfield import Levels
from rsegen.params.sorts import ANYWHERE, Cell
from rsegen.params.streams import Streams
from rsegen.recipe.batch import build_many, fill
from tests.support.strategies import recipes

torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
from rsegen.learning import torch as adapter  # noqa: E402  # it needs torch

MAPS = (0, 3, 2, 5000, 2**62, 3)


def _by_tensors(recipe: Recipe, cells: int = 2**22) -> Levels:
    """Return the maps as a device makes them: on the processor, which `build_many` of the adapter leaves to numpy."""
    levels = torch.zeros((len(MAPS), *recipe.grid.shape), dtype=torch.int16)
    fill(levels, recipe, MAPS, cells, cells)
    return np.asarray(levels.numpy())


@given(recipe=recipes(), difficulty=st.floats(0, 1), max_step=st.sampled_from([None, 1, 2]))
def test_tensors_have_the_levels_of_numpy(recipe: Recipe, difficulty: float, max_step: int | None) -> None:
    recipe = replace(recipe, difficulty=difficulty, max_step=max_step)
    assert np.array_equal(_by_tensors(recipe), build_many(recipe, MAPS))


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("changes", [{}, {"difficulty": (0, 1)}, {"difficulty": (0.1, 1, 4), "max_step": 2}], ids=str)
def test_every_kind_is_that_of_numpy(kind: str, changes: dict[str, Any]) -> None:
    below, own = Random(levels=4, weights=(1, 0, 2, 1)), KINDS[kind](levels=5, softness=30, blend="add")
    recipe = Recipe(seed=5, chunks=(1, 2), ground_level=4, obstacles=[below, own], **changes)
    assert np.array_equal(_by_tensors(recipe), build_many(recipe, MAPS))


@pytest.mark.parametrize(
    "obstacle",
    [
        Random(levels=3, counts=(30, 0, 70)),
        Random(levels=4, first=ANYWHERE, last=ANYWHERE),
        Random(levels=3, max_step=1),
    ],
    ids=("counts", "drawn ends", "max_step"),
)
def test_blocks_that_are_shuffled_placed_or_reordered_are_those_of_numpy(obstacle: Random) -> None:
    recipe = Recipe(seed=5, obstacles=[obstacle])
    assert np.array_equal(_by_tensors(recipe), build_many(recipe, MAPS))


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize(("first", "last"), [((8, 7), (1, 2)), ((1, 7), (8, 2)), ((0, 1), (0, 0))])
def test_a_mirrored_kind_is_that_of_numpy(kind: str, first: Cell, last: Cell) -> None:
    if kind == "horizontal_barrier":
        last = (first[0], last[1])
    own = KINDS[kind](levels=3, first=first, last=last)
    recipe = Recipe(seed=5, ground_level=2, obstacles=[own])
    assert np.array_equal(_by_tensors(recipe), build_many(recipe, MAPS))


def test_maps_made_in_parts_are_the_same() -> None:
    recipe = Recipe(seed=5, difficulty=0.4, obstacles=[Random(levels=6), Peak(levels=4)])
    assert np.array_equal(_by_tensors(recipe, cells=1), _by_tensors(recipe))


def test_numbers_on_a_device_are_those_of_numpy() -> None:
    streams = Streams.of(3, MAPS, "key")
    tensors = streams.on_device_of(torch.zeros(1))
    assert np.array_equal(tensors.arrays((40, 40)).numpy(), streams.arrays((40, 40)))


def test_levels_are_a_tensor_on_the_device() -> None:
    recipe = Recipe(seed=5, obstacles=[Random(levels=6)])
    levels = adapter.build_many(recipe, range(7), device="cpu")
    assert (levels.dtype, levels.device.type, tuple(levels.shape)) == (torch.int16, "cpu", (7, 10, 10))
    assert np.array_equal(levels.numpy(), build_many(recipe, range(7)))


@pytest.mark.parametrize("device", ["toaster", "meta", 0.5], ids=str)
def test_a_device_that_cannot_be_used_is_refused(device: Any) -> None:
    with pytest.raises(ParameterError, match=r"^device: .* cannot be used .*use cuda or cpu$"):
        adapter.build_many(Recipe(seed=1), [0], device=device)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU of CUDA")
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("difficulty", [1, 0.5])
def test_every_kind_on_a_gpu_is_that_of_numpy(kind: str, difficulty: float) -> None:
    obstacles = [Random(levels=4), KINDS[kind](levels=5, softness=30, blend="add")]
    recipe = Recipe(seed=5, ground_level=4, obstacles=obstacles, difficulty=difficulty)
    levels = adapter.build_many(recipe, range(500), device="cuda")
    assert np.array_equal(levels.cpu().numpy(), build_many(recipe, range(500)))
