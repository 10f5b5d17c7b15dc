"""What is shown of a map, in numbers too, without Qt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import psutil
import pytest
from hypothesis import given

from rsegen import Peak, Random, Recipe, compose
from rsegen.errors import TooLarge
from rsegen.exporters.map_summary import map_summary
from rsegen.gui.model.colours import GROUND, cells, palette
from rsegen.gui.model.preview import (
    COUNTED,
    SHOWN_SIDE,
    costs,
    is_quick,
    largest_step,
    preview,
    preview_of,
    shares,
    size_text,
)
from tests.support.strategies import recipes

ROUGH = Recipe(seed=1, obstacles=[Random(levels=5)])


@given(recipes())
def test_shares_are_all_blocks_of_the_map(recipe: Recipe) -> None:
    scene = compose(recipe)
    assert [share.blocks for share in shares(scene)] == list(scene.field.level_counts().values())
    assert sum(share.blocks for share in shares(scene)) == scene.field.blocks.size


@given(recipes())
def test_every_cell_has_the_colour_of_its_block(recipe: Recipe) -> None:
    scene = compose(recipe)
    found, known = cells(scene), palette(scene)
    for (i, j), level in np.ndenumerate(scene.field.levels):
        expected = known[0] if scene.field.frame[i, j] else known[level] if level else GROUND
        assert tuple(found[i, j]) == tuple(expected)


@pytest.mark.parametrize("mesh_type", ["single", "multi", "pallet"])
def test_costs_match_the_map_summary(mesh_type: str) -> None:
    scene = compose(replace(ROUGH, mesh_type=mesh_type))
    found = map_summary(scene)
    models = f"{found.models} model{'' if found.models == 1 else 's'}"
    assert costs(scene).text == f"{models}, {found.faces:,} faces, {found.bytes / 1000:,.0f} kB"
    assert costs(scene).warnings == found.warnings == ()


def test_a_map_too_large_to_be_counted_is_warned_of_all_the_same() -> None:
    side = int(COUNTED**0.5) + 1
    scene = compose(replace(ROUGH, chunk_size=side, mesh_type="multi"))
    assert costs(scene).text == ""
    assert "models: Gazebo Classic needs about" in costs(scene).warnings[0]


def test_flat_ground_is_warned_of_only_if_obstacles_were_given() -> None:
    assert costs(compose(replace(ROUGH, obstacles=()))).warnings == ()
    nothing = replace(ROUGH, obstacles=[Random(levels=5, softness=100)])
    assert "nothing to see" in costs(compose(nothing)).warnings[0]


def test_size_and_largest_step_are_reported() -> None:
    peak = Peak(levels=5, softness=0, first=(2, 2), last=(7, 7))
    scene = compose(replace(ROUGH, boundary="none", obstacles=[peak]))
    assert size_text(scene) == "10 x 10 cells, 1 x 1 m, largest step 40 cm"
    assert largest_step(scene.field) == 0.4


def test_a_large_map_is_seen_coarser_and_told_in_full() -> None:
    preview = preview_of(compose(replace(ROUGH, chunk_size=900, boundary="none")))
    assert preview.factor > 1
    assert max(preview.coarse.field.shape) <= SHOWN_SIDE
    assert preview.scene.field.shape == (900, 900)
    assert sum(share.blocks for share in preview.shares) == 900 * 900


def test_small_maps_are_quick_and_large_ones_are_not() -> None:
    assert is_quick(replace(ROUGH, chunk_size=40))
    assert not is_quick(replace(ROUGH, chunk_size=200))


def test_a_look_at_a_recipe_is_that_at_its_scene() -> None:
    assert preview(ROUGH, 0).scene == compose(ROUGH)


def test_a_map_that_needs_more_memory_than_is_free_is_refused_in_one_line() -> None:
    free = psutil.virtual_memory().available
    side = int((free / 30) ** 0.5) // 1000 + 1
    with pytest.raises(TooLarge, match="memory"):
        preview(Recipe(seed=1, chunk_size=1000, chunks=(side, side), boundary="none"), 0)
