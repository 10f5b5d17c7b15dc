"""An obstacle that is switched off stays in the recipe, and is in no map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rsegen import Peak, Random, Recipe, build, build_many, load, save
from rsegen.cli.edge import main
from rsegen.cli.flags import obstacle_in
from rsegen.errors import ParameterError
from rsegen.gazebo import map_summary
from rsegen.obstacles import Obstacle
from rsegen.recipe.codec import decode
from tests.support.strategies import recipes

ROWS = [{"kind": "random", "levels": 3}, {"kind": "peak", "levels": 9}, {"kind": "peak", "levels": 9}]


def switched_off(recipe: Recipe, row: int) -> Recipe:
    rows = list(recipe.obstacles)
    rows[row] = replace(rows[row], enabled=False)
    return replace(recipe, obstacles=tuple(rows))


@given(recipes(), st.data())
@settings(max_examples=10)
def test_maps_are_those_without_the_obstacle(recipe: Recipe, data: st.DataObject) -> None:
    if not recipe.obstacles:
        return
    row = data.draw(st.integers(0, len(recipe.obstacles) - 1))
    off = switched_off(recipe, row)
    without = replace(recipe, obstacles=(*recipe.obstacles[:row], *recipe.obstacles[row + 1 :]))
    assert build(off, 2) == build(without, 2)
    assert np.array_equal(build_many(off, range(3)), build_many(without, range(3)))
    assert (off.top_level, off.highest_level) == (without.top_level, without.highest_level)
    assert decode({**off.values(), "obstacles": [obstacle.entry() for obstacle in off.obstacles]}) == off


def test_keys_that_are_derived_stay_the_same() -> None:
    """Two rows alike have keys of one hash; the second keeps its own while the first is switched off."""
    on = decode({"seed": 1, "obstacles": ROWS})
    off = decode({"seed": 1, "obstacles": [ROWS[0], {**ROWS[1], "enabled": False}, ROWS[2]]})
    assert [obstacle.key for obstacle in off.obstacles] == [obstacle.key for obstacle in on.obstacles]


def test_one_that_does_not_fit_may_be_switched_off_but_not_one_that_is_wrong_in_itself() -> None:
    outside = Peak(levels=5, first=(2, 2), last=(40, 7))
    with pytest.raises(ParameterError, match=r"obstacles\[0\]\.last\[0\]: 40 is outside 0\.\.9"):
        Recipe(seed=1, obstacles=[outside])
    off = Recipe(seed=1, obstacles=[replace(outside, enabled=False)])
    assert not build(off).levels.any()
    with pytest.raises(ParameterError, match=r"obstacles\[0\]\.levels"):
        decode({"obstacles": [{"kind": "peak", "levels": 0, "enabled": False}]})


@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_files_and_flags_have_it(suffix: str, tmp_path: Path) -> None:
    off: Obstacle = obstacle_in("peak levels=5 enabled=no")
    assert off == Peak(levels=5, enabled=False)
    recipe = Recipe(seed=1, obstacles=[Random(levels=3), off])
    save(recipe, tmp_path / f"recipe.{suffix}")
    assert load(tmp_path / f"recipe.{suffix}") == recipe
    with pytest.raises(ParameterError, match="'maybe' is neither yes nor no"):
        obstacle_in("peak levels=5 enabled=maybe")


def test_info_names_it(capsys: pytest.CaptureFixture[str]) -> None:
    recipe = Recipe(seed=1, obstacles=[Random(levels=3), Peak(levels=5, enabled=False)])
    assert map_summary.switched_off(recipe) == ["obstacles[1]: peak"]
    assert main(["info", "--seed", "1", "--obstacle", "random levels=3", "--obstacle", "peak levels=5 enabled=no"]) == 0
    assert "off      obstacles[1]: peak\n" in capsys.readouterr().out
