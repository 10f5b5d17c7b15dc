"""Sub-terrains in mjlab's own TerrainGenerator, which needs nothing but MuJoCo, numpy and scipy."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError, TooLarge, UnknownName

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


def _compiled(mjlab: Any, own: dict[str, Any] | None = None, **values: Any) -> tuple[Any, Any, Any]:
    """The model, its state and the generator of a terrain of one column; `own`: parameters of the sub-terrain."""
    from mjlab.terrains.terrain_generator import TerrainGenerator, TerrainGeneratorCfg

    sub_terrains = {"rubble": mjlab.StepFieldTerrainCfg(**{"recipe": RECIPE, **(own or {})})}
    given = {"size": (2.0, 2.0), "num_rows": 5, "curriculum": True, "seed": 1, "border_width": 1.0} | values
    generator, spec = TerrainGenerator(TerrainGeneratorCfg(sub_terrains=sub_terrains, **given)), mujoco.MjSpec()
    generator.compile(spec)
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    return model, state, generator


def _height(model: Any, state: Any, x: float, y: float) -> tuple[float, int]:
    """Height at which a ray straight down ends, and its geom."""
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
        assert z == pytest.approx(heights.max())
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


def test_frames_that_are_higher_than_all_levels_are_blocks_too(mjlab: Any) -> None:
    framed = replace(RECIPE, boundary="outer", frame_height_cm=40, chunk_size=8)
    model, _, _ = _compiled(mjlab, {"recipe": framed}, num_rows=1)
    tops = np.round(model.geom_pos[:, 2] + model.geom_size[:, 2], 9)
    assert set(model.geom_friction[tops == 0.4, 0]) == {framed.friction}


@pytest.mark.parametrize("shape", ["boxes", "hfield"])
def test_each_sub_terrain_has_a_friction_of_its_own_that_acts(mjlab: Any, shape: str) -> None:
    """By contacts of feet as mjlab has them, of friction 0.6 and priority 1, on every sub-terrain."""
    from mjlab.terrains.terrain_generator import TerrainGenerator, TerrainGeneratorCfg

    kinds = {"ice": 0.1, "wood": 0.5, "rubber": 1.3}
    sub_terrains = {
        name: mjlab.StepFieldTerrainCfg(
            recipe=replace(RECIPE, name=name, friction=friction, level_friction=None), shape=shape, proportion=1 / 3
        )
        for name, friction in kinds.items()
    }
    cfg = TerrainGeneratorCfg(
        size=(2.0, 2.0), num_rows=3, num_cols=3, curriculum=True, seed=1, sub_terrains=sub_terrains
    )
    spec = mujoco.MjSpec()
    generator = TerrainGenerator(cfg)
    generator.compile(spec)
    foot = spec.worldbody.add_body(name="foot", pos=[0, 0, 9])
    foot.add_freejoint()
    foot.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0], friction=[0.6, 0.02, 0.01], priority=1)
    model = spec.compile()
    state = mujoco.MjData(model)
    acting = np.zeros((3, 3))
    for row, column in np.ndindex(acting.shape):
        x, y, _ = generator.terrain_origins[row, column] + 0.05
        state.qpos[:3] = x, y, 9
        mujoco.mj_forward(model, state)
        state.qpos[2] = _height(model, state, x, y)[0] + 0.0195
        mujoco.mj_forward(model, state)
        assert state.ncon
        (acting[row, column],) = set(np.round(state.contact.friction[:, 0], 9))
    assert np.array_equal(np.sort(acting), [list(kinds.values())] * 3)
    assert (acting == acting[0]).all()


def test_the_friction_of_feet_acts_if_blocks_have_the_lower_priority(mjlab: Any) -> None:
    from rsegen.scene.contact import Contact

    model, *_ = _compiled(mjlab, {"contact": Contact(priority=-1)})
    boxes = model.geom_type == mujoco.mjtGeom.mjGEOM_BOX
    of_blocks = boxes & (model.geom_contype == 2**31 - 1)
    assert of_blocks.sum() > 50
    assert set(model.geom_priority[of_blocks]) == {-1}


def test_the_generator_s_seed_chooses_the_maps(mjlab: Any) -> None:
    once, again, other = (_compiled(mjlab, seed=seed)[0].geom_size for seed in (1, 1, 2))
    assert np.array_equal(once, again)
    assert once.shape != other.shape or not np.array_equal(once, other)


def test_a_height_field_has_the_heights_of_the_boxes(mjlab: Any) -> None:
    smooth = replace(RECIPE, level_friction=None, friction=0.7)
    boxes, fields = (_compiled(mjlab, {"recipe": smooth, "shape": shape}) for shape in ("boxes", "hfield"))
    assert np.array_equal(boxes[2].terrain_origins, fields[2].terrain_origins)
    assert fields[0].nhfield == 5
    assert fields[0].geom_friction[fields[0].geom_type == mujoco.mjtGeom.mjGEOM_HFIELD, 0] == pytest.approx(0.7)
    assert fields[0].body_mass.sum() == 0
    # From the middle of a block to a quarter before its edge, where a height field begins to slope.
    for x, y in (np.random.default_rng(0).integers((-50, -10), (50, 10), (300, 2)) + 0.5) * 0.1:
        dx, dy = np.random.default_rng(1).uniform(-0.024, 0.024, 2)
        expected, _ = _height(*boxes[:2], x + dx, y + dy)
        assert _height(*fields[:2], x + dx, y + dy)[0] == pytest.approx(expected, abs=1e-6)
    # Nowhere below the boxes, and without a gap between tiles.
    for x, y in np.random.default_rng(2).uniform((-5, -1), (5, 1), (500, 2)):
        assert _height(*fields[:2], x, y)[0] >= _height(*boxes[:2], x, y)[0] - 1e-6
    for x in (-3.0, -1.0, 1.0, 3.0):
        assert _height(*fields[:2], x - 1e-5, 0.3)[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("shape", ["boxes", "hfield"])
def test_the_origin_is_above_all_ground_within_the_spawn_radius(mjlab: Any, shape: str) -> None:
    for radius in (0.0, 0.1, 0.15, 0.2, 0.25, 0.8):
        own = {"recipe": replace(RECIPE, level_friction=None), "shape": shape, "spawn_radius": radius}
        model, state, generator = _compiled(mjlab, own, curriculum=False)
        for x, y, z in generator.terrain_origins.reshape(-1, 3):
            around = np.random.default_rng(0).uniform(-radius, radius, (200, 2))
            heights = [_height(model, state, x + dx, y + dy)[0] for dx, dy in around]
            assert max(heights) <= z + 1e-6
            assert radius < 0.8 or max(heights) == pytest.approx(z)


@pytest.mark.parametrize("shape", ["boxes", "hfield"])
def test_level_places_are_level_in_the_compiled_model(mjlab: Any, shape: str) -> None:
    from mjlab.terrains.terrain_generator import FlatPatchSamplingCfg

    wanted = FlatPatchSamplingCfg(num_patches=7, patch_radius=0.15, max_height_diff=0.05, x_range=(0.7, 1.3))
    own = {"flat_patch_sampling": {"spawn": wanted}, "spawn_radius": 0.0, "shape": shape}
    own["recipe"] = replace(RECIPE, level_friction=None)
    model, state, generator = _compiled(mjlab, own, curriculum=False, difficulty_range=(0.3, 0.6))
    places = generator.flat_patches["spawn"]
    assert places.shape == (5, 1, 7, 3)
    real = 0
    for row in range(5):
        corner, origin = np.array([-5.0 + 2 * row, -1.0]), generator.terrain_origins[row, 0]
        for x, y, z in places[row, 0]:
            if np.allclose((x, y, z), origin):
                continue
            real += 1
            assert 0.7 - 1e-9 <= x - corner[0] <= 1.3 + 1e-9
            around = np.random.default_rng(0).uniform(-0.149, 0.149, (100, 2))
            heights = [_height(model, state, x + dx, y + dy)[0] for dx, dy in around]
            assert np.ptp(heights) <= 0.05 + 1e-6
            assert max(heights) <= z + 1e-6
    assert real > (20 if shape == "boxes" else 5)


def test_balls_of_mujoco_warp_rest_on_a_height_field(mjlab: Any) -> None:
    mjw = pytest.importorskip("mujoco_warp", reason="mujoco_warp is not installed")
    from mjlab.terrains.terrain_generator import TerrainGenerator, TerrainGeneratorCfg

    smooth = replace(RECIPE, level_friction=None)
    cfg = TerrainGeneratorCfg(
        size=(2.0, 2.0),
        num_rows=2,
        curriculum=True,
        seed=1,
        difficulty_range=(1.0, 1.0),
        sub_terrains={"rubble": mjlab.StepFieldTerrainCfg(recipe=smooth, shape="hfield")},
    )
    spec = mujoco.MjSpec()
    TerrainGenerator(cfg).compile(spec)
    ball = spec.worldbody.add_body(name="ball", pos=[0, 0, 1])
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0])
    compiled = spec.compile()
    cells = np.random.default_rng(0).integers((-15, -5), (15, 5), (32, 2)) * 0.1 + 0.05
    state = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, state)
    tops = []
    for x, y in cells:
        state.qpos[:3] = [x, y, 50]
        mujoco.mj_forward(compiled, state)
        tops.append(_height(compiled, state, x, y)[0])
    model, data = mjw.put_model(compiled), mjw.make_data(compiled, nworld=32, nconmax=64, njmax=256)
    poses = np.zeros((32, 7), dtype=np.float32)
    poses[:, :2], poses[:, 2], poses[:, 3] = cells, np.array(tops) + 0.03, 1
    data.qpos.assign(poses)
    for _ in range(100):
        mjw.step(model, data)
    assert data.qpos.numpy()[:, 2] == pytest.approx(np.array(tops) + 0.02, abs=0.002)


def test_more_boxes_than_the_budget_are_refused(mjlab: Any) -> None:
    with pytest.raises(TooLarge, match=r"most_boxes: more than 100 boxes, the budget of the terrain; \d+ need 0.0"):
        _compiled(mjlab, {"most_boxes": 100})


def test_impossible_values_are_refused(mjlab: Any) -> None:
    with pytest.raises(ParameterError, match="level_friction: a height field has one friction; set only `friction`"):
        mjlab.StepFieldTerrainCfg(recipe=RECIPE, shape="hfield")
    with pytest.raises(UnknownName, match=r"unknown shape 'mesh' .*boxes, hfield"):
        mjlab.StepFieldTerrainCfg(recipe=RECIPE, shape="mesh")
    with pytest.raises(ParameterError, match=r"samples: 0 is outside 1\.\.20"):
        mjlab.StepFieldTerrainCfg(recipe=replace(RECIPE, level_friction=None), shape="hfield", samples=0)
    with pytest.raises(ParameterError, match=r"spawn_radius: -1 is outside 0\.\.100"):
        mjlab.StepFieldTerrainCfg(recipe=RECIPE, spawn_radius=-1)
    with pytest.raises(ParameterError, match=r"recipe: \[.*\] is not a recipe; pass one, and a sub-terrain for each"):
        mjlab.StepFieldTerrainCfg(recipe=[RECIPE])
    with pytest.raises(ParameterError, match="size: a map of 10 x 10 cells is larger than a tile of 5 x 5"):
        _compiled(mjlab, size=(0.5, 0.5))
    with pytest.raises(ParameterError, match="difficulty"):
        mjlab.StepFieldTerrainCfg(recipe=rsegen.Recipe(seed=1, difficulty=(0, 1)))


def test_a_curriculum_has_as_many_columns_as_asked_each_with_maps_of_its_own(mjlab: Any) -> None:
    from mjlab.terrains.terrain_generator import TerrainGenerator, TerrainGeneratorCfg

    other = replace(RECIPE, name="other", seed=8)
    sub_terrains = mjlab.columns([RECIPE, other], 5, spawn_radius=0.5)
    assert [name.partition("_")[0] for name in sub_terrains] == [RECIPE.name] * 3 + ["other"] * 2
    assert {cfg.spawn_radius for cfg in sub_terrains.values()} == {0.5}
    generator, spec = (
        TerrainGenerator(
            TerrainGeneratorCfg(
                sub_terrains=sub_terrains, size=(2.0, 2.0), num_rows=3, curriculum=True, seed=1, border_width=1.0
            )
        ),
        mujoco.MjSpec(),
    )
    generator.compile(spec)
    assert generator.terrain_origins.shape == (3, 5, 3)
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    cells = np.arange(-5, 5) * 0.1 + 0.05
    tiles = {
        tuple(_height(model, state, x + dx, y + dy)[0] for dx in cells for dy in cells)
        for x, y, _ in generator.terrain_origins[2]
    }
    assert len(tiles) == 5, "no two columns have the same map"
    with pytest.raises(ParameterError, match="1 columns for 2 recipes"):
        mjlab.columns([RECIPE, other], 1)
