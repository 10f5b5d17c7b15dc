"""From a recipe to a map: seeds, order, blends, frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rsegen import HorizontalBarrier, Obstacle, Peak, Pit, Random, Recipe, build
from rsegen.errors import ParameterError
from rsegen.recipe.building import blocks
from rsegen.recipe.from_field import largest_chunk, recipe_of
from tests.support.strategies import obstacles, recipes


@pytest.mark.slow
@given(recipes(), st.integers(0, 5))
def test_the_same_recipe_gives_the_same_map(recipe: Recipe, index: int) -> None:
    assert build(recipe, index) == build(replace(recipe), index)


@given(recipes(), st.integers(0, 5), st.integers(6, 1000))
def test_a_map_does_not_depend_on_how_many_are_made(recipe: Recipe, index: int, maps: int) -> None:
    assert build(replace(recipe, maps=maps), index) == build(replace(recipe, first_map=index), index)


@given(recipes())
def test_levels_stay_below_the_largest_number_of_levels(recipe: Recipe) -> None:
    levels = build(recipe).levels
    assert levels.min() >= 0
    assert levels.max() <= recipe.top_level


@given(recipes())
def test_a_map_has_the_size_of_its_chunks_and_frames(recipe: Recipe) -> None:
    around = {"none": (0, 0), "divided": (2 * recipe.chunks[0], 2 * recipe.chunks[1]), "outer": (2, 2)}[recipe.boundary]
    expected = tuple(m * recipe.chunk_size + more for m, more in zip(recipe.chunks, around, strict=True))
    assert build(recipe).shape == expected


@given(recipes())
def test_frames_move_no_obstacle(recipe: Recipe) -> None:
    bare = build(replace(recipe, boundary="none")).levels
    for boundary in ("divided", "outer"):
        np.testing.assert_array_equal(build(replace(recipe, boundary=boundary)).blocks, bare)


@given(recipes())
def test_frames_are_never_overwritten(recipe: Recipe) -> None:
    field = build(recipe)
    assert not field.levels[field.frame].any()


@given(recipes(), obstacles(), st.integers(0, 4))
def test_adding_an_obstacle_leaves_the_keys_of_the_others(recipe: Recipe, added: Obstacle, at: int) -> None:
    before = [obstacle.key for obstacle in recipe.obstacles]
    if added in [replace(obstacle, key=None) for obstacle in recipe.obstacles]:
        return  # a twin of another row: which of two equal rows is the new one has no answer
    at = min(at, len(before))
    rows = (*recipe.obstacles[:at], added, *recipe.obstacles[at:])
    after = replace(recipe, obstacles=rows, ground_level=recipe.ground_level - added.level_range[0])
    assert [key for number, key in enumerate(p.key for p in after.obstacles) if number != at] == before


def test_rows_without_keys_keep_their_randomness_when_rows_come_and_go() -> None:
    left = Random(levels=5, first=(0, 0), last=(4, 9))
    right = Random(levels=5, first=(5, 0), last=(9, 9))
    both = build(Recipe(seed=1, boundary="none", obstacles=(left, right))).levels
    alone = build(Recipe(seed=1, boundary="none", obstacles=(right,))).levels
    turned = build(Recipe(seed=1, boundary="none", obstacles=(right, left))).levels
    np.testing.assert_array_equal(both[5:], alone[5:])
    np.testing.assert_array_equal(both, turned)


def test_equal_rows_have_randomness_of_their_own() -> None:
    row = Random(levels=100, blend="max")
    one = build(Recipe(seed=1, obstacles=(row,)))
    two = build(Recipe(seed=1, obstacles=(row, row)))
    assert (two.levels >= one.levels).all()
    assert one != two


def test_a_key_keeps_the_randomness_while_parameters_change() -> None:
    low, high = (build(Recipe(seed=1, obstacles=(Random(levels=n, key="ground"),))).levels for n in (4, 8))
    np.testing.assert_array_equal(high // 2, low)


def test_seeds_and_maps_give_different_fields() -> None:
    rows = (Random(levels=5),)
    fields = [build(Recipe(seed=seed, obstacles=rows), index).levels.tobytes() for seed in (1, 2) for index in (0, 1)]
    assert len(set(fields)) == 4


@pytest.mark.parametrize(
    ("blend", "ridge", "beside"),
    [("replace", 2, 3), ("max", 3, 3), ("min", 2, 3), ("add", 4, 3)],
)
def test_blends_replace_raise_lower_and_add(blend: str, ridge: int, beside: int) -> None:
    plain = Random(levels=5, weights=(0, 0, 0, 1, 0))
    barrier = HorizontalBarrier(levels=3, first=(0, 4), last=(9, 4), blend=blend)
    levels = build(Recipe(boundary="none", obstacles=(plain, barrier))).levels
    assert set(levels[:, 4].tolist()) == {ridge}
    assert set(np.delete(levels, 4, axis=1).ravel().tolist()) == {beside}


def test_a_shape_overwrites_only_where_it_stands_and_a_random_kind_its_whole_region() -> None:
    plain = Random(levels=4, weights=(0, 0, 0, 1))
    peak = Peak(levels=3, first=(2, 2), last=(5, 5))
    flat = Random(levels=2, weights=(1, 0), first=(8, 0), last=(9, 9))
    levels = build(Recipe(boundary="none", obstacles=(plain, peak, flat))).levels
    assert levels[2, 2] == 3  # inside the peak's square, outside its circle
    assert levels[3, 3] == 2
    assert not levels[8:].any()


def test_a_random_horizontal_barrier_crosses_the_map() -> None:
    recipe = Recipe(seed=9, chunks=(1, 2), boundary="none", obstacles=(HorizontalBarrier(levels=2),))
    along = set()
    for index in range(30):
        levels = build(recipe, index).levels
        lines = [axis for axis in (0, 1) if levels.all(axis=axis).sum() == 1 and levels.sum() == levels.shape[axis]]
        assert len(lines) == 1
        along.add(lines[0])
    assert along == {0, 1}


def test_a_random_peak_is_a_square_inside_the_map_of_half_a_chunk_to_a_chunk() -> None:
    recipe = Recipe(seed=9, chunks=(2, 2), boundary="none", obstacles=(Peak(levels=2),))
    sides = set()
    for index in range(200):
        spans = [np.ptp(np.flatnonzero(build(recipe, index).levels.any(axis=axis))) + 1 for axis in (0, 1)]
        assert spans[0] == spans[1]
        sides.add(int(spans[0]))
    assert sides == {5, 6, 7, 8, 9, 10}


def test_four_small_chunks_and_one_large_chunk_have_equal_size() -> None:
    four, one = (
        build(Recipe(chunk_size=chunk_size, chunks=(m, m), boundary="none")) for chunk_size, m in ((10, 2), (20, 1))
    )
    assert four == one
    assert four.shape == (20, 20)
    assert build(Recipe(chunk_size=10, chunks=(2, 2))).shape == (24, 24)


@pytest.mark.parametrize(
    "asked",
    [{}, {"max_step": 1}, {"inventory": (50, 9)}, {"crossable_by": (10.0, 10.0, 53.0), "difficulty": 0.7}],
    ids=str,
)
def test_blocks_alone_equal_the_blocks_of_the_whole_map(asked: dict[str, Any]) -> None:
    """A data set has these: the map without frames, which keeps to all that it was asked for."""
    recipe = Recipe(seed=3, chunks=(2, 1), obstacles=(Random(levels=5),), **asked)
    free = build(replace(recipe, max_step=None, inventory=None, crossable_by=None), 1)
    assert (build(recipe, 1) == free) is not any(asked)
    np.testing.assert_array_equal(blocks(recipe, 1), build(recipe, 1).blocks)


def _on_ground(*rows: Obstacle, **changed: Any) -> Recipe:
    return Recipe(**{"boundary": "none", "seed": 1, "ground_level": 3, "obstacles": rows, **changed})


def test_blocks_that_no_obstacle_covers_are_at_the_level_of_the_ground() -> None:
    levels = build(
        _on_ground(Peak(levels=4, first=(3, 3), last=(6, 6)), Pit(levels=3, first=(0, 0), last=(1, 1)))
    ).levels
    assert (levels[:2, :2] == 1).all()
    assert levels[4, 4] == 6
    assert (levels[8:] == 3).all()


def test_pits_that_are_added_end_at_the_deepest_of_them() -> None:
    pits = [Pit(levels=n, key=str(n), blend="add", first=(0, 0), last=(n, n)) for n in (2, 4)]
    levels = build(_on_ground(*pits)).levels
    assert levels.min() == 0
    assert levels[4, 4] == 0
    assert levels[5, 5] == 3


@pytest.mark.parametrize("blend", ["min", "add", "replace"])
def test_a_pit_digs_into_what_stands_there(blend: str) -> None:
    table = Peak(levels=4, first=(0, 0), last=(9, 9))
    levels = build(_on_ground(table, Pit(levels=3, first=(4, 4), last=(5, 5), blend=blend))).levels
    assert levels[3, 4] == 6
    assert (levels[4:6, 4:6] == {"min": 1, "replace": 1, "add": 4}[blend]).all()


def test_a_pit_below_the_floor_is_refused() -> None:
    with pytest.raises(ParameterError) as caught:
        _on_ground(Random(levels=5), Pit(levels=5))
    assert str(caught.value) == (
        "obstacles[1]: pit reaches 4 units down, and the ground is at level 3; use a ground_level of 4 or more"
    )
    _on_ground(Random(levels=5), Pit(levels=5, enabled=False))


def test_ground_under_obstacles_that_would_be_too_high_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"ground_level: 32765 and obstacles of 4 units are above .*, 32766"):
        _on_ground(Random(levels=5), ground_level=32765)


@given(recipes())
def test_a_recipe_of_a_field_makes_the_field_again(recipe: Recipe) -> None:
    field = build(recipe)
    again = recipe_of(field)
    assert build(again) == field
    assert build(again, 3) == field
    assert recipe_of(build(again)) == again


@pytest.mark.parametrize(("sides", "chunk"), [((1, 1), 1), ((6, 4), 2), ((2000, 3000), 1000), ((1009, 1009), 1)])
def test_the_chunks_of_a_field_are_as_large_as_they_may_be(sides: tuple[int, int], chunk: int) -> None:
    assert largest_chunk(*sides) == chunk
