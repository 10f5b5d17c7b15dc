"""A terrain: rows of rising difficulty, a kind in each column, origins and spots where a robot can stand."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsegen
from rsegen import KINDS, Peak, Pit, Random, Recipe, StepLimits, Terrain
from rsegen.errors import ParameterError, UserError
from rsegen.measuring.batch import batch_metrics
from rsegen.measuring.catalogue import metric_by
from tests.support.long import long_unless

ROUGH = Recipe(name="rough", seed=1, unit_cm=5, boundary="none", obstacles=[Random(levels=6)])
TABLE = replace(ROUGH, name="table", obstacles=[Peak(levels=6, first=(1, 1), last=(9, 9))])
TABLE_OF_1 = replace(
    ROUGH,
    name="mixed",
    unit_cm=1,
    obstacles=[Random(levels=20), Peak(levels=30, blend="max")],
)
HILL = replace(ROUGH, name="hill", obstacles=[Peak(levels=6, softness=60)])


def test_the_tiles_of_a_copy_are_read_only() -> None:
    terrain = Terrain(recipes=ROUGH, rows=2, columns=1)
    levels = terrain.levels
    again = copy.deepcopy(terrain)
    assert np.array_equal(again.levels, levels)
    assert not again.levels.flags.writeable
    assert not again.maps.flags.writeable


def test_rows_rise_from_flat_to_full() -> None:
    terrain = Terrain(recipes=ROUGH, rows=6, columns=8)
    assert terrain.difficulties.tolist() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1])
    field = rsegen.build(ROUGH, 0)
    rms = [
        batch_metrics(row, replace(field, levels=np.zeros_like(field.levels)))["steps.rms"].mean()
        for row in terrain.levels
    ]
    assert rms[0] == 0
    assert np.diff(rms).min() > 0.7 * rms[-1] / 5
    for column in range(8):
        assert sorted(terrain.maps[:, column]) == list(range(column, 6 * 8, 8))
        assert np.array_equal(terrain.levels[-1, column], rsegen.build(ROUGH, terrain.maps[-1, column]).levels)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [name for name in KINDS if name not in {"matrix", "pit"}])
def test_every_column_gets_rougher_from_row_to_row(kind: str) -> None:
    obstacle = KINDS[kind](levels=8, softness=30 if "barrier" in kind else 0)
    ground = -obstacle.level_range[0]
    for seed in range(3):
        recipe = replace(ROUGH, seed=seed, chunk_size=20, ground_level=ground, obstacles=[obstacle])
        terrain = Terrain(recipes=recipe, rows=10, columns=4)
        levels = terrain.levels.reshape(-1, 20, 20)
        rms = batch_metrics(levels, rsegen.build(recipe, 0))["steps.rms"].reshape(10, 4)
        assert (np.diff(rms, axis=0) >= 0).all()
        assert (rms[-1] > rms[0]).all()
        falling = replace(terrain, difficulty=(1.0, 0.0))
        rms = batch_metrics(falling.levels.reshape(-1, 20, 20), rsegen.build(recipe, 0))["steps.rms"].reshape(10, 4)
        assert (np.diff(rms, axis=0) <= 0).all()


def test_rows_of_one_difficulty_have_the_maps_in_their_order() -> None:
    terrain = Terrain(recipes=ROUGH, rows=3, columns=4, difficulty=(0.5, 0.5))
    assert terrain.maps.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]


def test_tiles_of_all_recipes_are_on_the_highest_ground() -> None:
    pits = replace(ROUGH, name="pits", ground_level=3, obstacles=[Pit(levels=4, first=(2, 2), last=(7, 7))])
    terrain = Terrain(recipes=[ROUGH, pits], rows=1, columns=2, difficulty=(1, 1), gap=2, border=3)
    around = terrain.field.levels.copy()
    rough, pit = around[3:13, 3:13], around[3:13, 15:25]
    assert np.array_equal(rough, rsegen.build(ROUGH, 0).levels + 3)
    assert np.array_equal(pit, rsegen.build(pits, 1).levels)
    assert pit.min() == 0
    rough[:] = pit[:] = 3
    assert (around == 3).all()
    assert rsegen.build(terrain.recipe, 0) == terrain.field


def test_columns_are_kinds_side_by_side() -> None:
    terrain = Terrain(recipes=[ROUGH, HILL], rows=3, columns=5)
    assert terrain.kinds == ("rough",) * 3 + ("hill",) * 2
    assert np.array_equal(terrain.levels[2, 4], rsegen.build(HILL, terrain.maps[2, 4]).levels)


@given(rows=st.integers(1, 4), columns=st.integers(1, 4), gap=st.integers(0, 3), border=st.integers(0, 3))
def test_each_tile_lies_round_its_origin_with_flat_ground_between(
    rows: int, columns: int, gap: int, border: int
) -> None:
    terrain = Terrain(recipes=ROUGH, rows=rows, columns=columns, gap=gap, border=border, difficulty=(1, 1))
    field, rest = terrain.field, terrain.field.heights.copy()
    x, y = ((edges[:-1] + edges[1:]) / 2 for edges in field.edges())
    for row in range(rows):
        for column in range(columns):
            middle, (size_x, size_y) = terrain.origins[row, column], terrain.tile_size
            inside = np.ix_(np.abs(x - middle[0]) < size_x / 2, np.abs(y - middle[1]) < size_y / 2)
            assert np.array_equal(field.levels[inside], terrain.levels[row, column])
            near = np.ix_(np.abs(x - middle[0]) < field.block_width, np.abs(y - middle[1]) < field.block_width)
            assert middle[2] == pytest.approx(field.heights[near].max())
            rest[inside] = 0
    assert not rest.any()
    assert field.shape == (rows * 10 + (rows - 1) * gap + 2 * border, columns * 10 + (columns - 1) * gap + 2 * border)


@pytest.mark.parametrize(
    ("unit_cm", "frame_height_cm"),
    [(5, 10), (3.81, 11.43), (0.1, 0.3)],
    ids=["centimetres", "inches", "millimetres"],  # of which the latter two are no multiples as floats
)
def test_frames_are_blocks_of_their_height(unit_cm: float, frame_height_cm: float) -> None:
    framed = replace(ROUGH, boundary="divided", unit_cm=unit_cm, frame_height_cm=frame_height_cm, chunks=(2, 1))
    terrain = Terrain(recipes=framed, rows=1, columns=2, difficulty=(1, 1), border=0)
    field = rsegen.build(framed, 1)
    assert terrain.levels.shape == (1, 2, *field.shape)
    assert np.allclose(terrain.levels[0, 1] * (unit_cm / 100), field.heights)


def test_the_recipe_of_a_terrain_builds_the_same_field() -> None:
    terrain = Terrain(recipes=[ROUGH, HILL], rows=2, columns=3, gap=1, border=4)
    assert rsegen.build(terrain.recipe, 0) == terrain.field
    assert rsegen.compose(terrain.recipe).name == "terrain_0000"


def test_a_terrain_of_several_frictions_is_no_single_map() -> None:
    terrain = Terrain(recipes=[ROUGH, replace(ROUGH, level_friction=(0.5,))], rows=2, columns=2)
    with pytest.raises(ParameterError, match=r"recipes\[1\].level_friction: .* use the same for all"):
        assert terrain.recipe
    assert set(np.unique(terrain.frictions)) == {0.5, ROUGH.friction}
    assert np.array_equal(terrain.frictions == 0.5, (terrain.field.levels == 1) & (np.arange(40) >= 20))


def test_raised_tiles_keep_the_friction_of_their_levels() -> None:
    by_level = replace(ROUGH, level_friction=(0.2, 0.3))
    pits = replace(by_level, name="pits", ground_level=3, obstacles=[Pit(levels=4, first=(2, 2), last=(7, 7))])
    terrain = Terrain(recipes=[by_level, pits], rows=1, columns=2, difficulty=(1, 1), border=0)
    rough, pit = (rsegen.build(recipe, index).levels for index, recipe in enumerate((by_level, pits)))
    own = np.concatenate([rough, pit], axis=1)
    expected = np.select([own == 1, own == 2], [0.2, 0.3], by_level.friction)
    assert np.array_equal(terrain.frictions, expected)
    with pytest.raises(ParameterError, match=r"recipes\[0\].level_friction: is by levels, .* raised from level 0 to 3"):
        assert terrain.recipe


def test_spots_are_the_most_level_places_of_their_tiles() -> None:
    terrain = Terrain(recipes=[ROUGH, TABLE], rows=3, columns=2, border=2, gap=2)
    spots = terrain.spots((0.3, 0.2), 2, seed=3)
    assert spots.shape == (3, 2, 2, 4)
    assert np.array_equal(spots, terrain.spots((0.3, 0.2), 2, seed=3))
    width, unit = terrain.field.block_width, terrain.field.unit
    for row, column in np.ndindex(3, 2):
        levels = terrain.levels[row, column].astype(int)
        windows = np.lib.stride_tricks.sliding_window_view(levels, (3, 2))
        for x, y, z, _ in spots[row, column]:
            i, j = (
                round((at - middle) / width + (cells - wide) / 2)
                for at, middle, cells, wide in zip(
                    (x, y), terrain.origins[row, column, :2], levels.shape, (3, 2), strict=True
                )
            )
            under = levels[i : i + 3, j : j + 2]
            assert under.shape == (3, 2)
            assert z == pytest.approx(under.max() * unit)
            assert np.ptp(under) <= np.sort(np.ptp(windows, axis=(2, 3)), axis=None)[1]
            # The same place in the field of all tiles.
            n_x, n_y = terrain.field.shape
            across, along = round(x / width + n_x / 2 - 1.5), round(y / width + n_y / 2 - 1)
            assert np.array_equal(terrain.field.levels[across : across + 3, along : along + 2], under)


def test_spots_of_a_terrain_are_not_in_holes() -> None:
    pit = Pit(levels=4, gap_width=3, first=(0, 0), last=(9, 9))
    recipe = Recipe(seed=1, unit_cm=5, boundary="none", ground_level=4, obstacles=[pit])
    terrain = Terrain(recipes=[ROUGH, recipe], rows=2, columns=2)
    assert terrain.levels[1, 1].min() == 1
    assert (terrain.spots((0.1, 0.1), 10)[..., 2] >= 4 * 0.05 - 1e-9).all()
    with pytest.raises(ParameterError, match=r"size: 2 x 0\.3 m is larger than the map of 10 x 10 blocks"):
        terrain.spots((2, 0.3))


@pytest.mark.slow
@pytest.mark.parametrize(
    "by",
    long_unless(
        lambda by: by != "reach.west_east.cost",
        ["opening.west_east", "reach.west_east.cost", lambda field: field.levels.mean()],
        reason="paths on map after map",
    ),
)
def test_rows_rise_evenly_by_any_metric(by: Any) -> None:
    robot = StepLimits(climb_cm=7) if by == "reach.west_east.cost" else None
    fine = replace(ROUGH, unit_cm=1, obstacles=[Random(levels=30)])
    terrain, metric = Terrain(recipes=[fine, TABLE_OF_1], rows=5, columns=6, by=by, robot=robot), metric_by(by, robot)
    assert not terrain.levels[0].any()
    for kind in (slice(0, 3), slice(3, 6)):
        found = np.array([[metric(_alone(terrain, tile)) for tile in row] for row in terrain.levels[:, kind]])
        rows = found.mean(axis=1)
        steps = np.diff(rows) / (rows[-1] - rows[0])
        assert steps.min() > 0.1
        assert steps.max() < 0.45
    assert np.array_equal(terrain.levels, replace(terrain, gap=3).levels)


def _alone(terrain: Terrain, levels: Any) -> rsegen.StepField:
    return replace(terrain.field, levels=levels, frame=np.zeros(levels.shape, dtype=bool))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"recipes": []}, "recipes: 0 for 20 columns"),
        ({"recipes": [ROUGH] * 3, "columns": 2}, "recipes: 3 for 2 columns"),
        ({"recipes": ["rough"]}, "recipes: .* is not a recipe or a list of recipes"),
        ({"by": "steps.rsm"}, "by: unknown metric 'steps.rsm'; did you mean 'steps.rms'"),
        ({"by": "reach.coverage"}, "by: reach.coverage needs a robot; set robot too"),
        ({"rows": 0}, "rows: 0 is outside 1..1000"),
        ({"difficulty": 0.5}, "difficulty: 0.5 is not 2 values"),
        ({"recipes": [ROUGH, replace(ROUGH, chunk_size=8)]}, r"recipes\[1\]: tiles of 8 x 8 and 10 x 10 cells"),
        ({"recipes": [ROUGH, replace(ROUGH, unit_cm=10)]}, r"recipes\[1\].unit_cm: 10.0, and 5.0 in the first recipe"),
        (
            {"rows": 1000, "columns": 1000, "recipes": replace(ROUGH, chunk_size=40)},
            "rows: a terrain of 40,020 x 40,020",
        ),
        ({"recipes": replace(ROUGH, difficulty=(0, 1))}, r"recipes\[0\].difficulty: .* is a range"),
        ({"recipes": replace(ROUGH, boundary="outer", frame_height_cm=7)}, r"frame_height_cm: 7 is no multiple"),
        (
            {"recipes": replace(ROUGH, boundary="outer", unit_cm=0.001, frame_height_cm=100)},
            r"frame_height_cm: 100 cm are 100,000 units, above the highest level, 32766",
        ),
        (
            {"recipes": [replace(ROUGH, obstacles=[Peak(levels=32700)]), replace(HILL, ground_level=100)]},
            r"recipes\[0\]\.ground_level: 0: tiles are raised to 100, and blocks of 32699 are then above",
        ),
        (
            {"recipes": replace(ROUGH, boundary="outer", frame_height_cm=10, frame_friction=0.1)},
            r"recipes\[0\]\.frame_friction: 0\.1 acts on no tile, whose frames are blocks like others; leave it out",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_invalid_terrains_are_refused(given: Mapping[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        Terrain(**{"recipes": ROUGH, **given})


@given(st.integers(1, 60))
def test_grid_origins_are_even_and_on_top_of_the_blocks(count: int) -> None:
    terrain = Terrain(recipes=ROUGH, rows=3, columns=5, gap=1)
    x, y, z = terrain.grid_origins(count).T
    field = terrain.field
    assert len(np.unique(np.round(np.column_stack([x, y]), 9), axis=0)) == count
    for line in (np.unique(np.round(x, 9)), np.unique(np.round(y, 9))):
        assert len(line) < 3 or np.allclose(np.diff(line), np.diff(line)[0])
    edges_x, edges_y = field.edges()
    for at_x, at_y, at_z in zip(x, y, z, strict=True):
        near = np.ix_(
            (edges_x[:-1] <= at_x + 1e-9) & (at_x - 1e-9 <= edges_x[1:]),
            (edges_y[:-1] <= at_y + 1e-9) & (at_y - 1e-9 <= edges_y[1:]),
        )
        assert at_z == field.heights[near].max()
