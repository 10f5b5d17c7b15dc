"""An obstacle that later ones cover wholly is named in a warning."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from rsegen import Peak, Platform, Random, Recipe
from rsegen.cli.edge import main
from rsegen.gazebo.map_summary import warnings
from rsegen.recipe.building import blocks, covered_obstacles, owners, placed_obstacles
from rsegen.scene.scene import compose
from tests.support.strategies import recipes

PEAK = Peak(levels=5, first=(2, 2), last=(5, 5))
LINE = "obstacles[0] (peak) is wholly covered by obstacles[1] (random); the map has no block of it"
FLAGS = ("--seed", "1", "--obstacle", "peak levels=5 first=2,2 last=5,5", "--obstacle", "random levels=3")


def nearly_everywhere(recipe: Recipe) -> Random:
    """Return random blocks on all of the map but its last columns, so that much is covered, and not all."""
    n_x, n_y = recipe.grid.shape
    return Random(levels=2, first=(0, 0), last=(max(n_x - 3, 0), n_y - 1))


@given(recipes())
def test_an_obstacle_is_covered_if_it_makes_no_block(recipe: Recipe) -> None:
    rows = [*(replace(row, blend="replace") for row in recipe.obstacles), nearly_everywhere(recipe)]
    recipe = replace(recipe, obstacles=rows)
    made, covered = owners(recipe, 3), covered_obstacles(recipe, 3)
    with_blocks = [place["row"] for place in placed_obstacles(recipe, 3) if place["patch"]["blocks"]]
    assert [row for row, _ in covered] == [row for row in with_blocks if row not in made]
    assert all(row < min(over) and rows[row].enabled for row, over in covered)


@given(recipes())
def test_maps_are_the_same_without_a_covered_obstacle(recipe: Recipe) -> None:
    # The sums of "add" are cut off at the highest level of all obstacles, also of a covered one.
    rows = [replace(row, blend="max") if row.blend == "add" else row for row in recipe.obstacles]
    rows.append(nearly_everywhere(recipe))
    recipe = replace(recipe, obstacles=rows, difficulty=1, max_step=None, crossable_by=None, inventory=None)
    for row, _ in covered_obstacles(recipe, 0):
        off = [replace(obstacle, enabled=place != row) for place, obstacle in enumerate(rows)]
        assert np.array_equal(blocks(replace(recipe, obstacles=off), 0), blocks(recipe, 0))


def test_the_obstacles_that_cover_another_are_named() -> None:
    halves = [Platform(levels=2, first=(x, 0), last=(x + 4, 9)) for x in (0, 5)]
    recipe = Recipe(seed=1, obstacles=[PEAK, *halves])
    assert covered_obstacles(recipe, 0) == [(0, (1, 2))]
    said = "obstacles[0] (peak) is wholly covered by obstacles[1] (platform), obstacles[2] (platform)"
    assert warnings(compose(recipe, 0)) == (f"{said}; the map has no block of it",)
    assert not covered_obstacles(replace(recipe, obstacles=[PEAK, halves[0]]), 0)


@pytest.mark.parametrize(("over", "more"), [(3, ""), (4, " and 1 more")])
def test_of_many_obstacles_that_cover_another_three_are_named(over: int, more: str) -> None:
    columns = [Platform(levels=2, first=(x, 0), last=(x if x < 1 + over else 9, 9)) for x in range(2, 2 + over)]
    (said,) = warnings(compose(Recipe(seed=1, obstacles=[PEAK, *columns]), 0))
    assert said.count("platform") == 3
    assert said.endswith(f"obstacles[3] (platform){more}; the map has no block of it")


@pytest.mark.parametrize("blend", ["max", "add", "min"])
def test_a_blend_that_takes_the_levels_below_into_account_does_not_cover(blend: str) -> None:
    recipe = Recipe(seed=1, obstacles=[PEAK, Random(levels=3, blend=blend)])
    assert not covered_obstacles(recipe, 0)
    assert covered_obstacles(replace(recipe, obstacles=[PEAK, Random(levels=3)]), 0)


def test_generate_info_and_preview_say_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (("generate", "-o", str(tmp_path)), ("info",), ("preview", "-o", str(tmp_path / "map.png"))):
        assert main([*words, *FLAGS]) == 0
        assert capsys.readouterr().out.splitlines().count(f"warning: {LINE}") == 1
    assert main(["info", *FLAGS, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["warnings"] == [LINE]


def test_of_many_warnings_generate_prints_ten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [word for _ in range(15) for word in ("--obstacle", "peak levels=5")]
    assert main(["generate", "-o", str(tmp_path), "--seed", "1", *rows, "--obstacle", "random levels=3"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("warning: ") for line in lines) == 10
    assert "and 5 more warnings; rsegen info shows those of a map" in lines
