"""Pallets after NIST's patterns: as the measured one, whatever was drawn."""

from __future__ import annotations

import time

import numpy as np
import pytest

import rsegen
from rsegen.obstacles.pallet import _Limits
from rsegen.recipe.examples import EXAMPLES
from tests.support.long import long_unless

MEASURED = rsegen.load(EXAMPLES["red-diagonal-pallet"])
PATTERN = pytest.mark.parametrize("pattern", ["flat", "hill", "diagonal"])


def made(chunks: tuple[int, int] = (1, 1), side: int = 10, height: int = 5, **values: object) -> rsegen.Recipe:
    obstacle = rsegen.Pallet(levels=height, key="k", **values)  # type: ignore[arg-type]
    return rsegen.Recipe(
        seed=3,
        chunk_size=side,
        chunks=chunks,
        boundary="none",
        obstacles=[obstacle],
    )


def levels(recipe: rsegen.Recipe, index: int = 0) -> np.ndarray:
    return rsegen.build(recipe, index).blocks


def test_a_diagonal_is_made_of_the_blocks_of_the_measured_one() -> None:
    recipe = made()
    assert all(
        rsegen.build(recipe, index).level_counts() == rsegen.build(MEASURED).level_counts() for index in range(20)
    )


def test_a_diagonal_has_the_ridge_and_the_shoulders_of_the_measured_one() -> None:
    for one in (levels(MEASURED), *(levels(made(), index) for index in range(20))):
        i, j = np.indices(one.shape)
        assert (one[i == j] == 4).all()
        assert (one[i != j] < 4).all()
        assert sorted(one[abs(i - j) == 1]) == [2] * 9 + [3] * 9


def test_metrics_of_diagonals_are_near_the_measured_field() -> None:
    real = rsegen.metrics(rsegen.build(MEASURED))
    found = [rsegen.metrics(rsegen.build(made(), index)) for index in range(40)]
    assert all(one.steps.highest == real.steps.highest for one in found)
    assert np.mean([one.steps.mean for one in found]) == pytest.approx(real.steps.mean, rel=0.1)
    assert np.mean([one.steps.rms for one in found]) == pytest.approx(real.steps.rms, rel=0.05)
    assert np.mean([one.ruggedness.surface_ratio for one in found]) == pytest.approx(
        real.ruggedness.surface_ratio, rel=0.1
    )


def test_neighbours_in_diagonals_differ_less_often_than_in_the_measured_one() -> None:
    """As docs/metrics.md says."""
    assert list(rsegen.metrics(rsegen.build(MEASURED)).steps.counts.values()) == [28, 101, 51]
    found = [rsegen.metrics(rsegen.build(made(), index)).steps.counts for index in range(40)]
    assert np.mean([[one[units] for units in range(3)] for one in found], axis=0) == pytest.approx([41, 85, 54], abs=2)


@PATTERN
@pytest.mark.parametrize("height", long_unless({2, 3, 6, 9}.__contains__, range(2, 10), reason="another height"))
@pytest.mark.parametrize("symmetry", ["random", "symmetric"])
def test_every_size_and_height_can_be_made(pattern: str, height: int, symmetry: str) -> None:
    for side in (1, 2, 3, 5, 6, 11):
        found = levels(made(side=side, height=height, pattern=pattern, symmetry=symmetry))
        assert found.max(initial=0) <= height - 1
        assert pattern == "flat" or found.max() == height - 1


@PATTERN
def test_no_step_is_above_half_the_ridge(pattern: str) -> None:
    for index in range(20):
        steps = rsegen.metrics(rsegen.build(made(pattern=pattern), index)).steps
        assert max(steps.counts) == 2


def test_a_symmetric_pallet_is_its_own_mirror_image() -> None:
    assert all((found == found.T).all() for found in (levels(made(symmetry="symmetric"), index) for index in range(5)))
    for pattern in ("hill", "flat"):
        found = levels(made(pattern=pattern, symmetry="symmetric"))
        assert (found == found[::-1]).all()
        assert (found != found[:, ::-1]).any()


def test_pallets_are_turned_by_quarters() -> None:
    straight, turned = (levels(made(pattern="hill", turns=(turns,))) for turns in (0, 1))
    assert (straight[4:6] == 4).all()
    assert (turned[:, 4:6] == 4).all()
    assert (np.rot90(straight) == turned).all()


def test_patterns_and_turns_alternate_along_x() -> None:
    found = levels(made(chunks=(3, 2), pattern=("flat", "hill"), turns=(0, 0, 0, 1)))
    ridges = [[bool((tile == 4).any()) for tile in np.split(row, 3)] for row in np.split(found, 2, axis=1)]
    assert ridges == [[False, True, False], [True, False, True]]
    assert (found[4:6, 10:] < 4).any()
    assert (found[:10, 14:16] == 4).all()


def test_chunks_differ_and_are_made_of_the_same_blocks() -> None:
    tiles = np.split(levels(made(chunks=(4, 1))), 4)
    assert len({tile.tobytes() for tile in tiles}) == 4
    assert len({tuple(sorted(tile.ravel())) for tile in tiles}) == 1


def test_a_pallet_fills_the_rectangle_of_its_ends_alone() -> None:
    obstacle = rsegen.Pallet(levels=5, pattern=("diagonal",), first=(12, 3), last=(2, 8))
    recipe = rsegen.Recipe(
        seed=1,
        chunk_size=20,
        boundary="none",
        obstacles=[obstacle],
    )
    found = levels(recipe)
    assert found[2, 3] == found[12, 8] == 4
    outside = found.copy()
    outside[2:13, 3:9] = 0
    assert not outside.any()


def test_full_cubic_pallets_have_even_levels_in_half_units() -> None:
    assert set(np.unique(levels(made(height=9, step=2)))) == {0, 2, 4, 6, 8}
    with pytest.raises(rsegen.UserError, match="step: 5 is more than the highest level, 4"):
        made(step=5)


def test_a_small_pallet_of_very_many_levels_is_made_in_a_bounded_time() -> None:
    start = time.process_time()
    recipe = made(side=4, height=32767)
    assert sorted(levels(recipe).ravel())[-4:] == [32766] * 4
    assert time.process_time() - start < 60


def limits_of_failures(limits: _Limits, pallets: int, least: int, top: int, posts: int) -> list[list[int]]:
    """Limits that are tried for each pallet if only the last limit gives an order."""
    return [list(limits.of_a_pallet(least, top, posts)) for _ in range(pallets)]


def test_limits_rise_one_by_one_as_long_as_people_need_them_and_end_at_the_top() -> None:
    (tried,) = limits_of_failures(_Limits(), 1, least=2, top=200, posts=16)
    assert tried == [*range(2, 18), 21, 37, 101, 200]


def test_with_very_many_levels_few_limits_are_tried_and_pallets_begin_where_the_others_ended() -> None:
    tried = limits_of_failures(_Limits(), 2, least=2, top=32766, posts=16)
    assert tried == [[2, 18, 274, 4370, 32766], [32766]]


def test_after_many_failures_pallets_begin_where_the_others_ended() -> None:
    tried = limits_of_failures(_Limits(), 100, least=2, top=5, posts=16)
    assert tried[:80] == [[2, 3, 4, 5]] * 80
    assert tried[-1] == [5]


def test_a_pallet_is_tried_with_the_top_alone_if_that_is_the_least() -> None:
    assert list(_Limits().of_a_pallet(4, 4, 100)) == [4]
