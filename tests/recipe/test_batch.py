"""Many maps at once are the maps that are built one by one, to the last level."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import Matrix, Random, Recipe
from rsegen.errors import ParameterError
from rsegen.field.obstacles import Grid, Patch
from rsegen.field.stepfield import Array, Levels
from rsegen.params.sorts import Cell
from rsegen.params.streams import generator, generators
from rsegen.recipe.examples import EXAMPLES
from tests.support.strategies import SEEDS, recipes

FAR = (0, 3, 2, 5000, 2**62, 3)


def _one_by_one(recipe: Recipe, indices: Iterable[int]) -> Levels:
    return np.array([rsegen.build(recipe, index).blocks for index in indices])


@given(recipe=recipes(), indices=st.lists(st.integers(0, 2**63 - 1), max_size=3))
def test_many_maps_equal_maps_built_one_by_one(recipe: Recipe, indices: list[int]) -> None:
    found = rsegen.build_many(recipe, [*indices, 0])
    assert found.dtype == np.int16
    assert np.array_equal(found, _one_by_one(recipe, [*indices, 0]))


@pytest.mark.parametrize("example", EXAMPLES)
@pytest.mark.parametrize("changes", [{}, {"difficulty": 0.4}, {"max_step": 1}], ids=str)
def test_many_maps_of_every_example_equal_maps_built_one_by_one(example: str, changes: dict[str, Any]) -> None:
    recipe = replace(rsegen.load(EXAMPLES[example]), **changes)
    assert np.array_equal(rsegen.build_many(recipe, FAR), _one_by_one(recipe, FAR))


@given(seed=SEEDS, index=st.integers(0, 2**63 - 1), key=st.text(max_size=20))
def test_generators_of_many_maps_equal_the_generators_of_each(seed: int, index: int, key: str) -> None:
    for at, rng in zip((index, 0), generators(seed, (index, 0), key), strict=True):
        assert rng.bit_generator.state == generator(seed, at, key).bit_generator.state
        assert rng.random() == generator(seed, at, key).random()


def test_maps_beyond_one_batch_are_those_built_one_by_one() -> None:
    recipe = Recipe(seed=4, chunk_size=3, obstacles=[Random(levels=6)])
    found, places = rsegen.build_many(recipe, range(20_000)), (0, 3640, 3641, 4095, 4096, 19_999)
    assert found.shape == (20_000, 3, 3)
    assert np.array_equal(found[list(places)], _one_by_one(recipe, places))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Raised(Random):
    """Random blocks, all raised by as many levels as one more draw says."""

    kind: ClassVar[str] = "raised"

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        patch = Random.patch(self, grid, first, last, rng)
        return patch._replace(levels=patch.levels + np.int16(3 * rng.random()))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Blurred(Random):
    """Random blocks, each as high as the mean along its row."""

    kind: ClassVar[str] = "blurred"

    def drawn(self, uniform: Array) -> Levels:
        return np.broadcast_to(uniform.mean(axis=1, keepdims=True) * 5, uniform.shape).astype(np.int16)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Shaken(Matrix):
    """Given levels, raised at random."""

    kind: ClassVar[str] = "shaken"

    def patch(self, grid: Grid, first: Cell, last: Cell, rng: np.random.Generator) -> Patch:
        patch = Matrix.patch(self, grid, first, last, rng)
        return patch._replace(levels=patch.levels + np.int16(3 * rng.random()))


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drawing(Random):
    """Random blocks that draw once before their levels, wherever they lie."""

    kind: ClassVar[str] = "drawing"

    def ends(self, grid: Grid, first: object, last: object, rng: np.random.Generator) -> tuple[Cell, Cell]:
        rng.random()
        return (0, 0), (grid.n_x - 1, grid.n_y - 1)


@pytest.mark.parametrize(
    "obstacle",
    [_Raised(levels=6), _Blurred(levels=6), _Shaken(levels=6, rows=("1 2", "0 .")), _Drawing(levels=6)],
    ids=lambda obstacle: obstacle.kind,
)
def test_kinds_that_draw_in_their_own_way_are_built_map_by_map(obstacle: rsegen.Obstacle) -> None:
    recipe = Recipe(seed=9, obstacles=[replace(obstacle, first=(0, 0), last=(7, 5))])
    found = rsegen.build_many(recipe, FAR)
    assert np.array_equal(found, _one_by_one(recipe, FAR))
    assert len(np.unique(found, axis=0)) > 1


def test_an_error_in_one_map_names_its_obstacle() -> None:
    recipe = Recipe(seed=1, obstacles=[Random(levels=9, max_step=1, key="steep")])
    with pytest.raises(ParameterError, match=r"^obstacles\[0\].max_step: 1: no order"):
        rsegen.build_many(replace(recipe, chunk_size=2), range(50))


@pytest.mark.parametrize("indices", [[-1], [2**63], [0.5], 7, ["1"]], ids=str)
def test_indices_are_whole_numbers_from_0_on(indices: object) -> None:
    with pytest.raises(ParameterError, match="indices"):
        rsegen.build_many(Recipe(seed=1), indices)  # type: ignore[arg-type]  # on purpose


def test_an_empty_list_of_indices_gives_no_map() -> None:
    assert rsegen.build_many(Recipe(seed=1), []).shape == (0, 10, 10)
