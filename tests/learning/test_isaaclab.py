"""Sub-terrains for Isaac Lab: what its generator calls gets its meshes and origin; the same again for the same seed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Pit, Random, Recipe, Stairs
from rsegen.errors import ParameterError

trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
from rsegen.learning.isaaclab import StepFieldTerrain  # noqa: E402  # it needs trimesh
from rsegen.learning.tile import index_of, tile  # noqa: E402

RECIPE = Recipe(seed=3, unit_cm=5, boundary="none", obstacles=[Random(levels=6)])


@dataclass
class SubTerrain:
    """What the generator gives: the size, and its seed."""

    size: tuple[float, float] = (2.0, 1.5)
    seed: int | None = 42


def _heights(mesh: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The highest point of a mesh over each place of x times y."""
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    corners = mesh.vertices[mesh.faces]
    upward = mesh.face_normals[:, 2] > 0.5
    low, high = corners[upward].min(axis=1), corners[upward].max(axis=1)
    found = np.full(len(places), -np.inf)
    for low_one, high_one in zip(low, high, strict=True):
        inside = ((places >= low_one[:2]) & (places <= high_one[:2])).all(axis=1)
        found[inside] = np.maximum(found[inside], high_one[2])
    return found.reshape(len(x), len(y))


@pytest.mark.parametrize("kind", ["merged", "watertight"])
def test_the_map_is_amid_level_ground_from_0_to_the_size(kind: str) -> None:
    (mesh,), origin = StepFieldTerrain(RECIPE, mesh=kind)(1.0, SubTerrain())
    assert mesh.bounds[0] == pytest.approx([0, 0, -0.05])
    assert mesh.bounds[1][:2] == pytest.approx([2, 1.5])
    found = tile(RECIPE, 1.0, index_of(42, 1.0), (2.0, 1.5))
    own = found.raised.levels.astype(int) - 1
    x, y = np.arange(20) * 0.1 + 0.05, np.arange(15) * 0.1 + 0.05
    assert np.allclose(_heights(mesh, x, y), own * 0.05)
    assert own[5:15, 2:12].any()
    assert origin[2] == pytest.approx(own[9:11, 6:8].max() * 0.05)
    own[5:15, 2:12] = 0
    assert not own.any()
    assert origin[:2] == pytest.approx([1.0, 0.7])
    assert mesh.is_watertight == (kind != "merged")


@pytest.mark.parametrize("kind", ["merged", "watertight"])
def test_holes_are_below_the_ground_that_is_z_0(kind: str) -> None:
    gap = Pit(levels=4, gap_width=3, first=(0, 0), last=(9, 9))
    step = Stairs(levels=3, direction="down", first=(4, 4), last=(5, 5))
    recipe = replace(RECIPE, ground_level=4, obstacles=[gap, step])
    (mesh,), origin = StepFieldTerrain(recipe, mesh=kind)(1.0, SubTerrain())
    x, y = np.arange(20) * 0.1 + 0.05, np.arange(15) * 0.1 + 0.05
    own = rsegen.build(recipe).levels.astype(int) - 4
    expected = np.zeros((20, 15))
    expected[5:15, 2:12] = own * 0.05
    assert (own.min(), own.max(), own[4, 4]) == (-3, 0, -1)
    assert np.allclose(_heights(mesh, x, y), expected, atol=1e-9)
    assert origin == pytest.approx([1.0, 0.7, -0.05])
    assert mesh.bounds[0] == pytest.approx([0, 0, -0.25])
    assert mesh.is_watertight == (kind != "merged")
    (flat,), _ = StepFieldTerrain(recipe, mesh=kind)(0.0, SubTerrain())
    assert flat.bounds[1][2] == pytest.approx(0)
    assert np.isin(np.round(flat.vertices[:, 2], 9), [0, -0.25]).all()


def test_seed_and_difficulty_alone_choose_the_map() -> None:
    function = StepFieldTerrain(RECIPE)

    def levels(difficulty: float, seed: int | None) -> list[float]:
        (mesh,), _ = function(difficulty, SubTerrain(seed=seed))
        return sorted(mesh.vertices[:, 2].tolist())

    assert levels(0.7, 1) == levels(0.7, 1)
    assert levels(0.7, 1) != levels(0.7, 2)
    assert levels(0.7, 1) != levels(0.70001, 1)
    assert levels(0.7, None) == levels(0.7, None)
    assert max(levels(0.0, 1)) == pytest.approx(0)


def test_the_cache_of_isaac_lab_is_named_after_the_recipe() -> None:
    """It names a function by __module__ and __name__ (isaaclab.utils.string.callable_to_string)."""
    names = {
        StepFieldTerrain(recipe, mesh=kind).__name__
        for recipe in (RECIPE, replace(RECIPE, seed=4))
        for kind in ("merged", "watertight")
    }
    assert len(names) == 4
    assert StepFieldTerrain(RECIPE).__name__ == StepFieldTerrain(RECIPE).__name__
    assert StepFieldTerrain(RECIPE).__module__ == "rsegen.learning.isaaclab"


@pytest.mark.parametrize(
    ("recipe", "size", "message"),
    [
        (RECIPE, (0.9, 2.0), "size: a map of 10 x 10 cells is larger than a tile of 9 x 20; give 1 x 1 m or more"),
        (RECIPE, (1.23, 2.0), "size: 1.23 m along x is not a multiple of the block width 0.1 m; give 1.2 or 1.3"),
        (replace(RECIPE, level_friction=(0.5,)), (2.0, 2.0), "level_friction: a terrain of Isaac Lab has one friction"),
        (replace(RECIPE, difficulty=(0, 1)), (2.0, 2.0), "difficulty: .* is a range, and tiles have their own"),
    ],
    ids=["larger", "no multiple", "frictions", "range"],
)
def test_impossible_values_are_refused(recipe: Recipe, size: tuple[float, float], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        StepFieldTerrain(recipe)(1.0, SubTerrain(size=size))
