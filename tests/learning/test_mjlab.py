"""Sub-terrains in mjlab's own TerrainGenerator, which needs nothing but MuJoCo, numpy and scipy."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError

pytestmark = pytest.mark.long(reason="mjlab, which only make learners brings")

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

MJLAB = Path(sys.prefix) / "mjlab"
RECIPE = Recipe(
    seed=3,
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    obstacles=[Random(levels=6)],
)


@pytest.fixture
def mjlab(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The adapter beside mjlab's generator, whose packages are entered without what they import for training."""
    if not MJLAB.is_dir():
        pytest.skip(f"no mjlab in {MJLAB}: make learners puts it there")
    for name in ("mjlab", "mjlab.terrains", "mjlab.utils"):
        package = ModuleType(name)
        package.__path__ = [str(MJLAB.joinpath(*name.split(".")))]
        monkeypatch.setitem(sys.modules, name, package)
    from rsegen.learning import mjlab as adapter

    yield adapter
    for name in [name for name in sys.modules if name.startswith("mjlab.") or name == adapter.__name__]:
        monkeypatch.delitem(sys.modules, name)


def _compiled(mjlab: Any, **values: Any) -> tuple[Any, Any, Any]:
    """The model, its state and the generator of a terrain of one column."""
    from mjlab.terrains.terrain_generator import TerrainGenerator, TerrainGeneratorCfg

    sub_terrains = {"rubble": mjlab.StepFieldTerrainCfg(recipe=RECIPE)}
    given = {"size": (2.0, 2.0), "num_rows": 5, "curriculum": True, "seed": 1, "border_width": 1.0} | values
    generator, spec = TerrainGenerator(TerrainGeneratorCfg(sub_terrains=sub_terrains, **given)), mujoco.MjSpec()
    generator.compile(spec)
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    return model, state, generator


def _height(model: Any, state: Any, x: float, y: float) -> tuple[float, int]:
    """How high a ray straight down ends, and on which geom."""
    geom = np.zeros(1, dtype=np.int32)
    way = mujoco.mj_ray(model, state, [x + 1e-5, y + 2e-5, 5.0], [0, 0, -1], None, 1, -1, geom)
    return 5.0 - way, int(geom[0])


def test_rows_rise_from_flat_to_full_with_level_ground_around(mjlab: Any) -> None:
    model, state, generator = _compiled(mjlab)
    rough = []
    for row in range(5):
        x, y, z = generator.terrain_origins[row, 0]
        cells = np.arange(-10, 10) * 0.1 + 0.05
        heights = np.array([[_height(model, state, x + dx, y + dy)[0] for dy in cells] for dx in cells])
        levels = heights / 0.05
        assert np.allclose(levels, np.rint(levels), atol=1e-6)
        assert np.allclose(heights[:5], 0, atol=1e-9)
        assert np.allclose(heights[:, 15:], 0, atol=1e-9)
        assert z == pytest.approx(heights[9:11, 9:11].max())
        rough.append(np.abs(np.diff(heights, axis=0)).mean())
    assert rough[0] == 0
    assert np.diff(rough).min() > 0


def test_every_level_has_its_friction_and_no_geom_a_mass(mjlab: Any) -> None:
    model, state, generator = _compiled(mjlab)
    x, y, _ = generator.terrain_origins[4, 0]
    for dx, dy in np.random.default_rng(0).uniform(-0.5, 0.5, (50, 2)):
        height, geom = _height(model, state, x + dx, y + dy)
        level = round(height / 0.05)
        assert model.geom_friction[geom, 0] == pytest.approx([1.0, 0.2, 0.4, 0.6, 0.8, 0.9][level])
    assert model.body_mass.sum() == 0


def test_the_generator_s_seed_chooses_the_maps(mjlab: Any) -> None:
    once, again, other = (_compiled(mjlab, seed=seed)[0].geom_size for seed in (1, 1, 2))
    assert np.array_equal(once, again)
    assert once.shape != other.shape or not np.array_equal(once, other)


def test_impossible_values_are_refused(mjlab: Any) -> None:
    with pytest.raises(ParameterError, match="size: a map of 10 x 10 cells is larger than a tile of 5 x 5"):
        _compiled(mjlab, size=(0.5, 0.5))
    with pytest.raises(ParameterError, match="difficulty"):
        mjlab.StepFieldTerrainCfg(recipe=rsegen.Recipe(seed=1, difficulty=(0, 1)))
