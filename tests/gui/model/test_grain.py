"""Wood in the 3D view: grain on the tops of blocks, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import rsegen
from rsegen import Random, Recipe
from rsegen.gui.model.solid import Shading, border, finest, shading, with_grain

RECIPE = Recipe(seed=3, boundary="none", look="wood", obstacles=(Random(levels=5),))


def both(recipe: Recipe) -> tuple[Shading, Shading]:
    """The light of a map, without and with the grain."""
    scene = rsegen.compose(recipe)
    bare = shading(scene.field, border(scene.field), finest(scene))
    return bare, with_grain(bare, scene)


def test_every_top_has_a_grain_of_its_own_and_the_ground_has_none() -> None:
    bare, wood = both(RECIPE)
    field = rsegen.build(RECIPE, 0)
    ratio = wood.light / bare.light
    start, fine = bare.fine * bare.rim, bare.fine
    inside = ratio[start : start + 10 * fine, start : start + 10 * fine]
    tops = inside.reshape(10, fine, 10, fine).transpose(0, 2, 1, 3)
    stands = field.levels > 0
    assert (tops[~stands] == 1).all()
    assert (tops[stands].reshape(stands.sum(), -1).std(axis=1) > 0.02).all()
    assert len(np.unique(tops[stands].reshape(stands.sum(), -1), axis=0)) > 40
    rest = ratio.copy()
    rest[start : start + 10 * fine, start : start + 10 * fine] = 1
    assert (rest == 1).all()
    assert 0.7 < inside[inside < 1].mean() < 1


def test_other_looks_and_large_maps_have_the_light_as_it_is() -> None:
    for recipe in (replace(RECIPE, look="plain"), replace(RECIPE, look="levels"), replace(RECIPE, chunk_size=200)):
        bare, wood = both(recipe)
        assert wood is bare


def test_the_grain_is_that_of_the_seed() -> None:
    one, again, other = (both(replace(RECIPE, seed=seed))[1].light for seed in (3, 3, 4))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
