"""Difficulty: the rms step between blocks, as a share of that of the obstacles as they are."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rsegen import KINDS, Peak, Random, Recipe, StepField, build, generate, load
from rsegen.errors import ParameterError
from rsegen.field.steps import steps
from rsegen.params.sorts import parameters
from rsegen.recipe.codec import decode
from rsegen.recipe.examples import EXAMPLES
from tests.support.strategies import recipes

SHARES = st.floats(0, 1, exclude_max=True)
RISE = [number / 20 for number in range(21)]


def recipe_of(kind: str, levels: int = 5, softness: float = 0) -> Recipe:
    return Recipe(seed=3, obstacles=(KINDS[kind](levels=levels, softness=softness),))


SMALL: Mapping[str, Recipe] = {
    "random": recipe_of("random"),
    "random in 40 levels": recipe_of("random", levels=40),
    "random in 2 levels": recipe_of("random", levels=2),
    "normal random": recipe_of("normal_random"),
    "table": recipe_of("peak"),
    "cone": recipe_of("peak", softness=100),
    "horizontal barrier": recipe_of("horizontal_barrier"),
    "ridge": recipe_of("horizontal_barrier", softness=50),
    "diagonal barrier": recipe_of("diagonal_barrier"),
    "pallet": recipe_of("pallet"),
} | {name: load(path) for name, path in EXAMPLES.items() if name != "large-random"}
"""Ten by ten blocks and more."""


def squares(field: StepField) -> int:
    """Sum of the squared steps between neighbours, in levels."""
    return sum(step**2 * count for step, count in steps(field).counts.items())


def of_one_block(field: StepField) -> int:
    """Amount that one block, a unit higher, adds to the squared steps to its four neighbours at the most."""
    return 4 * (2 * max(steps(field).counts) + 1)


@pytest.mark.parametrize("recipe", SMALL.values(), ids=SMALL)
def test_the_measure_is_met_within_one_block(recipe: Recipe) -> None:
    whole = build(recipe)
    full = squares(whole) ** 0.5
    for share in RISE:
        reached = squares(build(replace(recipe, difficulty=share))) ** 0.5
        assert abs(reached - share * full) <= of_one_block(whole) / (reached + share * full + 1)


IN_FORTY = {name: recipe for name, recipe in SMALL.items() if max(recipe.grid.shape) <= 40}
"""Recipes whose places are on a map of forty blocks a side."""


@pytest.mark.parametrize("recipe", IN_FORTY.values(), ids=IN_FORTY)
@pytest.mark.parametrize("share", [0.25, 0.5, 0.75, 0.9])
def test_forty_blocks_a_side_come_within_three_hundredths(recipe: Recipe, share: float) -> None:
    recipe = replace(recipe, chunk_size=10, chunks=(4, 4), boundary="none")
    full = steps(build(recipe)).rms
    reached = steps(build(replace(recipe, difficulty=share))).rms
    assert full
    assert reached == pytest.approx(share * full, abs=0.03 * full)


@pytest.mark.slow
@given(recipes(), SHARES)
def test_any_recipe_comes_near_the_asked_roughness(recipe: Recipe, share: float) -> None:
    whole = build(recipe)
    full = squares(whole) ** 0.5
    reached = squares(build(replace(recipe, difficulty=share))) ** 0.5
    if full:
        assert abs(reached - share * full) <= 2 * of_one_block(whole) / (reached + share * full + 1)


@given(recipes(), SHARES, SHARES)
def test_more_difficulty_brings_no_block_nearer_to_the_ground(recipe: Recipe, one: float, other: float) -> None:
    shares = (*sorted((one, other)), 1)
    low, high, whole = (build(replace(recipe, difficulty=share)).blocks - recipe.ground_level for share in shares)
    for nearer, farther in ((low, high), (high, whole)):
        assert (np.abs(nearer) <= np.abs(farther)).all()
        assert (nearer.astype(int) * farther >= 0).all()


@given(recipes(), SHARES)
def test_a_higher_block_stays_as_high_or_higher(recipe: Recipe, share: float) -> None:
    whole, scaled_to_difficulty = build(recipe).blocks.ravel(), build(replace(recipe, difficulty=share)).blocks.ravel()
    for height in np.unique(whole):
        lowest = scaled_to_difficulty[whole == height].min()
        assert scaled_to_difficulty[whole < height].max(initial=lowest) == lowest


@given(recipes())
def test_difficulty_0_is_level_ground_and_1_the_recipe_as_it_is(recipe: Recipe) -> None:
    assert (build(replace(recipe, difficulty=0)).blocks == recipe.ground_level).all()
    assert build(replace(recipe, difficulty=1)) == build(recipe)


@given(recipes(), SHARES, st.integers(0, 5))
def test_a_map_of_lower_difficulty_is_the_same_alone(recipe: Recipe, share: float, index: int) -> None:
    recipe = replace(recipe, difficulty=share)
    assert build(recipe, index) == build(replace(recipe, first_map=index, maps=3), index)


@given(recipes(), SHARES)
@example(Recipe(seed=1, obstacles=(Random(levels=4, weights=(0, 0, 0, 1)),)), 0.5)
@example(Recipe(seed=1, chunk_size=1, chunks=(3, 3), obstacles=(Random(levels=5),)), 0.5)
def test_a_field_without_steps_is_lowered_as_one(recipe: Recipe, share: float) -> None:
    whole = build(recipe)
    if not any(steps(whole).counts):
        scaled_to_difficulty = build(replace(recipe, difficulty=share))
        from_ground = np.floor(share * (whole.blocks - recipe.ground_level) + 0.5)
        np.testing.assert_array_equal(scaled_to_difficulty.blocks - recipe.ground_level, from_ground)


def test_a_floor_is_in_two_parts_at_the_most() -> None:
    """A block of a plateau rises beside one that has risen already."""
    recipe = Recipe(seed=1, boundary="none", obstacles=(Peak(levels=5, first=(2, 2), last=(7, 7)),))
    table = build(recipe).levels > 0
    for share in RISE[1:-1]:
        levels = build(replace(recipe, difficulty=share)).levels[table]
        assert (np.diff(levels) != 0).sum() <= 1
        assert np.ptp(levels) <= 1


@pytest.mark.slow
@pytest.mark.long(reason="workers and --resume of other maps in make test")
def test_workers_and_resume_make_the_same_bytes(tmp_path: Path) -> None:
    recipe = replace(SMALL["normal random"], difficulty=0.37, maps=300, chunks=(2, 2))
    one, more = (generate(recipe, tmp_path / str(workers), workers=workers) for workers in (1, 2))
    shutil.rmtree(more.maps[7].folder)
    assert len(generate(recipe, tmp_path / "2", resume=True).already) == 299
    for here, there in zip(one.maps, more.maps, strict=True):
        assert [path.read_bytes() for path in here.files] == [path.read_bytes() for path in there.files]


@given(seed=st.integers(0, 2**63 - 1))
def test_a_range_is_drawn_for_each_map_and_for_it_alone(seed: int) -> None:
    recipe = replace(SMALL["random"], seed=seed, difficulty=(0.2, 0.7), maps=2)
    drawn = [recipe.difficulty_of(index) for index in range(40)]
    assert all(0.2 <= share <= 0.7 for share in drawn)
    assert max(drawn) - min(drawn) > 0.3
    for index in (0, 39):
        alone = replace(recipe, difficulty=drawn[index])
        assert build(recipe, index) == build(alone, index)


def test_a_range_with_steps_rises_from_map_to_map_and_begins_again() -> None:
    recipe = replace(SMALL["random"], difficulty=(0, 1, 5))
    assert [recipe.difficulty_of(index) for index in range(7)] == [0, 0.25, 0.5, 0.75, 1, 0, 0.25]
    assert not build(recipe, 5).levels.any()
    assert build(recipe, 4) == build(SMALL["random"], 4)


@pytest.mark.parametrize(
    ("given", "kept", "text"),
    [(0.5, 0.5, "0.5"), ([0, 1], (0.0, 1.0), "0,1"), ([0.25, 1, 9], (0.25, 1.0, 9), "0.25,1,9")],
    ids=str,
)
def test_difficulties_are_read_from_files_and_flags(given: object, kept: object, text: str) -> None:
    recipe, sort = decode({"seed": 1, "difficulty": given}), parameters(Recipe)["difficulty"]
    assert recipe.difficulty == kept
    assert recipe.entry()["difficulty"] == given
    assert sort.check("difficulty", sort.parse(text)) == kept
    assert decode({"seed": 1, "difficulty": sort.parse(sort.format(given))}) == recipe


@pytest.mark.parametrize(
    "given", [-0.1, [1, 0], [0.5], [0, 1, 1], [0, 1, 2, 3], [0, "x"], "hard", None, [0, 1, 2.5]], ids=str
)
def test_an_invalid_difficulty_is_refused(given: object) -> None:
    with pytest.raises(ParameterError, match="difficulty"):
        decode({"seed": 1, "difficulty": given})
