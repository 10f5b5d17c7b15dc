"""The ghost of an obstacle is what the map gets once the obstacle is added."""

from __future__ import annotations

import numpy as np
import pytest

from rsegen import build
from rsegen.exporters.scene import compose
from rsegen.field.obstacles import KINDS
from rsegen.gui.model.document import Document
from rsegen.gui.model.obstacle_ends import ghost_of
from rsegen.gui.model.preview import preview
from rsegen.gui.model.session import Session
from rsegen.recipe.recipe import Recipe


@pytest.mark.parametrize("blend", ["replace", "max", "add", "min"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_ghost_is_where_the_obstacle_will_be(kind: str, blend: str) -> None:
    document = Document(Session.new())
    document.session.set("chunks", [2, 2])
    document.add({"kind": "random", "levels": 4})
    document.select(-1)
    before = document.session.recipe
    entry = document.keyed({"kind": kind, "levels": 5, "blend": blend})
    ghost = ghost_of(compose(before, 0), entry)
    assert ghost is not None
    document.add(entry)
    added, old = build(document.session.recipe), build(before)
    wanted = np.where(ghost.cells, ghost.scene.field.levels, old.levels)
    assert np.array_equal(added.levels, wanted)
    assert not (ghost.cells & old.frame).any()


def test_an_invalid_obstacle_has_no_ghost() -> None:
    scene = compose(Recipe(seed=1), 0)
    assert ghost_of(scene, {"kind": "peak", "levels": 5, "first": [99, 0], "last": [3, 3]}) is None
    assert ghost_of(scene, {"kind": "peek", "levels": 5}) is None


def test_a_preview_has_the_ghost_and_its_blocks() -> None:
    found = preview(Recipe(seed=1), 0, {"kind": "peak", "levels": 5})
    assert found.ghost is not None
    assert found.ghost_solid is not None
    assert len(found.ghost_solid.faces)
    assert found.scene.field.level_counts() == {0: 100}
    assert preview(Recipe(seed=1), 0).ghost is None


def test_only_the_ghost_of_a_map_that_is_shown_is_made_anew() -> None:
    shown = preview(Recipe(seed=1), 0, {"kind": "peak", "levels": 5})
    other = preview(Recipe(seed=1), 0, {"kind": "peak", "levels": 3}, shown)
    assert other.scene is shown.scene
    assert other.ghost is not shown.ghost
    assert preview(Recipe(seed=1), 0, None, other).ghost is None
    assert preview(Recipe(seed=2), 0, None, shown).scene is not shown.scene
