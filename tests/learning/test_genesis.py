"""A field as Genesis's height field: spheres rest on its blocks, its Go2 stands on them, and a policy learns a step."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import rsegen
from tests.support.late_import import LateImport
from tests.support.policy_step import learn

gs = LateImport("genesis", reason="Genesis is not installed: with PyTorch it is a download of gigabytes")
torch = LateImport("torch", reason="PyTorch is not installed: it is a download of gigabytes")
adapter = LateImport("rsegen.learning.genesis", reason="Genesis is not installed")

pytestmark = pytest.mark.long(reason="Genesis, which compiles its kernels for minutes")

SHAPE: dict[str, Any] = {"seed": 7, "boundary": "none"}


@pytest.fixture(scope="module", autouse=True)
def started() -> Iterator[None]:
    pytest.importorskip("genesis", reason="Genesis is not installed: with PyTorch it is a download of gigabytes")
    # Optimizers of PyTorch import Triton, whose LLVM crashes if it is loaded after Genesis has compiled by its own.
    importlib.import_module("torch._dynamo")
    gs.init(backend=gs.cpu, logging_level="warning")
    yield
    gs.destroy()


def scene_with(field: rsegen.StepField, pos: tuple[float, float, float] = (0, 0, 0), **options: Any) -> tuple[Any, Any]:
    """A scene with the field as its terrain, and the terrain."""
    scene = gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(**options))
    return scene, scene.add_entity(adapter.terrain_morph(field, pos), material=gs.materials.Rigid(friction=0.8))


def test_spheres_rest_on_blocks() -> None:
    field = rsegen.build(rsegen.Recipe(**SHAPE, chunk_size=6, unit_cm=4, obstacles=[rsegen.Random(levels=4)]))
    pos, radius = (1.0, -2.0, 0.3), 0.02
    scene, _ = scene_with(field, pos, dt=0.005)
    x, y = (middles + shift for middles, shift in zip(field.middles(), pos, strict=False))
    cells = [tuple(cell) for level in range(4) for cell in np.argwhere(field.levels == level)[:3].tolist()]
    assert len(cells) == 12
    places = {(float(x[i]), float(y[j])): float(field.heights[i, j]) + pos[2] for i, j in cells}
    spheres = {
        place: scene.add_entity(gs.morphs.Sphere(radius=radius, pos=(*place, top + radius + 0.01)))
        for place, top in places.items()
    }
    scene.build()
    for _ in range(300):
        scene.step()
    for place, top in places.items():
        assert spheres[place].get_pos().tolist() == pytest.approx([*place, top + radius], abs=2e-4)


def test_go2_stands_on_blocks_and_a_policy_learns_a_step() -> None:
    recipe = rsegen.Recipe(**SHAPE, chunk_size=20, unit_cm=3, obstacles=[rsegen.Random(levels=5)])
    field, worlds = rsegen.build(recipe), 4
    ground = rsegen.Ground(recipe, torch.as_tensor(np.array(field.levels)))
    scene, terrain = scene_with(field, dt=0.01, substeps=2)
    go2 = scene.add_entity(gs.morphs.URDF(file="urdf/go2/urdf/go2.urdf", pos=(0, 0, 0.5)))
    scene.build(n_envs=worlds)
    legs = [f"{leg}_{joint}_joint" for leg in ("FR", "FL", "RR", "RL") for joint in ("hip", "thigh", "calf")]
    joints = [go2.get_joint(joint).dofs_idx_local[0] for joint in legs]
    stance = torch.tensor([0.0, 0.8, -1.5] * 4).repeat(worlds, 1)
    go2.set_dofs_kp([60.0] * 12, joints)
    go2.set_dofs_kv([2.0] * 12, joints)
    go2.set_dofs_position(stance, joints)
    start = torch.tensor([[-0.4, -0.3], [0.4, 0.3], [-0.3, 0.4], [0.0, 0.0]])
    go2.set_pos(torch.cat([start, 0.36 + ground.highest(start, 0.4)[:, None]], dim=1))

    def move(targets: Any, steps: int) -> None:
        go2.control_dofs_position(targets, joints)
        for _ in range(steps):
            scene.step()

    move(stance, 100)
    assert go2.get_pos()[:, 2].min() > 0.2
    contacts = go2.get_contacts(with_entity=terrain)
    touches = contacts["valid_mask"]
    assert (touches.sum(dim=1) >= 3).all()
    points = contacts["position"][touches]
    below, around = ground.heights(points), ground.highest(points, 0.03)
    # On top of a block, or on the slope beside a higher one.
    assert (points[:, 2] > below - 0.01).all()
    assert (points[:, 2] < around + 0.01).all()
    assert len(torch.unique(below)) >= 3

    pattern = torch.as_tensor(rsegen.scan_points((0.8, 0.6), 0.2), dtype=torch.float32)

    def observe() -> Any:
        place, joint = go2.get_pos(), go2.get_dofs_position(joints)
        poses = torch.cat([place, torch.zeros(worlds, 1)], dim=1)
        return torch.cat([joint, go2.get_vel(), ground.scan(pattern, poses)], dim=1)

    def act(actions: Any) -> Any:
        """Move the legs about their stance for 0.1 s; the reward is the velocity along x."""
        move(stance + 0.2 * actions, 10)
        return go2.get_vel()[:, 0]

    observed, _ = learn(observe, act, 12, steps=8)
    scans = observed[0, :, -len(pattern) :]
    assert (scans.std(dim=1) > 0.02).all()
    assert len(torch.unique(scans[0].round(decimals=3))) >= 4
