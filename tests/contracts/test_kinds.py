"""Contract of all kinds of obstacles: a new file is tested here the moment it exists."""

from __future__ import annotations

from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from rsegen import KINDS, Obstacle, Recipe, build
from rsegen.obstacles import Grid
from rsegen.obstacles.base import PLACING, RESERVED, own_parameters, row_parameters
from rsegen.params.registry import name_conflict, summary_of_class
from rsegen.params.sorts import parameters
from rsegen.params.streams import generator
from rsegen.recipe.codec import decode, encode, schema

KIND = pytest.mark.parametrize("cls", KINDS.values(), ids=list(KINDS))
GRIDS = pytest.mark.parametrize("grid", [Grid(10, 10, 10), Grid(20, 30, 10), Grid(1, 1, 1), Grid(7, 1, 1)], ids=str)


GRID = Grid(20, 30, 10)


def recipe_of(obstacle: Obstacle, grid: Grid = GRID) -> Recipe:
    chunks = grid.n_x // grid.chunk_size, grid.n_y // grid.chunk_size
    ground = -obstacle.level_range[0]
    return Recipe(
        chunk_size=grid.chunk_size, chunks=chunks, boundary="none", ground_level=ground, seed=5, obstacles=(obstacle,)
    )


@KIND
@GRIDS
@pytest.mark.parametrize("softness", [0, 37.5, 100])
def test_levels_lie_in_the_range_of_the_obstacle(cls: type[Obstacle], grid: Grid, softness: float) -> None:
    recipe = recipe_of(cls(levels=5, softness=softness), grid)
    found = {level for index in range(20) for level in np.unique(build(recipe, index).levels).tolist()}
    assert found <= {0, 1, 2, 3, 4}


@KIND
def test_an_obstacle_on_higher_ground_is_the_same_obstacle(cls: type[Obstacle]) -> None:
    low = recipe_of(cls(levels=5, softness=20))
    high = replace(low, ground_level=low.ground_level + 7)
    for difficulty in (1.0, 0.4):
        built = [build(replace(recipe, difficulty=difficulty), 3).levels for recipe in (low, high)]
        np.testing.assert_array_equal(built[0] + 7, built[1])


@KIND
@GRIDS
def test_random_ends_lie_on_the_map(cls: type[Obstacle], grid: Grid) -> None:
    obstacle = cls(levels=5)
    for index in range(50):
        first, last = obstacle.ends(grid, ("random", "random"), ("random", "random"), generator(5, index, "k"))
        assert all(0 <= at < cells for at, cells in zip((*first, *last), grid.shape * 2, strict=True))


@KIND
def test_random_ends_differ_from_map_to_map(cls: type[Obstacle]) -> None:
    obstacle = cls(levels=5)
    places = {
        obstacle.ends(Grid(20, 30, 10), ("random", "random"), ("random", "random"), generator(5, index, "k"))
        for index in range(20)
    }
    assert len(places) > 5


@KIND
def test_given_coordinates_stay(cls: type[Obstacle]) -> None:
    grid = Grid(20, 30, 10)
    for index in range(20):
        first, last = cls(levels=5).ends(grid, (3, "random"), ("random", 12), generator(5, index, "k"))
        assert first[0] == 3
        assert last[1] == 12


@KIND
def test_patch_fits_its_window(cls: type[Obstacle]) -> None:
    patch = cls(levels=5, softness=60).patch(Grid(20, 30, 10), (2, 4), (2, 9), generator(5, 0, "k"))
    shape = tuple(part.stop - part.start for part in patch.window)
    assert patch.levels.shape == patch.footprint.shape == shape
    assert patch.levels.dtype == np.int16
    assert patch.footprint.dtype == np.bool_


@KIND
def test_every_kind_round_trips_through_a_file(cls: type[Obstacle]) -> None:
    recipe = recipe_of(cls(levels=7, softness=12.5))
    assert decode(encode(recipe)) == recipe


@KIND
def test_schema_accepts_encoded_recipes_and_refuses_a_strange_key(cls: type[Obstacle]) -> None:
    content = encode(recipe_of(cls(levels=7, softness=12.5)))
    jsonschema.validate(content, schema())
    content["obstacles"][0]["hight"] = 3
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, schema())


@KIND
def test_every_parameter_is_explained(cls: type[Obstacle]) -> None:
    assert summary_of_class(cls).endswith(".")
    assert all(parameter.help and parameter.describe() for parameter in parameters(cls).values())


@KIND
def test_parameters_that_place_an_obstacle_are_the_same_for_every_kind(cls: type[Obstacle]) -> None:
    assert name_conflict(cls, RESERVED, Obstacle) == ""
    assert {name: parameters(cls)[name] for name in PLACING} == PLACING


@KIND
def test_a_row_has_the_kind_its_own_parameters_and_then_those_of_its_place(cls: type[Obstacle]) -> None:
    obstacle = cls(enabled=False, key="k", blend="max", last=(4, 3), first=(2, 3), softness=10, levels=5)
    row = list(obstacle.entry())
    assert row[:3] == ["kind", "levels", "softness"]
    assert row[-5:] == ["first", "last", "blend", "key", "enabled"]
    assert [*own_parameters(cls), *PLACING] == list(row_parameters(cls))
