"""Each world of mujoco_warp has its own map: the contacts of MuJoCo's model of that map, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import rsegen
from rsegen import Random, Recipe
from rsegen.errors import ParameterError
from tests.support.late_import import LateImport

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
from rsegen.learning.mujoco import BlockGrid  # noqa: E402  # it needs MuJoCo

mjw = LateImport("mujoco_warp", reason="mujoco_warp is not installed")
adapter = LateImport("rsegen.learning.mujoco_warp", reason="mujoco_warp is not installed")

pytestmark = [pytest.mark.long(reason="Warp, 0.4 GB, which compiles its kernels"), pytest.mark.slow]

RECIPE = Recipe(
    seed=7,
    chunk_size=4,
    chunks=(1, 2),
    unit_cm=5,
    boundary="none",
    level_friction=(0.2, 0.4, 0.6, 0.8, 0.9),
    obstacles=[Random(levels=6)],
)
GRID = BlockGrid(RECIPE, pos=(1, 2, 0.5))
WORLDS = 32
RADIUS = 0.03


@pytest.fixture(params=["false", "true"], ids=["", "fused"])
def compiled(request: pytest.FixtureRequest) -> Any:
    """A model of the blocks and a free ball of less friction than theirs; of URDF static bodies are fused."""
    spec = mujoco.MjSpec.from_string(f'<mujoco><compiler fusestatic="{request.param}"/></mujoco>')
    GRID.add_to(spec)
    body = spec.worldbody.add_body(name="ball", pos=[1.05, 2.05, 2])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], friction=[1e-3, 1e-3, 1e-3])
    return spec.compile()


@pytest.fixture
def worlds(compiled: Any) -> tuple[Any, Any, Any]:
    model, data = mjw.put_model(compiled), mjw.make_data(compiled, nworld=WORLDS)
    return model, data, adapter.BlocksOfWorlds(GRID, compiled, model, data)


def _touching(level: int, cell: int) -> list[float]:
    """A pose of the ball a millimetre deep in the middle of a block."""
    i, j = divmod(cell, GRID.shape[1])
    return [1 + (i - 1.5) * 0.1, 2 + (j - 3.5) * 0.1, 0.5 + level * 0.05 + RADIUS - 0.001, 1, 0, 0, 0]


def _expected(compiled: Any, levels: np.ndarray, poses: list[list[float]]) -> Iterator[list[tuple[float, ...]]]:
    """Depth, place and friction of the contacts in MuJoCo, world by world."""
    state = mujoco.MjData(compiled)
    for own, pose in zip(levels, poses, strict=True):
        GRID.write(compiled, own)
        state.qpos[:] = pose
        mujoco.mj_forward(compiled, state)
        yield sorted((c.dist, *c.pos, c.friction[0]) for c in state.contact[: state.ncon])


def test_each_cell_of_each_world_is_that_of_its_map(compiled: Any, worlds: Any) -> None:
    model, data, blocks = worlds
    levels = rsegen.build_many(RECIPE, range(WORLDS))
    blocks.write(levels)
    new = rsegen.build_many(RECIPE, range(100, 103))
    blocks.write(new, worlds=[30, 0, 7])
    levels[[30, 0, 7]] = new
    poses = [_touching(own.flat[world % own.size], world % own.size) for world, own in enumerate(levels)]
    data.qpos.assign(np.array(poses, dtype=np.float32))
    mjw.fwd_position(model, data)
    count, contact = int(data.nacon.numpy()[0]), data.contact
    figures = [contact.dist, contact.pos, contact.friction]
    dist, pos, friction = (figure.numpy()[:count] for figure in figures)
    rows = np.column_stack([dist, pos, friction[:, 0]])
    of = contact.worldid.numpy()[:count]
    for world, expected in enumerate(_expected(compiled, levels, poses)):
        found = sorted(map(tuple, rows[of == world]))
        assert len(found) == len(expected) >= 1
        assert np.allclose(found, expected, atol=2e-6)


def test_balls_rest_on_the_maps_of_their_worlds(worlds: Any) -> None:
    model, data, blocks = worlds
    for first in (0, 50):
        levels = rsegen.build_many(RECIPE, range(first, first + WORLDS))
        blocks.write(levels)
        mjw.reset_data(model, data)
        data.qpos.assign(np.array([[1.05, 2.05, 0.82, 1, 0, 0, 0]] * WORLDS, dtype=np.float32))
        for _ in range(250):
            mjw.step(model, data)
        assert data.qpos.numpy()[:, 2] == pytest.approx(0.5 + levels[:, 2, 4] * 0.05 + RADIUS, abs=0.001)


def test_the_ground_follows_the_blocks(compiled: Any, worlds: Any) -> None:
    *_, blocks = worlds
    levels = rsegen.build_many(RECIPE, range(WORLDS))
    blocks.write(levels)
    blocks.write(levels[:2], worlds=[30, 4])
    levels[[30, 4]] = levels[:2]
    poses = [_touching(own.flat[world % own.size], world % own.size) for world, own in enumerate(levels)]
    bottoms = np.array(poses)[:, None, :3] - (0, 0, RADIUS - 0.001)
    assert blocks.ground.heights(bottoms)[:, 0] == pytest.approx(bottoms[:, 0, 2])
    assert blocks.ground.lift(bottoms) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("kind", ["int64", "uint8"])
def test_tensors_are_written_as_arrays_are(worlds: Any, kind: str) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    model, data, blocks = worlds
    arrays = [model.geom_pos, data.geom_xpos, model.geom_size, model.geom_rgba, model.geom_friction]
    levels = rsegen.build_many(RECIPE, range(WORLDS))
    blocks.write(levels)
    expected = [array.numpy().copy() for array in arrays]
    assert np.allclose(expected[0][:, :32], GRID.pos(levels), atol=1e-6)
    blocks.write(levels[::-1].copy())
    assert not np.allclose(arrays[0].numpy(), expected[0], atol=1e-6)
    blocks.write(torch.as_tensor(levels), torch.arange(WORLDS, dtype=getattr(torch, kind)))
    for array, values in zip(arrays, expected, strict=True):
        assert np.allclose(array.numpy(), values, atol=1e-6)


def test_colours_match_the_levels(worlds: Any) -> None:
    model, _, blocks = worlds
    levels = rsegen.build_many(RECIPE, range(WORLDS))
    blocks.write(levels)
    assert np.allclose(model.geom_rgba.numpy()[:, :32], GRID.rgba(levels))


def test_too_few_maps_are_refused(worlds: Any) -> None:
    *_, blocks = worlds
    with pytest.raises(ParameterError, match=r"levels: of shape \(3, 4, 8\); expected \(32, 4, 8\)"):
        blocks.write(rsegen.build_many(RECIPE, range(3)))
    with pytest.raises(ParameterError, match=r"worlds: 1..32 are not all in 0..31"):
        blocks.write(rsegen.build_many(RECIPE, range(2)), worlds=[1, 32])
    with pytest.raises(ParameterError, match=r"levels: of shape \(3, 4, 8\); expected \(2, 4, 8\)"):
        blocks.write(rsegen.build_many(RECIPE, range(3)), worlds=[0, 1])


@pytest.mark.parametrize("given", [np.ones(WORLDS, dtype=bool), np.arange(WORLDS) / 2], ids=["a mask", "halves"])
def test_worlds_that_are_no_indices_are_refused(worlds: Any, given: np.ndarray) -> None:
    *_, blocks = worlds
    with pytest.raises(ParameterError, match=r"worlds: array\(.*\) is not a list of indices of worlds"):
        blocks.write(rsegen.build_many(RECIPE, range(WORLDS)), worlds=given)


def test_no_worlds_begin_anew(worlds: Any) -> None:
    model, _, blocks = worlds
    levels = rsegen.build_many(RECIPE, range(WORLDS))
    blocks.write(levels)
    blocks.write(levels[:0], worlds=[])
    assert np.allclose(model.geom_size.numpy()[:, :32], GRID.size(levels))


def test_tensors_of_another_shape_are_refused_and_levels_kept_within_those_of_the_recipe(worlds: Any) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    model, _, blocks = worlds
    levels = torch.as_tensor(rsegen.build_many(RECIPE, range(WORLDS)))
    blocks.write(levels)
    for given in (levels[:1], levels[:3].reshape(3, 8, 4), levels[:3] * 0.5):
        with pytest.raises(
            ParameterError, match=r"levels: .* of shape .*; expected integers, .*, of shape \(3, 4, 8\)"
        ):
            blocks.write(given, torch.arange(3))
    blocks.write(levels[:0], torch.arange(0))
    assert np.allclose(model.geom_size.numpy()[:, :32], GRID.size(levels.numpy()))
    blocks.write(levels[:2] * 0 + torch.tensor([-3, 9])[:, None, None], torch.arange(2))
    assert np.allclose(
        model.geom_size.numpy()[:2, :32], GRID.size(np.array([0, 5])[:, None, None] + 0 * levels[:2].numpy())
    )


def test_tensors_are_written_without_numbers_of_the_host(worlds: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    *_, blocks = worlds
    levels, rows = torch.as_tensor(rsegen.build_many(RECIPE, range(3))), torch.arange(3)

    def sent(*_: Any, **__: Any) -> Any:
        raise AssertionError("numbers are sent to the device")

    for owner, name in ((torch, "asarray"), (torch, "tensor"), (torch.Tensor, "new_tensor")):
        monkeypatch.setattr(owner, name, sent)
    blocks.write(levels, rows)


def test_boxes_slide_as_far_as_the_friction_of_their_level_lets_them() -> None:
    """By v^2 / (2 mu g), across the seams of blocks; world k is level at level k + 1."""
    friction = np.array(RECIPE.level_friction)
    grid, spec = BlockGrid(replace(RECIPE, chunk_size=12, chunks=(1, 1))), mujoco.MjSpec()
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100  # contacts hardly creep
    grid.add_to(spec)
    body = spec.worldbody.add_body()
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.08, 0.06, 0.02], friction=[1e-3, 1e-3, 1e-3])
    compiled = spec.compile()
    model, data = mjw.put_model(compiled), mjw.make_data(compiled, nworld=len(friction), njmax=128)
    blocks = adapter.BlocksOfWorlds(grid, compiled, model, data)
    levels = np.broadcast_to(np.arange(1, 6, dtype=np.int16)[:, None, None], (5, 12, 12))
    blocks.write(levels)
    qpos, qvel = np.zeros((5, 7)), np.zeros((5, 6))
    qpos[:, :2], qpos[:, 2], qpos[:, 3] = (-0.45, 0.02), 0.05 * np.arange(1, 6) + 0.02, 1
    qvel[:, 0] = 1.2
    data.qpos.assign(qpos.astype(np.float32))
    data.qvel.assign(qvel.astype(np.float32))
    for _ in range(400):
        mjw.step(model, data)
    after = data.qpos.numpy()
    assert after[:, 0] + 0.45 == pytest.approx(1.2**2 / (2 * friction * 9.81), rel=0.02)
    assert np.abs(data.qvel.numpy()).max() < 0.01
